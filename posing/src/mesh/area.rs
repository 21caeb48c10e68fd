//! Mixed Voronoi areas (Meyer et al. 2003), the a_k of paper Eq. cotLap.

use super::Triangle;
use glam::{Vec3A, vec3a};

/// Mixed Voronoi area of each vertex in m², written to `areas` (length V).
///
/// The areas of all vertices sum to the surface's area. A triangle without area adds nothing.
pub fn mixed_voronoi_areas(positions: &[Vec3A], triangles: &[Triangle], areas: &mut [f32]) {
    areas.fill(0.0);
    for &[a, b, c] in triangles {
        let [p, q, r] = [a, b, c].map(|i| positions[i as usize]);
        let shares = corner_shares(p, q, r);
        areas[a as usize] += shares.x;
        areas[b as usize] += shares.y;
        areas[c as usize] += shares.z;
    }
}

/// The parts of a triangle's area that belong to its three corners.
fn corner_shares(p: Vec3A, q: Vec3A, r: Vec3A) -> Vec3A {
    let (pq, qr, rp) = (q - p, r - q, p - r);
    let twice_area = pq.cross(qr).length();
    if twice_area <= f32::MIN_POSITIVE {
        return Vec3A::ZERO;
    }
    // |edge| |edge| cos of the angle at p, q, r: negative where obtuse.
    let dots = -vec3a(pq.dot(rp), qr.dot(pq), rp.dot(qr));
    if dots.min_element() < 0.0 {
        let obtuse = Vec3A::select(dots.cmplt(Vec3A::ZERO), Vec3A::splat(0.25), Vec3A::splat(0.125));
        return twice_area * obtuse;
    }
    // Voronoi: an eighth of each adjacent edge squared times the cotangent opposite to it.
    let opposite = dots * vec3a(qr.length_squared(), rp.length_squared(), pq.length_squared());
    let sum = opposite.element_sum();
    (Vec3A::splat(sum) - opposite) / (8.0 * twice_area)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_meshes::{grid, icosphere, noise_vectors, torus};
    use std::f32::consts::PI;

    fn areas_of(positions: &[Vec3A], triangles: &[Triangle]) -> Vec<f32> {
        let mut areas = vec![-1.0; positions.len()];
        mixed_voronoi_areas(positions, triangles, &mut areas);
        areas
    }

    #[test]
    fn sum_is_the_surface_area_also_with_obtuse_triangles() {
        let mut mesh = torus(24, 12);
        for (p, noise) in mesh.positions.iter_mut().zip(noise_vectors(288, 1)) {
            *p += 0.05 * noise;
        }
        let surface: f32 = mesh
            .triangles
            .iter()
            .map(|&[a, b, c]| [a, b, c].map(|i| mesh.positions[i as usize]))
            .map(|[p, q, r]| 0.5 * (q - p).cross(r - p).length())
            .sum();
        let sum: f32 = areas_of(&mesh.positions, &mesh.triangles).iter().sum();
        assert!((sum / surface - 1.0).abs() < 1e-5, "{sum} against {surface}");
    }

    #[test]
    fn known_triangles() {
        // Equilateral: a third each. Right angle: half at the right angle. Obtuse (Meyer 2003, Fig. 4): a half there, a quarter elsewhere.
        let equilateral = [vec3a(0.0, 0.0, 0.0), vec3a(2.0, 0.0, 0.0), vec3a(1.0, 3f32.sqrt(), 0.0)];
        let right = [vec3a(0.0, 0.0, 0.0), vec3a(2.0, 0.0, 0.0), vec3a(0.0, 4.0, 0.0)];
        let obtuse = [vec3a(0.0, 0.0, 0.0), vec3a(4.0, 0.0, 0.0), vec3a(-1.0, 2.0, 0.0)];
        let third = 3f32.sqrt() / 3.0;
        for (corners, expected) in
            [(equilateral, [third, third, third]), (right, [2.0, 1.0, 1.0]), (obtuse, [2.0, 1.0, 1.0])]
        {
            for (area, expected) in areas_of(&corners, &[[0, 1, 2]]).iter().zip(expected) {
                assert!((area - expected).abs() < 1e-5, "{area} against {expected}");
            }
        }
    }

    #[test]
    fn sphere_and_grid() {
        let sphere = icosphere(4);
        let sum: f32 = areas_of(&sphere.positions, &sphere.triangles).iter().sum();
        assert!((sum / (4.0 * PI) - 1.0).abs() < 3e-3, "{sum}");

        let sheet = grid(4, 4);
        let areas = areas_of(&sheet.positions, &sheet.triangles);
        assert_eq!((areas[12], areas[2], areas[0]), (1.0, 0.5, 0.25));
    }

    #[test]
    fn a_triangle_without_area_adds_nothing() {
        let areas = areas_of(&[Vec3A::X, Vec3A::Y, Vec3A::Y], &[[0, 1, 2]]);
        assert_eq!(areas, [0.0; 3]);
    }
}
