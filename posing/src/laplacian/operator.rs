//! L = I − D⁻¹A and the row scale s that turns δ (1/m) into metres: (L u)_k = s_k δ_k.
//!
//! Sign: δ = −Δu, so (L u)_k points outward where the surface bulges. A vertex without neighbours has an empty row.

use crate::mesh::Adjacency;
use crate::threads::for_rows;
use glam::Vec3A;
use std::f32::consts::PI;

/// out = L u, u_k minus the mean of its neighbours.
pub fn apply_topological(adjacency: &Adjacency, u: &[Vec3A], out: &mut [Vec3A]) {
    assert_eq!(u.len(), out.len());
    for (k, (out, &own)) in out.iter_mut().zip(u).enumerate() {
        let neighbours = adjacency.of(k);
        let sum: Vec3A = neighbours.iter().map(|&j| u[j as usize]).sum();
        *out = if neighbours.is_empty() { Vec3A::ZERO } else { own - sum / neighbours.len() as f32 };
    }
}

/// 1/N of a vertex with N neighbours, 1 for one without.
pub fn reciprocal_valence(valence: usize) -> f32 {
    (valence.max(1) as f32).recip()
}

/// 1/N_k of each vertex, 1 for a vertex without neighbours.
pub fn reciprocal_valences(adjacency: &Adjacency) -> Vec<f32> {
    (0..adjacency.vertex_count()).map(|k| reciprocal_valence(adjacency.valence(k))).collect()
}

/// out = Lᵀ x: x_k minus the sum over its neighbours j of x_j / N_j, with `reciprocal_valences` 1/N.
pub fn apply_topological_transposed(
    adjacency: &Adjacency,
    reciprocal_valences: &[f32],
    x: &[Vec3A],
    out: &mut [Vec3A],
) {
    assert_eq!(x.len(), out.len());
    for (k, (out, &own)) in out.iter_mut().zip(x).enumerate() {
        let neighbours = adjacency.of(k);
        let sum: Vec3A = neighbours.iter().map(|&j| x[j as usize] * reciprocal_valences[j as usize]).sum();
        *out = if neighbours.is_empty() { Vec3A::ZERO } else { own - sum };
    }
}

/// s/a = tan α / N with α = π/2 − π/N, of a vertex with N neighbours: times the mixed Voronoi area a_k, m², it is the scale s_k of row k.
///
/// Below three neighbours the angle is not that of a surface, and the scale is zero.
pub fn scale_per_area(valence: usize) -> f32 {
    match valence {
        0..3 => 0.0,
        // tan(π/2 − π/N) = cot(π/N)
        _ => 1.0 / ((PI / valence as f32).tan() * valence as f32),
    }
}

