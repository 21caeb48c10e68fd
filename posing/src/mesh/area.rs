//! Mixed Voronoi areas (Meyer et al. 2003), the a_k of paper Eq. cotLap.

use super::Triangle;
use glam::{BVec4A, Mat4, Vec3A, Vec4};

/// Mixed Voronoi area of each vertex in m², written to `areas` (length V).
///
/// The areas of all vertices sum to the surface's area. A triangle without area adds nothing.
pub fn mixed_voronoi_areas(positions: &[Vec3A], triangles: &[Triangle], areas: &mut [f32]) {
    areas.fill(0.0);
    for_fours(triangles, |_, four| {
        let shares = shares(positions, four);
        for (i, triangle) in four.iter().enumerate() {
            for corner in 0..3 {
                areas[triangle[corner] as usize] += shares[corner][i];
            }
        }
    });
}

/// Calls `put` with the number of the first and with four triangles at a time, the last ones filled up with what has no area.
#[inline(always)]
fn for_fours(triangles: &[Triangle], mut put: impl FnMut(usize, &[Triangle; 4])) {
    let (fours, rest) = triangles.as_chunks();
    for (number, four) in fours.iter().enumerate() {
        put(4 * number, four);
    }
    if let Some(&[vertex, ..]) = rest.first() {
        let mut four = [[vertex; 3]; 4];
        four[..rest.len()].copy_from_slice(rest);
        put(4 * fours.len(), &four);
    }
}

/// The parts of the areas of four triangles, computed side by side, that belong to their corners: by corner, then by triangle.
#[inline(always)]
fn shares(positions: &[Vec3A], triangles: &[Triangle; 4]) -> [[f32; 4]; 3] {
    let corners = [0, 1, 2].map(|corner| Points::new(triangles.map(|triangle| positions[triangle[corner] as usize])));
    corner_shares(corners).map(|shares| shares.to_array())
}

/// [`mixed_voronoi_areas`] of one mesh in pose after pose, by all threads that there are.
#[derive(Clone, Debug)]
pub struct VertexAreas {
    #[cfg(feature = "threads")]
    corners: super::Incidence,
    /// The parts of each triangle's area that belong to its corners.
    #[cfg(feature = "threads")]
    shares: Vec<[f32; 3]>,
}

#[cfg(not(feature = "threads"))]
impl VertexAreas {
    /// For a mesh of `triangles` over `vertex_count` vertices.
    pub fn new(_vertex_count: usize, _triangles: &[Triangle]) -> Self {
        Self {}
    }

    /// See [`mixed_voronoi_areas`]; `triangles` are those that it was made for.
    pub fn put(&mut self, positions: &[Vec3A], triangles: &[Triangle], areas: &mut [f32]) {
        mixed_voronoi_areas(positions, triangles, areas);
    }
}

#[cfg(feature = "threads")]
impl VertexAreas {
    /// For a mesh of `triangles` over `vertex_count` vertices.
    pub fn new(vertex_count: usize, triangles: &[Triangle]) -> Self {
        let corners = super::Incidence::new(vertex_count, triangles);
        Self { corners, shares: vec![[0.0; 3]; triangles.len()] }
    }

    /// See [`mixed_voronoi_areas`]; `triangles` are those that it was made for.
    pub fn put(&mut self, positions: &[Vec3A], triangles: &[Triangle], areas: &mut [f32]) {
        use crate::threads::for_rows;
        for_rows(&mut self.shares, |first, of_triangles| {
            for_fours(&triangles[first..][..of_triangles.len()], |number, four| {
                let shares = shares(positions, four);
                for (i, of_triangle) in of_triangles[number..].iter_mut().take(4).enumerate() {
                    *of_triangle = [shares[0][i], shares[1][i], shares[2][i]];
                }
            });
        });
        let shares = self.shares.as_flattened();
        for_rows(areas, |first, areas| {
            for (area, corners) in areas.iter_mut().zip(self.corners.of_vertices(first)) {
                *area = corners.iter().fold(0.0, |sum, &corner| sum + shares[corner as usize]);
            }
        });
    }
}

/// Four points, a coordinate each.
#[derive(Clone, Copy)]
struct Points([Vec4; 3]);

impl Points {
    #[inline(always)]
    fn new(points: [Vec3A; 4]) -> Self {
        let [a, b, c, d] = points.map(|point| point.extend(0.0));
        let rows = Mat4::from_cols(a, b, c, d).transpose();
        Self([rows.x_axis, rows.y_axis, rows.z_axis])
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self([0, 1, 2].map(|axis| self.0[axis] - other.0[axis]))
    }

    #[inline(always)]
    fn dot(self, other: Self) -> Vec4 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.0[axis] * other.0[axis]);
        x + y + z
    }

    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([y * w - z * v, z * u - x * w, x * v - y * u])
    }
}

/// The parts of each of four triangles' areas that belong to its corners p, q and r.
#[inline(always)]
fn corner_shares([p, q, r]: [Points; 3]) -> [Vec4; 3] {
    let (pq, qr, rp) = (q.minus(p), r.minus(q), p.minus(r));
    let cross = pq.cross(qr);
    let twice_area = Vec4::from_array(cross.dot(cross).to_array().map(f32::sqrt));
    // |edge| |edge| cos of the angle at p, q, r: negative where obtuse.
    let dots = [(pq, rp), (qr, pq), (rp, qr)].map(|(before, after)| -before.dot(after));
    let is_obtuse = dots.map(|dot| dot.cmplt(Vec4::ZERO));
    let has_obtuse: BVec4A = is_obtuse[0] | is_obtuse[1] | is_obtuse[2];
    // Voronoi: an eighth of each adjacent edge squared times the cotangent opposite to it.
    let opposite = [(dots[0], qr), (dots[1], rp), (dots[2], pq)].map(|(dot, edge)| dot * edge.dot(edge));
    let sum = opposite[0] + opposite[1] + opposite[2];
    let scale = (8.0 * twice_area).recip();
    let has_area = twice_area.cmpgt(Vec4::splat(f32::MIN_POSITIVE));
    [0, 1, 2].map(|corner| {
        let voronoi = (sum - opposite[corner]) * scale;
        let halved = twice_area * Vec4::select(is_obtuse[corner], Vec4::splat(0.25), Vec4::splat(0.125));
        Vec4::select(has_area, Vec4::select(has_obtuse, halved, voronoi), Vec4::ZERO)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_meshes::{grid, icosphere, noise_vectors, torus};
    use glam::vec3a;
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
    fn pose_after_pose_they_are_the_same_to_the_bit() {
        // Not a multiple of four triangles, and more than one thread takes.
        let mut mesh = torus(61, 33);
        mesh.triangles.truncate(4025);
        let mut field = VertexAreas::new(mesh.positions.len(), &mesh.triangles);
        for seed in [1, 5000] {
            for (p, noise) in mesh.positions.iter_mut().zip(noise_vectors(61 * 33, seed)) {
                *p += 0.05 * noise;
            }
            let mut areas = vec![-1.0; mesh.positions.len()];
            field.put(&mesh.positions, &mesh.triangles, &mut areas);
            assert_eq!(areas, areas_of(&mesh.positions, &mesh.triangles));
        }
    }

    #[test]
    fn a_triangle_without_area_adds_nothing() {
        let areas = areas_of(&[Vec3A::X, Vec3A::Y, Vec3A::Y], &[[0, 1, 2]]);
        assert_eq!(areas, [0.0; 3]);
    }
}
