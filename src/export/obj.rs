//! Wavefront OBJ. Colours follow the positions, as many programs read them; v of texture coordinates counts from below.

use super::ExportedMesh;
use std::fmt::Write;

pub(super) fn encode(mesh: &ExportedMesh) -> String {
    let mut text = String::new();
    for (vertex, p) in mesh.positions.iter().enumerate() {
        append(&mut text, format_args!("v {:.6} {:.6} {:.6}", p.x, p.y, p.z));
        if let Some(colour) = mesh.colours.get(vertex) {
            let [r, g, b] = colour.map(|channel| f32::from(channel) / 255.0);
            append(&mut text, format_args!(" {r:.4} {g:.4} {b:.4}"));
        }
        text.push('\n');
    }
    for [u, v] in &mesh.texture_coordinates {
        append(&mut text, format_args!("vt {u:.6} {:.6}\n", 1.0 - v));
    }
    for n in &mesh.normals {
        append(&mut text, format_args!("vn {:.6} {:.6} {:.6}\n", n.x, n.y, n.z));
    }
    let has_texture = !mesh.texture_coordinates.is_empty();
    for triangle in &mesh.triangles {
        text.push('f');
        for vertex in triangle.map(|vertex| vertex + 1) {
            match has_texture {
                true => append(&mut text, format_args!(" {vertex}/{vertex}/{vertex}")),
                false => append(&mut text, format_args!(" {vertex}//{vertex}")),
            }
        }
        text.push('\n');
    }
    text
}

fn append(text: &mut String, words: std::fmt::Arguments<'_>) {
    text.write_fmt(words).expect("a string takes all");
}

#[cfg(test)]
mod tests {
    use super::super::tests::square;
    use super::*;

    #[test]
    fn faces_count_from_one() {
        let text = encode(&square());
        assert!(text.starts_with("v 0.000000 0.000000 0.000000\n") && text.contains("vn 0.000000 0.000000 1.000000\n"));
        assert!(text.ends_with("f 1//1 2//2 3//3\nf 1//1 3//3 4//4\n"), "{text}");
    }

    #[test]
    fn texture_coordinates_are_turned_over_and_colours_follow() {
        let mut mesh = square();
        mesh.texture_coordinates = vec![[0.25, 0.0]; 4];
        mesh.colours = vec![[255, 0, 51]; 4];
        let text = encode(&mesh);
        assert!(text.contains("v 1.000000 0.000000 0.000000 1.0000 0.0000 0.2000\n"), "{text}");
        assert!(text.contains("vt 0.250000 1.000000\n") && text.contains("f 1/1/1 2/2/2 3/3/3\n"), "{text}");
    }
}
