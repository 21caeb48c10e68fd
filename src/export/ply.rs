//! PLY, binary little endian.

use super::ExportedMesh;
use std::fmt::Write;

pub(super) fn encode(mesh: &ExportedMesh) -> Vec<u8> {
    let mut bytes = header(mesh).into_bytes();
    for (vertex, (position, normal)) in mesh.positions.iter().zip(&mesh.normals).enumerate() {
        let coordinates = mesh.texture_coordinates.get(vertex).into_iter().flatten().copied();
        let numbers = position.to_array().into_iter().chain(normal.to_array()).chain(coordinates);
        numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend(mesh.colours.get(vertex).into_iter().flatten());
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        triangle.iter().for_each(|vertex| bytes.extend(vertex.to_le_bytes()));
    }
    bytes
}

fn header(mesh: &ExportedMesh) -> String {
    let mut text = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.positions.len());
    let mut properties = |kind: &str, names: &[&str], wanted: bool| {
        for name in names.iter().filter(|_| wanted) {
            writeln!(text, "property {kind} {name}").expect("a string takes all");
        }
    };
    properties("float", &["x", "y", "z", "nx", "ny", "nz"], true);
    properties("float", &["s", "t"], !mesh.texture_coordinates.is_empty());
    properties("uchar", &["red", "green", "blue"], !mesh.colours.is_empty());
    text + &format!("element face {}\nproperty list uchar uint vertex_indices\nend_header\n", mesh.triangles.len())
}

#[cfg(test)]
mod tests {
    use super::super::tests::square;
    use super::*;

    #[test]
    fn as_many_bytes_follow_as_the_header_says() {
        let mut mesh = square();
        let (vertices, faces) = (4, 2);
        assert_eq!(encode(&mesh).len(), header(&mesh).len() + vertices * 24 + faces * 13);
        mesh.texture_coordinates = vec![[0.0; 2]; vertices];
        mesh.colours = vec![[1, 2, 3]; vertices];
        let bytes = encode(&mesh);
        assert_eq!(bytes.len(), header(&mesh).len() + vertices * (24 + 8 + 3) + faces * 13);
        assert!(header(&mesh).contains("property float t\nproperty uchar red\n"));
        let first = &bytes[header(&mesh).len()..][..35];
        assert_eq!(first[20..24], 1.0_f32.to_le_bytes(), "nz of the first vertex");
        assert_eq!(first[32..], [1, 2, 3]);
    }
}
