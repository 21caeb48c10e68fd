//! The closest point on a triangle mesh, edges and vertices included.

use crease::mesh::Triangle;
use glam::Vec3A;
use parry3d::math::Vector;
use parry3d::query::PointQueryWithLocation;
use parry3d::shape::{TriMesh, TriMeshBuilderError, TrianglePointLocation};
use rayon::prelude::*;

/// A point of a mesh's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric coordinates over the triangle's corners: none negative, sum 1.
    pub barycentric: [f32; 3],
}

impl SurfacePoint {
    /// `values` (one a vertex) interpolated at this point.
    pub fn interpolate<T>(&self, triangles: &[Triangle], values: &[T]) -> T
    where
        T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
    {
        let [a, b, c] = triangles[self.triangle as usize].map(|vertex| values[vertex as usize]);
        let [u, v, w] = self.barycentric;
        a * u + b * v + c * w
    }
}

/// A mesh made ready for closest-point queries by a bounding volume hierarchy.
pub struct ClosestPoint {
    mesh: TriMesh,
}

impl ClosestPoint {
    /// Builds the hierarchy. Fails on a mesh without triangles.
    pub fn new(positions: &[Vec3A], triangles: &[Triangle]) -> Result<Self, TriMeshBuilderError> {
        let vertices = positions.iter().map(|point| Vector::from_array(point.to_array())).collect();
        Ok(Self { mesh: TriMesh::new(vertices, triangles.to_vec())? })
    }

    /// The surface point closest to `point`.
    ///
    /// # Panics
    ///
    /// If `point` is not finite: then nothing is closest.
    pub fn query(&self, point: Vec3A) -> SurfacePoint {
        let point = Vector::from_array(point.to_array());
        let (_, (triangle, location)) = self.mesh.project_local_point_and_get_location(point, false);
        SurfacePoint { triangle, barycentric: barycentric(location) }
    }

    /// [`Self::query`] for many points, in parallel.
    pub fn query_all(&self, points: &[Vec3A]) -> Vec<SurfacePoint> {
        points.par_iter().with_min_len(256).map(|&point| self.query(point)).collect()
    }
}

fn barycentric(location: TrianglePointLocation) -> [f32; 3] {
    let mut coordinates = [0.0; 3];
    match location {
        TrianglePointLocation::OnVertex(corner) => coordinates[corner as usize] = 1.0,
        TrianglePointLocation::OnEdge(edge, [first, second]) => {
            let [a, b] = [[0, 1], [1, 2], [0, 2]][edge as usize];
            coordinates[a] = first;
            coordinates[b] = second;
        }
        TrianglePointLocation::OnFace(_, inside) => coordinates = inside.map(|value| value.clamp(0.0, 1.0)),
        TrianglePointLocation::OnSolid => unreachable!("a surface has no inside"),
    }
    coordinates
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random_points;
    use crate::shapes::sphere;

    /// Closest point on one triangle by projecting onto its plane and its three edges.
    fn brute_triangle(point: Vec3A, [a, b, c]: [Vec3A; 3]) -> Vec3A {
        let normal = (b - a).cross(c - a).normalize();
        let foot = point - normal * (point - a).dot(normal);
        let inside =
            [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| (to - from).cross(foot - from).dot(normal) >= 0.0);
        if inside {
            return foot;
        }
        let on_edge = |(from, to): (Vec3A, Vec3A)| {
            let t = (point - from).dot(to - from) / (to - from).length_squared();
            from + (to - from) * t.clamp(0.0, 1.0)
        };
        let edges = [(a, b), (b, c), (c, a)].map(on_edge);
        edges.into_iter().min_by(|p, q| point.distance(*p).total_cmp(&point.distance(*q))).unwrap()
    }

    #[test]
    fn agrees_with_brute_force() {
        let mesh = sphere(1.0, 2);
        let closest = ClosestPoint::new(&mesh.positions, &mesh.triangles).unwrap();
        for (index, point) in random_points(300, 1.6, 7).into_iter().enumerate() {
            let found = closest.query(point);
            let position = found.interpolate(&mesh.triangles, &mesh.positions);
            let distance = mesh
                .triangles
                .iter()
                .map(|triangle| brute_triangle(point, triangle.map(|v| mesh.positions[v as usize])).distance(point))
                .fold(f32::INFINITY, f32::min);
            assert!((position.distance(point) - distance).abs() < 1e-5, "point {index}");
            assert!(found.barycentric.iter().all(|&b| b >= 0.0));
            assert!((found.barycentric.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn vertices_and_edges_are_found() {
        let positions = [Vec3A::ZERO, Vec3A::X, Vec3A::Y];
        let closest = ClosestPoint::new(&positions, &[[0, 1, 2]]).unwrap();
        assert_eq!(closest.query(Vec3A::new(2.0, -1.0, 0.3)).barycentric, [0.0, 1.0, 0.0]);
        assert_eq!(closest.query(Vec3A::new(0.25, -1.0, 0.3)).barycentric, [0.75, 0.25, 0.0]);
        assert_eq!(closest.query(Vec3A::new(-1.0, 0.25, 0.3)).barycentric, [0.75, 0.0, 0.25]);
        assert_eq!(closest.query(Vec3A::new(1.0, 1.0, 0.0)).barycentric, [0.0, 0.5, 0.5]);
        assert_eq!(closest.query(Vec3A::new(0.25, 0.25, 9.0)).barycentric, [0.5, 0.25, 0.25]);
    }

    #[test]
    fn a_mesh_without_triangles_is_an_error() {
        assert!(ClosestPoint::new(&[Vec3A::ZERO], &[]).is_err());
    }
}
