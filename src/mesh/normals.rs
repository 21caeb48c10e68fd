//! Vertex normals.

use super::Triangle;
use glam::Vec3A;

/// Unit vertex normals, outward, area-weighted over the incident triangles; written to `normals` (length V).
pub fn vertex_normals(positions: &[Vec3A], triangles: &[Triangle], normals: &mut [Vec3A]) {
    let _ = (positions, triangles, normals);
    todo!()
}
