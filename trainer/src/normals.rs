//! Normals: of points, by the plane of a neighbourhood, and of surfaces.

use crate::nearest::{NearestPoints, Neighbour};
use crease::mesh::{Triangle, vertex_normals};
use glam::Vec3A;
use parry3d::math::{Mat3, SymmetricEigen3, Vec3};
use rayon::prelude::*;
use std::num::NonZero;

/// Neighbours whose plane is the normal of a scan's point.
const SCAN_NEIGHBOURS: usize = 16;

/// Unit normal of the plane of each point's `neighbour_count` nearest points (itself included), by principal components.
///
/// The sign is arbitrary. `nearest` is over `points`.
pub fn point_normals(points: &[Vec3A], nearest: &NearestPoints, neighbour_count: usize) -> Vec<Vec3A> {
    let count = NonZero::new(neighbour_count).unwrap_or(NonZero::<usize>::MIN);
    points
        .par_iter()
        .with_min_len(256)
        .map(|&point| principal_frame(points, point, &nearest.several(point, count))[2])
        .collect()
}

/// [`point_normals`] of a scan that comes without normals.
pub fn scan_normals(points: &[Vec3A]) -> Vec<Vec3A> {
    point_normals(points, &NearestPoints::new(points), SCAN_NEIGHBOURS)
}

/// Right-handed orthonormal frame of a neighbourhood: largest spread first, the plane's normal last (sign arbitrary).
pub(crate) fn principal_frame(points: &[Vec3A], origin: Vec3A, neighbours: &[Neighbour]) -> [Vec3A; 3] {
    let offsets = || neighbours.iter().map(|neighbour| points[neighbour.index as usize] - origin);
    let mean = offsets().sum::<Vec3A>() / neighbours.len().max(1) as f32;
    // Scaled to unit size: the eigenvalues of a neighbourhood in metres would be tiny.
    let scale = 1.0 / offsets().map(|offset| offset.length()).fold(1e-12, f32::max);
    let mut columns = [Vec3A::ZERO; 3];
    for offset in offsets() {
        let d = (offset - mean) * scale;
        for (axis, column) in columns.iter_mut().enumerate() {
            *column += d * d[axis];
        }
    }
    let covariance = Mat3::from_cols_array_2d(&columns.map(|column| column.to_array()));
    let axes = SymmetricEigen3::new(covariance).eigenvectors;
    let vector = |axis: Vec3| Vec3A::from_array(axis.to_array());
    let normal = vector(axes.x_axis).try_normalize().unwrap_or(Vec3A::Y);
    let first = vector(axes.z_axis).reject_from_normalized(normal).try_normalize();
    let first = first.unwrap_or_else(|| normal.any_orthonormal_vector());
    [first, normal.cross(first), normal]
}

/// Unit normals at the vertices of a mesh.
pub fn unit_normals(positions: &[Vec3A], triangles: &[Triangle]) -> Vec<Vec3A> {
    let mut normals = vec![Vec3A::ZERO; positions.len()];
    vertex_normals(positions, triangles, &mut normals);
    normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::sphere_points;

    #[test]
    fn normals_of_a_sphere_are_radial() {
        let points = sphere_points(5_000, 0.3, 1);
        for (normal, point) in point_normals(&points, &NearestPoints::new(&points), 16).iter().zip(&points) {
            assert!((normal.length() - 1.0).abs() < 1e-5);
            assert!(normal.dot(point.normalize()).abs() > 0.99, "{normal} at {point}");
        }
    }

    #[test]
    fn frames_are_orthonormal_even_of_one_point() {
        let points = [Vec3A::ONE];
        let [a, b, c] = principal_frame(&points, points[0], &NearestPoints::new(&points).within(points[0], 1.0));
        for (dot, expected) in [(a.dot(b), 0.0), (b.dot(c), 0.0), (a.dot(c), 0.0), (a.dot(a), 1.0), (c.dot(c), 1.0)] {
            assert!((dot - expected).abs() < 1e-5);
        }
    }
}
