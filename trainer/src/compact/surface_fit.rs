//! Fitting a surface to a scan: closest points, robust weights, light smoothing of the offset from a reference.
//!
//! Unknown are the control vertices x of some subdivision level; the surface is x refined to the finest level. With y = x − reference,
//! the energy is Σ w |r|²_n + λ Σ |L y|² + ε Σ |y|², where r is the gap from a scan point to its closest surface point and |·|_n
//! counts the tangential part less. Where the scan says nothing the offset stays smooth, so holes keep the reference's shape.

use super::least_squares::conjugate_gradients;
use crate::closest::ClosestPoint;
use crease::laplacian::{apply_topological, apply_topological_transposed, reciprocal_valences};
use crease::mesh::{Adjacency, Scheme, Subdivision, VertexValue, vertex_normals};
use glam::Vec3A;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Weights of the energy and the schedule of closest-point rounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitOptions {
    /// λ of each round of closest points, falling.
    pub smoothness: Vec<f32>,
    /// ε.
    pub magnitude: f32,
    /// Weight of the tangential part of a gap.
    pub tangential: f32,
    /// Gaps beyond this are no correspondence, metres, for each round.
    pub reject_distance: Vec<f32>,
    /// Nor are normals further apart than this cosine.
    pub reject_cosine: f32,
    /// Conjugate-gradient steps in each round.
    pub iteration_count: usize,
}

/// A scan with its normals (sign arbitrary).
pub struct OrientedScan<'a> {
    /// Points, metres.
    pub points: &'a [Vec3A],
    /// Unit normals up to sign.
    pub normals: &'a [Vec3A],
    /// μ of each point.
    pub weights: &'a [f32],
}

struct Correspondence {
    corners: [u32; 3],
    barycentrics: [f32; 3],
    target: Vec3A,
    normal: Vec3A,
    weight: f32,
}

/// Fits the vertices of `level`, whose refinement by `scheme` is the surface, to `scan`. Returns them.
///
/// `reference` and `start` are vertices of `level`, posed, metres; smoothness acts on the offset from `reference`.
pub fn fit_surface(
    subdivision: &Subdivision,
    adjacency: &Adjacency,
    scheme: Scheme,
    level: usize,
    reference: &[Vec3A],
    start: &[Vec3A],
    scan: &OrientedScan,
    options: &FitOptions,
) -> anyhow::Result<Vec<Vec3A>> {
    let mut x = start.to_vec();
    for (round, &smoothness) in options.smoothness.iter().enumerate() {
        let surface = refine_to_finest(subdivision, scheme, level, &x);
        let reject = options.reject_distance[round.min(options.reject_distance.len() - 1)];
        let correspondences = correspond(subdivision, &surface, scan, reject, options)?;
        solve_round(subdivision, adjacency, scheme, level, reference, &mut x, &correspondences, smoothness, options);
    }
    Ok(x)
}

/// Weight of the scan points that count on each vertex of `level`, whose refinement is the fitted surface.
pub fn coverage(
    subdivision: &Subdivision,
    scheme: Scheme,
    level: usize,
    x: &[Vec3A],
    scan: &OrientedScan,
    options: &FitOptions,
) -> anyhow::Result<Vec<f32>> {
    let surface = refine_to_finest(subdivision, scheme, level, x);
    let reject = options.reject_distance[options.reject_distance.len() - 1];
    let mut weights = vec![Vec3A::ZERO; surface.len()];
    for c in correspond(subdivision, &surface, scan, reject, options)? {
        for i in 0..3 {
            weights[c.corners[i] as usize] += Vec3A::splat(c.weight * c.barycentrics[i]);
        }
    }
    Ok(restrict_from_finest(subdivision, scheme, level, weights).iter().map(|weight| weight.x).collect())
}

/// Carries vertices of `level` to the finest level.
pub fn refine_to_finest(subdivision: &Subdivision, scheme: Scheme, level: usize, x: &[Vec3A]) -> Vec<Vec3A> {
    refine_between(subdivision, scheme, level..subdivision.level_count(), x)
}

/// Carries what the vertices of the first of `levels` have to those of the last.
pub fn refine_between<T: VertexValue + Default>(
    subdivision: &Subdivision,
    scheme: Scheme,
    levels: Range<usize>,
    x: &[T],
) -> Vec<T> {
    let mut current = x.to_vec();
    for level in levels {
        let mut fine = vec![T::default(); subdivision.vertex_count(level + 1)];
        subdivision.refine(scheme, level, &current, &mut fine);
        current = fine;
    }
    current
}

