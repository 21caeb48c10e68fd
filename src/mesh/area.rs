//! Mixed Voronoi areas (Meyer et al. 2003), the a_k of paper Eq. cotLap.

use super::Triangle;
use glam::Vec3A;

/// Mixed Voronoi area of each vertex in m², written to `areas` (length V).
///
/// The areas of all vertices sum to the surface's area.
pub fn mixed_voronoi_areas(positions: &[Vec3A], triangles: &[Triangle], areas: &mut [f32]) {
    let _ = (positions, triangles, areas);
    todo!()
}
