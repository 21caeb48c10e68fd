//! Points as a surface that can be drawn: a small square for each, across its normal.

use crease::colour::linear_byte_from_srgb;
use crease::render::{DrawnSurface, DrawnVertex};
use glam::Vec3A;

/// What a point without a colour looks like: clay, linear.
pub const CLAY: [u8; 3] = [96, 97, 102];

/// Squares, four vertices each.
pub struct Splats {
    /// What is drawn.
    pub surface: DrawnSurface,
    /// Its vertices, metres.
    pub positions: Vec<Vec3A>,
    /// Their unit normals.
    pub normals: Vec<Vec3A>,
}

/// Squares of `half_width` metres about `points`, across `normals`, in sRGB `colours` or else clay.
pub fn splats(points: &[Vec3A], normals: &[Vec3A], colours: Option<&[[u8; 3]]>, half_width: f32) -> Splats {
    let mut positions = Vec::with_capacity(4 * points.len());
    let mut vertices = Vec::with_capacity(4 * points.len());
    let mut triangles = Vec::with_capacity(2 * points.len());
    for (index, (&point, &normal)) in points.iter().zip(normals).enumerate() {
        let normal = if normal == Vec3A::ZERO { Vec3A::Z } else { normal };
        let (along, across) = normal.any_orthonormal_pair();
        let first = positions.len() as u32;
        let [red, green, blue] = colours.map_or(CLAY, |colours| colours[index].map(linear_byte_from_srgb));
        for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            vertices.push(DrawnVertex {
                body_vertex: positions.len() as u32,
                texture_coordinates: [0.0; 2],
                colour: [red, green, blue, 255],
            });
            positions.push(point + half_width * (a * along + b * across));
        }
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let normals = normals.iter().flat_map(|&normal| [normal; 4]).collect();
    Splats { surface: DrawnSurface { vertices, levels: vec![triangles] }, positions, normals }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_square_faces_along_its_normal() {
        let normal = Vec3A::new(0.6, 0.0, -0.8);
        let splats = splats(&[Vec3A::ONE], &[normal], None, 0.1);
        for [a, b, c] in splats.surface.levels[0].iter().map(|t| t.map(|v| splats.positions[v as usize])) {
            assert!((b - a).cross(c - a).normalize().distance(normal) < 1e-5);
        }
        assert_eq!(splats.positions.iter().sum::<Vec3A>() / 4.0, Vec3A::ONE);
        assert_eq!(splats.normals, [normal; 4]);
    }

    #[test]
    fn colours_survive_the_way_to_linear_and_back() {
        for encoded in [0u8, 60, 128, 255] {
            let splats = splats(&[Vec3A::ZERO], &[Vec3A::Z], Some(&[[encoded; 3]]), 0.1);
            let back = splats.surface.vertices[0].srgb()[0];
            assert!(back.abs_diff(encoded) <= 4, "{encoded} came back as {back}");
        }
    }
}
