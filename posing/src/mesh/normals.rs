//! Vertex normals.

use super::Triangle;
use glam::Vec3A;

/// Unit vertex normals, outward, area-weighted over the incident triangles; written to `normals` (length V).
///
/// Where no triangle gives a direction the normal is +y.
pub fn vertex_normals(positions: &[Vec3A], triangles: &[Triangle], normals: &mut [Vec3A]) {
    normals.fill(Vec3A::ZERO);
    for &[a, b, c] in triangles {
        let [p, q, r] = [a, b, c].map(|i| positions[i as usize]);
        let twice_area = (q - p).cross(r - p);
        for corner in [a, b, c] {
            normals[corner as usize] += twice_area;
        }
    }
    for normal in normals {
        *normal = normal.normalize_or(Vec3A::Y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_meshes::{cube, icosphere};

    #[test]
    fn sphere_normals_are_radial() {
        let sphere = icosphere(3);
        let mut normals = vec![Vec3A::ZERO; sphere.positions.len()];
        vertex_normals(&sphere.positions, &sphere.triangles, &mut normals);
        assert!(sphere.positions.iter().zip(&normals).all(|(p, n)| p.dot(*n) > 0.9995));
    }

    #[test]
    fn cube_corners_point_outward() {
        let cube = cube();
        let mut normals = vec![Vec3A::ZERO; 8];
        vertex_normals(&cube.positions, &cube.triangles, &mut normals);
        for (p, n) in cube.positions.iter().zip(&normals) {
            assert!((n.length() - 1.0).abs() < 1e-6 && n.dot(p.normalize()) > 0.8, "{p} {n}");
        }
    }

    #[test]
    fn a_lone_vertex_gets_a_unit_normal() {
        let mut normals = [Vec3A::ZERO];
        vertex_normals(&[Vec3A::X], &[], &mut normals);
        assert_eq!(normals, [Vec3A::Y]);
    }
}
