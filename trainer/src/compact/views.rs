//! Views fused over time: where a frame's camera did not see the surface, the mean of the frames that saw it stands in.

use super::least_squares::conjugate_gradients;
use super::surface_fit::refine_between;
use crate::checkpoint::Keep;
use crate::context::TrainContext;
use crease::laplacian::{apply_topological, apply_topological_transposed, reciprocal_valences};
use crease::mesh::{Adjacency, Scheme};
use glam::Vec3A;

/// Coverage, as a share of its mean over what is seen at all, at which a vertex counts as half seen.
const HALF_SEEN: f32 = 0.25;
/// λ of |L m|² in the mean m: carries it into what no frame saw.
const SMOOTHNESS: f32 = 0.05;
/// ε of |m|²: far from everything seen the mean is zero.
const MAGNITUDE: f32 = 1e-4;

/// A value for each vertex and how surely it was measured, from 0 to 1; nothing where everything was.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The field.
    pub values: Vec<Vec3A>,
    /// Sureness.
    pub seen: Option<Vec<f32>>,
}

impl Keep for View {
    /// The values' bytes, then 4 for each vertex where the view did not see all.
    fn to_bytes(&self) -> Vec<u8> {
        let seen = self.seen.iter().flatten().flat_map(|seen| seen.to_le_bytes());
        std::iter::once(u8::from(self.seen.is_some())).chain(self.values.to_bytes()).chain(seen).collect()
    }

    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (&has_seen, bytes) = bytes.split_first()?;
        if has_seen == 0 {
            return Some(Self { values: Keep::from_bytes(bytes)?, seen: None });
        }
        let (values, seen) = bytes.split_at(bytes.len() / 16 * 12);
        let (seen, []) = seen.as_chunks::<4>() else { return None };
        let values: Vec<Vec3A> = Keep::from_bytes(values)?;
        let seen: Vec<f32> = seen.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect();
        (seen.len() == values.len()).then_some(Self { values, seen: Some(seen) })
    }
}

/// How surely each vertex was seen, from the weight of the scan points on it and how far a sensor resolves it.
pub fn seen(coverage: &[f32], resolvable: &[f32]) -> Vec<f32> {
    let covered: Vec<f32> = coverage.iter().copied().filter(|&c| c > 0.0).collect();
    let half = HALF_SEEN * covered.iter().sum::<f32>() / covered.len().max(1) as f32;
    coverage.iter().zip(resolvable).map(|(&c, share)| if c > 0.0 { share * c / (c + half) } else { 0.0 }).collect()
}

/// How much each vertex of `level` is not of a hand, from 0 to 1: fingers are finer than a depth sensor's pixels and noise.
pub fn resolvable(context: &TrainContext, level: usize) -> Vec<f32> {
    let skin = &context.rig.skin;
    let is_hand: Vec<bool> =
        context.rig.joint_names.iter().map(|name| name.ends_with("_wrist") || name.ends_with("_hand")).collect();
    let shares: Vec<f32> = skin
        .joints
        .iter()
        .zip(&skin.weights)
        .map(|(joints, weights)| {
            let hand = joints.iter().zip(weights).filter(|&(&joint, _)| is_hand[joint as usize]);
            1.0 - hand.map(|(_, &weight)| weight).sum::<f32>()
        })
        .collect();
    refine_between(&context.subdivision, Scheme::Midpoint, 0..level, &shares)
}

/// The views' fields with what each did not see taken from the mean of the others. Fields that are seen whole stay as they are.
pub fn fuse(views: Vec<View>, adjacency: &Adjacency) -> Vec<Vec<Vec3A>> {
    if views.iter().all(|view| view.seen.is_none()) {
        return views.into_iter().map(|view| view.values).collect();
    }
    let mean = weighted_mean(&views, adjacency);
    let fused = views.into_iter().map(|view| match view.seen {
        None => view.values,
        Some(seen) => (0..mean.len()).map(|k| mean[k].lerp(view.values[k], seen[k])).collect(),
    });
    fused.collect()
}

/// The field closest to all views where they saw something, smooth elsewhere.
fn weighted_mean(views: &[View], adjacency: &Adjacency) -> Vec<Vec3A> {
    let count = views[0].values.len();
    let mut weights = vec![0.0; count];
    let mut sums = vec![Vec3A::ZERO; count];
    for view in views {
        for k in 0..count {
            let seen = view.seen.as_ref().map_or(1.0, |seen| seen[k]);
            weights[k] += seen;
            sums[k] += seen * view.values[k];
        }
    }
    let reciprocal_valences = reciprocal_valences(adjacency);
    let mut once = vec![Vec3A::ZERO; count];
    let mut apply = |x: &[Vec3A], out: &mut [Vec3A]| {
        apply_topological(adjacency, x, &mut once);
        apply_topological_transposed(adjacency, &reciprocal_valences, &once, out);
        for k in 0..count {
            out[k] = SMOOTHNESS * out[k] + (weights[k] + MAGNITUDE) * x[k];
        }
    };
    let inverse_diagonal: Vec<f32> = weights.iter().map(|w| 1.0 / (w + MAGNITUDE + 1.2 * SMOOTHNESS)).collect();
    let mut mean: Vec<Vec3A> = (0..count).map(|k| sums[k] / weights[k].max(MAGNITUDE)).collect();
    conjugate_gradients(&mut apply, &inverse_diagonal, &sums, &mut mean, 300, 1e-4);
    mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::sphere;

    #[test]
    fn each_side_is_taken_from_the_view_that_saw_it() {
        let mesh = sphere(1.0, 4);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let view = |is_seen: &dyn Fn(Vec3A) -> bool, wrong: Vec3A| {
            let coverage: Vec<f32> = mesh.positions.iter().map(|&p| if is_seen(p) { 1.0 } else { 0.0 }).collect();
            let values = mesh.positions.iter().map(|&p| if is_seen(p) { Vec3A::X * p.y } else { wrong }).collect();
            View { values, seen: Some(seen(&coverage, &vec![1.0; coverage.len()])) }
        };
        // Two halves that overlap, and a cap at the side that neither saw.
        let cap = |p: Vec3A| p.x > 0.95;
        let views = vec![
            view(&|p| p.z > -0.2 && !cap(p), Vec3A::splat(9.0)),
            view(&|p| p.z < 0.2 && !cap(p), Vec3A::splat(-9.0)),
        ];
        for field in fuse(views, &adjacency) {
            for (value, position) in field.iter().zip(&mesh.positions) {
                let error = value.distance(Vec3A::X * position.y);
                // A half-seen vertex keeps some of its own; what is not seen is the mean alone.
                assert!(error < if cap(*position) { 0.1 } else { 0.02 }, "{error} at {position}");
            }
        }
    }

    #[test]
    fn views_are_kept_bit_for_bit() {
        for seen in [None, Some(vec![0.25, 1.0])] {
            let view = View { values: vec![Vec3A::X, Vec3A::new(0.1, -0.0, 3.0)], seen };
            assert_eq!(View::from_bytes(&view.to_bytes()), Some(view.clone()));
            assert_eq!(View::from_bytes(&view.to_bytes()[2..]), None);
        }
    }

    #[test]
    fn whole_scans_stay_as_they_are() {
        let mesh = sphere(1.0, 1);
        let adjacency = Adjacency::new(mesh.positions.len(), &mesh.triangles);
        let views = vec![View { values: mesh.positions.clone(), seen: None }];
        assert_eq!(fuse(views, &adjacency), [mesh.positions]);
    }
}