/// Transpose of [`refine_to_finest`].
pub fn restrict_from_finest(subdivision: &Subdivision, scheme: Scheme, level: usize, x: Vec<Vec3A>) -> Vec<Vec3A> {
    let mut current = x;
    for l in (level..subdivision.level_count()).rev() {
        let mut coarse = vec![Vec3A::ZERO; subdivision.vertex_count(l)];
        subdivision.restrict(scheme, l, &current, &mut coarse);
        current = coarse;
    }
    current
}

fn correspond(
    subdivision: &Subdivision,
    surface: &[Vec3A],
    scan: &OrientedScan,
    reject_distance: f32,
    options: &FitOptions,
) -> anyhow::Result<Vec<Correspondence>> {
    let triangles = subdivision.triangles(subdivision.level_count());
    let mut normals = vec![Vec3A::ZERO; surface.len()];
    vertex_normals(surface, triangles, &mut normals);
    let closest = ClosestPoint::new(surface, triangles)?;
    let hits = closest.query_all(scan.points);
    let mut correspondences = Vec::with_capacity(scan.points.len());
    for (i, hit) in hits.iter().enumerate() {
        let corners = triangles[hit.triangle as usize];
        let gap = scan.points[i] - hit.interpolate(triangles, surface);
        let normal = hit.interpolate(triangles, &normals).normalize_or_zero();
        if gap.length() > reject_distance || normal.dot(scan.normals[i]).abs() < options.reject_cosine {
            continue;
        }
        // Geman-McClure: a gap near the rejection distance hardly pulls.
        let ratio = gap.length_squared() / (reject_distance * reject_distance);
        correspondences.push(Correspondence {
            corners,
            barycentrics: hit.barycentric,
            target: scan.points[i],
            normal,
            weight: scan.weights[i] / (1.0 + ratio).powi(2),
        });
    }
    Ok(correspondences)
}

