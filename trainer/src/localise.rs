//! Which point of the base mesh a scan point speaks for (paper, Localization).

use crate::closest::{ClosestPoint, SurfacePoint};
use crate::options::LocalisationOptions;
use crease::mesh::{Triangle, vertex_normals};
use crease::network::Domain;
use crease::pose_feature::PoseMask;
use glam::{Mat3A, Vec3A};

/// Projects scan points onto a posed mesh: the closest point, edges and vertices included.
///
/// `normals` are the scan's, one a point, signs arbitrary. Nothing for a point that is too far away or whose normal differs too much from
/// the mesh's interpolated vertex normal. Fails on a mesh without triangles.
pub fn localise(
    points: &[Vec3A],
    normals: &[Vec3A],
    positions: &[Vec3A],
    triangles: &[Triangle],
    options: &LocalisationOptions,
) -> anyhow::Result<Vec<Option<SurfacePoint>>> {
    let mut mesh_normals = vec![Vec3A::ZERO; positions.len()];
    vertex_normals(positions, triangles, &mut mesh_normals);
    let found = ClosestPoint::new(positions, triangles)?.query_all(points);
    let accepted = found.into_iter().zip(points.iter().zip(normals)).map(|(surface, (point, normal))| {
        let distance = surface.interpolate(triangles, positions).distance(*point);
        let cosine = surface.interpolate(triangles, &mesh_normals).normalize_or_zero().dot(*normal).abs();
        (distance <= options.greatest_distance && cosine >= options.least_cosine).then_some(surface)
    });
    Ok(accepted.collect())
}

/// What f_l is asked with, and how its answer turns, at a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// Q on the canonical body, metres.
    pub canonical: Vec3A,
    /// Mask of θ̄: joints that any corner of the triangle listens to.
    pub mask: PoseMask,
    /// Blended skinning matrix without its translation: canonical to posed.
    pub posed_from_canonical: Mat3A,
}

impl Query {
    /// Interpolates vertex data of one level. `rotations` are that level's blended matrices for the frame's pose.
    pub fn at(surface: &SurfacePoint, triangles: &[Triangle], domain: &Domain, rotations: &[Mat3A]) -> Self {
        let corners = triangles[surface.triangle as usize];
        Self {
            canonical: surface.interpolate(triangles, &domain.canonical),
            mask: PoseMask(corners.iter().fold(0, |bits, &corner| bits | domain.masks[corner as usize].0)),
            posed_from_canonical: surface.interpolate(triangles, rotations),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{sphere, sphere_points};

    const OPTIONS: LocalisationOptions = LocalisationOptions { greatest_distance: 0.05, least_cosine: 0.5 };

    /// Closest point by a dense grid over every triangle: an upper bound of the true distance, tight to the grid.
    fn brute_distance(point: Vec3A, positions: &[Vec3A], triangles: &[Triangle]) -> f32 {
        const STEPS: usize = 24;
        let mut best = f32::INFINITY;
        for triangle in triangles {
            let [a, b, c] = triangle.map(|vertex| positions[vertex as usize]);
            for i in 0..=STEPS {
                for j in 0..=STEPS - i {
                    let (u, v) = (i as f32 / STEPS as f32, j as f32 / STEPS as f32);
                    best = best.min(point.distance(a * (1.0 - u - v) + b * u + c * v));
                }
            }
        }
        best
    }

    #[test]
    fn agrees_with_brute_force() {
        let mesh = sphere(1.0, 1);
        let points: Vec<Vec3A> = sphere_points(60, 1.02, 8);
        let normals: Vec<Vec3A> = points.iter().map(|point| -point.normalize()).collect();
        let options = LocalisationOptions { greatest_distance: 1.0, least_cosine: 0.0 };
        let found = localise(&points, &normals, &mesh.positions, &mesh.triangles, &options).unwrap();
        for (surface, &point) in found.iter().zip(&points) {
            let distance = surface.unwrap().interpolate(&mesh.triangles, &mesh.positions).distance(point);
            let brute = brute_distance(point, &mesh.positions, &mesh.triangles);
            assert!(distance <= brute + 1e-6 && distance > brute - 0.01, "{distance} against {brute}");
        }
    }

    #[test]
    fn far_points_and_crossed_normals_are_rejected() {
        let mesh = sphere(1.0, 3);
        let accepted = |distance: f32, normal: Vec3A| {
            let points = [Vec3A::X * distance];
            localise(&points, &[normal], &mesh.positions, &mesh.triangles, &OPTIONS).unwrap()[0].is_some()
        };
        assert!(accepted(1.04, Vec3A::X));
        assert!(accepted(0.96, -Vec3A::X), "the sign of a scan's normal says nothing");
        assert!(!accepted(1.06, Vec3A::X), "too far");
        assert!(!accepted(1.0, Vec3A::Y), "across");
        assert!(accepted(1.0, Vec3A::new(0.6, 0.8, 0.0)) && !accepted(1.0, Vec3A::new(0.4, 0.9165, 0.0)));
    }

    #[test]
    fn queries_interpolate_their_triangle() {
        let domain = Domain {
            canonical: vec![Vec3A::ZERO, Vec3A::X, Vec3A::Y],
            masks: vec![PoseMask(0b0010), PoseMask(0b0100), PoseMask(0)],
        };
        let rotations = [Mat3A::IDENTITY, Mat3A::from_rotation_z(1.0), Mat3A::IDENTITY];
        let surface = SurfacePoint { triangle: 0, barycentric: [0.5, 0.25, 0.25] };
        let query = Query::at(&surface, &[[0, 1, 2]], &domain, &rotations);
        assert_eq!(query.canonical, Vec3A::new(0.25, 0.25, 0.0));
        assert_eq!(query.mask, PoseMask(0b0110));
        assert!((query.posed_from_canonical.x_axis.x - (0.75 + 0.25 * 1f32.cos())).abs() < 1e-6);
    }
}
