//! How detail behaves in motions that nobody scanned: what can be said without a truth.

use crate::normals::unit_normals;
use crease::animate::{Animator, Options};
use crease::avatar::Avatar;
use crease::mesh::Adjacency;
use crease::motion::Motion;
use glam::Vec3A;
use std::sync::Arc;

/// An edge is overstretched where it is so many times as long as on the base.
pub const OVERSTRETCHED: f32 = 3.0;

/// Measures of one motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct MotionMeasures {
    /// Frames.
    pub frames: usize,
    /// Whether all positions of all frames are finite.
    pub is_finite: bool,
    /// Share of edges, over all frames, that are overstretched.
    pub overstretched_share: f64,
    /// Greatest length of an edge over its length on the base.
    pub greatest_ratio: f32,
    /// Root mean square acceleration of the detail's offsets along the base's normals, m/s²: what moves with the body counts nothing.
    pub detail_acceleration: f64,
    /// Root mean square acceleration of the base's vertices, m/s².
    pub base_acceleration: f64,
}

/// Plays `motion` through all frames of its own rate.
pub fn measure_motion(avatar: Arc<Avatar>, motion: &Motion) -> anyhow::Result<MotionMeasures> {
    let mut animator = Animator::new(avatar)?;
    let triangles = animator.triangles().to_vec();
    let subdivision = animator.subdivision();
    let edges = Adjacency::new(subdivision.vertex_count(subdivision.level_count()), &triangles).edges();
    let options = Options { warm_start: true, ..Options::default() };
    let mut measures = MotionMeasures { frames: motion.poses.len(), is_finite: true, ..MotionMeasures::default() };
    let mut overstretched = 0usize;
    let (mut offsets, mut places) = (Differences::default(), Differences::default());
    for pose in &motion.poses {
        let detailed = animator.animate(pose, &options).to_vec();
        let base = animator.surface().finest().to_vec();
        measures.is_finite &= detailed.iter().all(|position| position.is_finite());
        for &[a, b] in &edges {
            let [a, b] = [a, b].map(|vertex| vertex as usize);
            let ratio = detailed[a].distance(detailed[b]) / base[a].distance(base[b]).max(f32::MIN_POSITIVE);
            overstretched += usize::from(ratio > OVERSTRETCHED);
            measures.greatest_ratio = measures.greatest_ratio.max(ratio);
        }
        let normals = unit_normals(&base, &triangles);
        let along = |vertex: usize| Vec3A::X * (detailed[vertex] - base[vertex]).dot(normals[vertex]);
        offsets.add((0..base.len()).map(along).collect());
        places.add(base);
    }
    measures.overstretched_share = overstretched as f64 / (edges.len() * motion.poses.len()) as f64;
    let squared_rate = f64::from(motion.frames_per_second).powi(2);
    measures.detail_acceleration = offsets.root_mean_square() * squared_rate;
    measures.base_acceleration = places.root_mean_square() * squared_rate;
    Ok(measures)
}

/// Second differences of fields that come one after the other.
#[derive(Default)]
struct Differences {
    last: Vec<Vec<Vec3A>>,
    sum: f64,
    count: usize,
}

impl Differences {
    fn add(&mut self, field: Vec<Vec3A>) {
        if let [before, last] = &self.last[..] {
            let second = before.iter().zip(last).zip(&field).map(|((a, b), c)| (*a - 2.0 * *b + *c).length_squared());
            self.sum += second.map(f64::from).sum::<f64>();
            self.count += field.len();
            self.last.remove(0);
        }
        self.last.push(field);
    }

    fn root_mean_square(&self) -> f64 {
        (self.sum / self.count.max(1) as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::body::Pose;
    use crease::fixture::{bent_pose, compact_avatar};
    use crease::motion::interpolate;

    fn measured(avatar: Avatar, poses: Vec<Pose>) -> MotionMeasures {
        let motion = Motion { poses, frames_per_second: 10.0, notes: Vec::new() };
        measure_motion(Arc::new(avatar), &motion).unwrap()
    }

    fn bending() -> Vec<Pose> {
        (0..5).map(|frame| interpolate(&Pose::rest(24), &bent_pose(), 0.25 * frame as f32)).collect()
    }

    #[test]
    fn falling_is_the_bodys_and_not_the_details() {
        let fall = |frame: usize| {
            let mut pose = bent_pose();
            // 9.81 m/s², ten frames a second.
            pose.translation.y -= 0.5 * 9.81 * (0.1 * frame as f32).powi(2);
            pose
        };
        let measures = measured(compact_avatar(), (0..5).map(fall).collect());
        assert!((measures.base_acceleration - 9.81).abs() < 0.02, "{measures:?}");
        assert!(measures.detail_acceleration < 0.05, "{measures:?}");
        assert!(measures.is_finite && measures.frames == 5);
    }

    #[test]
    fn wild_detail_is_told_from_calm() {
        let calm = measured(compact_avatar(), bending());
        assert!(calm.detail_acceleration > 0.0, "{calm:?}");
        let mut wild = compact_avatar();
        let crease::network::SurfaceFunction::Compact(tables) = &mut wild.laplacian else { panic!("tables") };
        tables.mean.iter_mut().enumerate().for_each(|(index, value)| *value += 4e3 * ((index % 7) as f32 - 3.0));
        tables.basis_step.iter_mut().for_each(|step| *step *= 50.0);
        let wild = measured(wild, bending());
        assert!(wild.greatest_ratio > OVERSTRETCHED && wild.overstretched_share > calm.overstretched_share, "{wild:?}");
        assert!(wild.detail_acceleration > 5.0 * calm.detail_acceleration, "{wild:?} after {calm:?}");
        assert_eq!(wild.base_acceleration, calm.base_acceleration);
    }
}