fn solve_round(
    subdivision: &Subdivision,
    adjacency: &Adjacency,
    scheme: Scheme,
    level: usize,
    reference: &[Vec3A],
    x: &mut [Vec3A],
    correspondences: &[Correspondence],
    smoothness: f32,
    options: &FitOptions,
) {
    let n = x.len();
    let finest_count = subdivision.vertex_count(subdivision.level_count());
    let weigh = |c: &Correspondence, gap: Vec3A| -> Vec3A {
        let along = c.normal.dot(gap) * c.normal;
        c.weight * (along + options.tangential * (gap - along))
    };
    let reciprocal_valences = reciprocal_valences(adjacency);
    let mut smoothed = vec![Vec3A::ZERO; n];
    let mut smoothed_twice = vec![Vec3A::ZERO; n];
    let mut apply = |y: &[Vec3A], out: &mut [Vec3A]| {
        let surface = refine_to_finest(subdivision, scheme, level, y);
        let mut pull = vec![Vec3A::ZERO; finest_count];
        for c in correspondences {
            let value: Vec3A = (0..3).map(|i| surface[c.corners[i] as usize] * c.barycentrics[i]).sum();
            let force = weigh(c, value);
            for i in 0..3 {
                pull[c.corners[i] as usize] += force * c.barycentrics[i];
            }
        }
        out.copy_from_slice(&restrict_from_finest(subdivision, scheme, level, pull));
        apply_topological(adjacency, y, &mut smoothed);
        apply_topological_transposed(adjacency, &reciprocal_valences, &smoothed, &mut smoothed_twice);
        for i in 0..n {
            out[i] += smoothness * smoothed_twice[i] + options.magnitude * y[i];
        }
    };

    let reference_surface = refine_to_finest(subdivision, scheme, level, reference);
    let mut pull = vec![Vec3A::ZERO; finest_count];
    let mut diagonal = vec![Vec3A::ZERO; finest_count];
    for c in correspondences {
        let value: Vec3A = (0..3).map(|i| reference_surface[c.corners[i] as usize] * c.barycentrics[i]).sum();
        let force = weigh(c, c.target - value);
        for i in 0..3 {
            pull[c.corners[i] as usize] += force * c.barycentrics[i];
            diagonal[c.corners[i] as usize] += Vec3A::splat(c.weight * c.barycentrics[i]);
        }
    }
    let b = restrict_from_finest(subdivision, scheme, level, pull);
    let inverse_diagonal: Vec<f32> = restrict_from_finest(subdivision, scheme, level, diagonal)
        .iter()
        .map(|d| 1.0 / (d.x + 1.3 * smoothness + options.magnitude))
        .collect();
    let mut y: Vec<Vec3A> = x.iter().zip(reference).map(|(&x, &r)| x - r).collect();
    conjugate_gradients(&mut apply, &inverse_diagonal, &b, &mut y, options.iteration_count, 1e-3);
    for i in 0..n {
        x[i] = reference[i] + y[i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::sphere;

    const RADIUS: f32 = 0.5;

    fn options(smoothness: Vec<f32>) -> FitOptions {
        FitOptions {
            smoothness,
            reject_distance: vec![0.1],
            magnitude: 1e-4,
            tangential: 0.1,
            reject_cosine: 0.5,
            iteration_count: 60,
        }
    }

    /// A sphere whose upper part stands off by a cosine bump of 4 cm, seen where `is_seen`.
    fn fitted(options: &FitOptions, is_seen: impl Fn(Vec3A) -> bool) -> (Vec<Vec3A>, impl Fn(Vec3A) -> f32) {
        let bump = |direction: Vec3A| 0.04 * direction.y.max(0.0).powi(2);
        let control = sphere(RADIUS, 2);
        let subdivision = Subdivision::new(control.positions.len(), &control.triangles, 2);
        let adjacency = Adjacency::new(control.positions.len(), &control.triangles);
        let normals: Vec<Vec3A> =
            sphere(1.0, 5).positions.into_iter().filter(|&direction| is_seen(direction)).collect();
        let points: Vec<Vec3A> = normals.iter().map(|&n| n * (RADIUS + bump(n))).collect();
        let scan = OrientedScan { points: &points, normals: &normals, weights: &vec![1.0; points.len()] };
        let x = fit_surface(
            &subdivision,
            &adjacency,
            Scheme::Loop,
            0,
            &control.positions,
            &control.positions,
            &scan,
            options,
        )
        .unwrap();
        (refine_to_finest(&subdivision, Scheme::Loop, 0, &x), move |p: Vec3A| p.length() - RADIUS - bump(p.normalize()))
    }

    fn largest_gap(options: &FitOptions, is_seen: impl Fn(Vec3A) -> bool + Copy) -> f32 {
        let (surface, gap) = fitted(options, is_seen);
        surface.iter().map(|&p| gap(p).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn a_light_fit_meets_the_scan_and_a_heavy_one_does_not() {
        assert!(largest_gap(&options(vec![10.0, 1.0, 0.1]), |_| true) < 1.5e-3);
        assert!(largest_gap(&options(vec![1e6]), |_| true) > 5e-3);
    }

    #[test]
    fn a_hole_is_bridged_smoothly() {
        let light = options(vec![10.0, 1.0, 0.1]);
        let is_seen = |direction: Vec3A| (direction - Vec3A::new(0.6, 0.8, 0.0)).length() > 0.35;
        assert!(largest_gap(&light, is_seen) < 8e-3, "{}", largest_gap(&light, is_seen));
    }

    #[test]
    fn points_beyond_reach_do_not_pull() {
        let near = FitOptions { reject_distance: vec![1e-6], ..options(vec![1.0]) };
        let (surface, _) = fitted(&near, |direction| direction.y > 0.5);
        assert!(surface.iter().all(|p| (p.length() - RADIUS).abs() < 0.02), "the reference stays");
    }

    #[test]
    fn restriction_is_the_transpose_of_refinement() {
        let control = sphere(1.0, 1);
        let subdivision = Subdivision::new(control.positions.len(), &control.triangles, 2);
        let fine: Vec<Vec3A> =
            (0..subdivision.vertex_count(2)).map(|k| Vec3A::new((k as f32).sin(), 1.0, (k as f32).cos())).collect();
        for scheme in [Scheme::Loop, Scheme::Midpoint] {
            let refined = refine_to_finest(&subdivision, scheme, 0, &control.positions);
            let restricted = restrict_from_finest(&subdivision, scheme, 0, fine.clone());
            let left: f32 = refined.iter().zip(&fine).map(|(a, b)| a.dot(*b)).sum();
            let right: f32 = control.positions.iter().zip(&restricted).map(|(a, b)| a.dot(*b)).sum();
            assert!((left - right).abs() < 1e-3 * left.abs().max(1.0), "{left} against {right}");
        }
    }
}