/// r = `detail` (s δ − r), s the area times [`scale_per_area`], at each of the vertices that `residual` has.
pub fn put_residual(detail: f32, areas: &[f32], scales_per_area: &[f32], deltas: &[Vec3A], residual: &mut [Vec3A]) {
    for_rows(residual, |first, residual| {
        let rows = residual.iter_mut().zip(&deltas[first..]).zip(&areas[first..]).zip(&scales_per_area[first..]);
        for (((residual, delta), area), scale_per_area) in rows {
            *residual = detail * (*area * *scale_per_area * *delta - *residual);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::mixed_voronoi_areas;
    use crate::mesh::test_meshes::{grid, icosphere, noise_vectors, torus};
    use glam::{Quat, Vec3};

    fn adjacency_of(mesh: &Mesh) -> Adjacency {
        Adjacency::new(mesh.positions.len(), &mesh.triangles)
    }

    fn laplacian_of(mesh: &Mesh, positions: &[Vec3A]) -> Vec<Vec3A> {
        let mut out = vec![Vec3A::NAN; positions.len()];
        apply_topological(&adjacency_of(mesh), positions, &mut out);
        out
    }

    /// δ = L x / s in 1/m.
    fn delta_of(mesh: &Mesh, positions: &[Vec3A]) -> Vec<Vec3A> {
        let mut areas = vec![0.0; positions.len()];
        mixed_voronoi_areas(positions, &mesh.triangles, &mut areas);
        let adjacency = adjacency_of(mesh);
        let rows = laplacian_of(mesh, positions).into_iter().zip(areas).enumerate();
        rows.map(|(k, (l, area))| l / (area * scale_per_area(adjacency.valence(k)))).collect()
    }

    #[test]
    fn constants_are_the_null_space() {
        for mesh in [torus(10, 7), grid(4, 3)] {
            let constant = vec![Vec3A::new(0.3, -2.0, 5.0); mesh.positions.len()];
            assert!(laplacian_of(&mesh, &constant).iter().all(|l| l.length() < 2e-6));
            let varied = noise_vectors(mesh.positions.len(), 3);
            assert!(laplacian_of(&mesh, &varied).iter().all(|l| l.length() > 1e-4));
        }
    }

    #[test]
    fn delta_turns_with_the_surface_and_ignores_translation() {
        let mesh = torus(30, 16);
        let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-1.1);
        let moved: Vec<Vec3A> =
            mesh.positions.iter().map(|&p| turn * p + Vec3A::from(Vec3::new(1.0, 0.2, -0.4))).collect();
        for (before, after) in delta_of(&mesh, &mesh.positions).iter().zip(delta_of(&mesh, &moved)) {
            assert!((turn * *before - after).length() < 0.02, "{before} against {after}");
        }
    }

    #[test]
    fn delta_scales_inversely_with_size() {
        let mesh = torus(30, 16);
        let larger: Vec<Vec3A> = mesh.positions.iter().map(|&p| 4.0 * p).collect();
        for (small, large) in delta_of(&mesh, &mesh.positions).iter().zip(delta_of(&mesh, &larger)) {
            assert!((*small - 4.0 * large).length() < 1e-3 * small.length());
        }
    }

    #[test]
    fn delta_of_a_sphere_is_outward_twice_the_curvature() {
        let mesh = icosphere(4);
        let radius = 0.4;
        let positions: Vec<Vec3A> = mesh.positions.iter().map(|&p| radius * p).collect();
        let deltas = delta_of(&mesh, &positions);
        // The umbrella is exact on regular rings only. Stretched rings cost a few percent along the normal, and give a part along
        // the surface that says how vertices are spread, not how the surface bends.
        let ratios: Vec<f32> = deltas.iter().zip(&mesh.positions).map(|(d, n)| d.dot(*n) * radius / 2.0).collect();
        let mean = ratios.iter().sum::<f32>() / ratios.len() as f32;
        assert!((mean - 1.0).abs() < 0.02, "mean {mean}");
        assert!(
            ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.12),
            "{:?}",
            ratios.iter().copied().fold(1.0, f32::min)
        );
    }

    #[test]
    fn transposed_is_the_transpose() {
        for mesh in [icosphere(2), grid(5, 3)] {
            let adjacency = adjacency_of(&mesh);
            let count = mesh.positions.len();
            let (x, y) = (noise_vectors(count, 1), noise_vectors(count, 7000));
            let (mut lx, mut lty) = (x.clone(), y.clone());
            apply_topological(&adjacency, &x, &mut lx);
            apply_topological_transposed(&adjacency, &reciprocal_valences(&adjacency), &y, &mut lty);
            let dot = |a: &[Vec3A], b: &[Vec3A]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f32>();
            let (left, right) = (dot(&lx, &y), dot(&x, &lty));
            assert!((left - right).abs() < 1e-4 * (1.0 + left.abs()), "{left} against {right}");
            // L itself is no such transpose where valences differ.
            assert!((left - dot(&x, &laplacian_of(&mesh, &y))).abs() > 1e-2);
        }
    }

    #[test]
    fn scales_of_known_valences() {
        assert_eq!([0, 1, 2].map(scale_per_area), [0.0; 3]);
        for (valence, expected) in [(3, 1.0 / 3.0 / 3f32.sqrt()), (4, 0.25), (5, 0.275_276), (6, 0.288_675)] {
            assert!((scale_per_area(valence) - expected).abs() < 1e-5, "{valence}");
        }
    }

    #[test]
    fn a_vertex_without_neighbours_has_an_empty_row() {
        let adjacency = Adjacency::new(1, &[]);
        let mut out = [Vec3A::ONE];
        apply_topological(&adjacency, &[Vec3A::X], &mut out);
        assert_eq!(out, [Vec3A::ZERO]);
    }
}
