//! Where an avatar's error lies: frame by frame, by part of the body, by distance from the poses it learned from; and how lively it is.

mod body_part;
mod detail_energy;

pub use body_part::{BODY_PARTS, BodyPart};
pub use detail_energy::DetailEnergy;

use crate::comparison::Comparison;
use crate::evaluate::{Evaluation, Measures};
use crate::options::TrainOptions;
use crate::progress::Progress;
use crate::sequence::{GroundTruth, Sequence};
use crease::animate::{Animator, Options, Stage};
use crease::avatar::Avatar;
use crease::body::Pose;
use detail_energy::{DetailMeter, energy};
use std::sync::Arc;

/// Stages, in the order of every array here.
pub const STAGES: [Stage; 3] = [Stage::Body, Stage::Base, Stage::Detailed];

/// Where the error lies.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Residue {
    /// Means over the frames.
    pub evaluation: Evaluation,
    /// Each frame, in order.
    pub frames: Vec<FrameResidue>,
    /// Each part of the body, over all frames.
    pub parts: Vec<PartResidue>,
}

/// One frame's error.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct FrameResidue {
    /// Frame of the sequence.
    pub frame: usize,
    /// Degrees to the nearest training pose, where one is known: see [`pose_distance_degrees`].
    pub pose_distance_degrees: Option<f32>,
    /// Body, base, detailed.
    pub stages: [Measures; 3],
}

/// The error of one part of the body.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct PartResidue {
    /// Which.
    pub part: BodyPart,
    /// Its share of the true points.
    pub share: f64,
    /// Its share of what the detailed mesh lacks in normal consistency.
    pub share_of_nc_loss: f64,
    /// Mean distance from its true points to body, base and detailed mesh, cm.
    pub scan_to_mesh_cm: [f64; 3],
    /// Mean cosine between normals there.
    pub nc: [f64; 3],
    /// Detail, over the frames that it was measured in; none where it was in no frame.
    pub energy: Option<DetailEnergy>,
}

/// What to measure.
pub struct Wishes<'a> {
    /// Frames of the sequence.
    pub frames: &'a [usize],
    /// Poses that the avatar learned from, as far as they are known.
    pub training_poses: &'a [Pose],
    /// In how many of the frames, evenly spread, the ground truth is fitted to measure its detail: seconds each.
    pub energy_frame_count: usize,
    /// [`Options::liveliness`].
    pub liveliness: f32,
}

/// Root mean square over all joints but the root of the angle between their rotations, degrees.
pub fn pose_distance_degrees(a: &Pose, b: &Pose) -> f32 {
    let angles = a.rotations.iter().zip(&b.rotations).skip(1).map(|(a, b)| a.angle_between(*b).powi(2));
    let count = a.rotations.len().saturating_sub(1).max(1);
    (angles.sum::<f32>() / count as f32).sqrt().to_degrees()
}

/// Sums over the true points that the detailed mesh has nearest to one part of the body, for each stage.
#[derive(Clone, Copy, Default)]
struct PartSums {
    count: f64,
    gap: [f64; 3],
    cosine: [f64; 3],
    squares: [f64; 3],
}

/// Measures `avatar` on a sequence whose ground truth `truth` gives.
///
/// Fails where a frame has no ground truth.
pub fn residue(
    avatar: Arc<Avatar>,
    sequence: &Sequence,
    truth: impl Fn(usize) -> anyhow::Result<GroundTruth>,
    wishes: &Wishes,
    progress: Progress,
) -> anyhow::Result<Residue> {
    let mut animator = Animator::new(avatar)?;
    let subdivision = animator.subdivision().clone();
    let triangles = animator.triangles().to_vec();
    let parts = BodyPart::of_vertices(&animator.avatar().rig, &subdivision);
    let compact = TrainOptions::compact().compact;
    let meter = DetailMeter::new(&subdivision, animator.avatar().scheme, compact.detail_fit, compact.clamp);
    let step = wishes.frames.len().div_ceil(wishes.energy_frame_count.max(1)).max(1);

    let mut sums = [PartSums::default(); BODY_PARTS.len()];
    let mut frames = Vec::with_capacity(wishes.frames.len());
    let bar = progress.bar("measuring", wishes.frames.len());
    for (position, &frame) in wishes.frames.iter().enumerate() {
        let truth = truth(frame)?;
        let pose = &sequence.poses[frame];
        let surfaces = STAGES.map(|stage| {
            animator.animate(pose, &Options { stage, liveliness: wishes.liveliness, ..Options::default() }).to_vec()
        });
        let comparisons = surfaces.each_ref().map(|surface| Comparison::new(surface, &triangles, &truth));
        let [body, base, detailed] = comparisons;
        let comparisons = [body?, base?, detailed?];
        for (point, closest) in comparisons[2].closest.iter().enumerate() {
            let heaviest = (0..3).max_by(|&a, &b| closest.barycentric[a].total_cmp(&closest.barycentric[b]));
            let vertex = triangles[closest.triangle as usize][heaviest.unwrap_or_default()];
            let sums = &mut sums[parts[vertex as usize] as usize];
            sums.count += 1.0;
            for (stage, comparison) in comparisons.iter().enumerate() {
                sums.gap[stage] += f64::from(comparison.gaps[point].abs());
                sums.cosine[stage] += f64::from(comparison.cosines[point]);
            }
        }
        if wishes.energy_frame_count > 0 && position % step == step / 2 {
            let squares = meter.squares(&surfaces[1], &surfaces[2], &truth, &parts)?;
            for (sums, squares) in sums.iter_mut().zip(squares) {
                (0..3).for_each(|i| sums.squares[i] += squares[i]);
            }
        }
        let nearest = wishes.training_poses.iter().map(|other| pose_distance_degrees(pose, other));
        let stages = comparisons.each_ref().map(Comparison::measures);
        frames.push(FrameResidue { frame, pose_distance_degrees: nearest.min_by(f32::total_cmp), stages });
        bar.advance(1);
    }
    let of_stage = |stage: usize| Measures::mean(&frames.iter().map(|frame| frame.stages[stage]).collect::<Vec<_>>());
    let evaluation = Evaluation { frames: frames.len(), body: of_stage(0), base: of_stage(1), detailed: of_stage(2) };
    Ok(Residue { evaluation, frames, parts: part_residues(&sums) })
}

fn part_residues(sums: &[PartSums; BODY_PARTS.len()]) -> Vec<PartResidue> {
    let all: f64 = sums.iter().map(|sums| sums.count).sum();
    let loss = |sums: &PartSums| sums.count - sums.cosine[2];
    let whole_loss: f64 = sums.iter().map(loss).sum();
    let residue = |(&part, sums): (&BodyPart, &PartSums)| PartResidue {
        part,
        share: sums.count / all.max(1.0),
        share_of_nc_loss: loss(sums) / whole_loss.max(f64::MIN_POSITIVE),
        scan_to_mesh_cm: sums.gap.map(|gap| 100.0 * gap / sums.count.max(1.0)),
        nc: sums.cosine.map(|cosine| cosine / sums.count.max(1.0)),
        energy: (sums.squares[2] > 0.0).then(|| energy(sums.squares)),
    };
    BODY_PARTS.iter().zip(sums).map(residue).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normals::unit_normals;
    use crate::sequence::Capture;
    use crease::animate::animate;
    use crease::fixture::{bent_pose, compact_avatar};
    use glam::Quat;

    /// The avatar's own detailed surface as ground truth, its normals times `sign`.
    fn own_surface(avatar: &Avatar, pose: &Pose, sign: f32) -> GroundTruth {
        let mesh = animate(avatar, pose, &Options::default()).unwrap();
        let normals = unit_normals(&mesh.positions, &mesh.triangles);
        GroundTruth { points: mesh.positions, normals: normals.iter().map(|&normal| sign * normal).collect() }
    }

    fn measured(sign: f32, energy_frame_count: usize) -> Residue {
        let avatar = Arc::new(compact_avatar());
        let poses = vec![bent_pose(), Pose::rest(avatar.rig.parents.len())];
        let directory = std::env::temp_dir().join(format!("crease-residue-{}-{sign}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        std::fs::write(directory.join("sequence.json"), r#"{ "name": "own", "fps": 30, "frame_count": 2 }"#).unwrap();
        let capture = Capture::open(&directory).unwrap();
        std::fs::remove_dir_all(&directory).unwrap();
        let sequence = Sequence { capture, betas: Vec::new(), poses: poses.clone() };
        let truth = |frame: usize| Ok(own_surface(&avatar, &poses[frame], sign));
        let wishes = Wishes { frames: &[0, 1], training_poses: &poses[1..], energy_frame_count, liveliness: 0.0 };
        residue(Arc::clone(&avatar), &sequence, truth, &wishes, Progress::Silent).unwrap()
    }

    #[test]
    fn an_avatar_that_is_its_own_truth_has_no_residue() {
        let residue = measured(1.0, 1);
        assert!(residue.evaluation.detailed.scan_to_mesh_cm < 1e-4 && residue.evaluation.detailed.nc > 0.9999);
        assert!(residue.evaluation.base.scan_to_mesh_cm > residue.evaluation.detailed.scan_to_mesh_cm);
        assert!((residue.parts.iter().map(|part| part.share).sum::<f64>() - 1.0).abs() < 1e-9);
        let energies: Vec<DetailEnergy> = residue.parts.iter().filter_map(|part| part.energy).collect();
        assert!(!energies.is_empty());
        for energy in energies {
            let ratio = energy.own_per_metre / energy.true_per_metre;
            assert!((0.7..1.4).contains(&ratio), "a fit to its own surface has its own detail: {energy:?}");
        }
        assert!(measured(1.0, 0).parts.iter().all(|part| part.energy.is_none()));
    }

    #[test]
    fn frames_know_how_far_they_are_from_the_training() {
        let [bent, rest] = [0, 1].map(|frame| measured(1.0, 0).frames[frame].pose_distance_degrees.unwrap());
        assert!(rest < 0.1 && bent > 1.0, "{rest} {bent}");
    }

    #[test]
    fn parts_sum_to_the_whole() {
        let residue = measured(-1.0, 0);
        let weighted =
            |of: fn(&PartResidue) -> f64| residue.parts.iter().map(|part| part.share * of(part)).sum::<f64>();
        // Means over points against means over frames of as many points each.
        assert!((weighted(|part| part.nc[2]) - residue.evaluation.detailed.nc).abs() < 1e-6);
        assert!((weighted(|part| part.scan_to_mesh_cm[1]) - residue.evaluation.base.scan_to_mesh_cm).abs() < 1e-6);
        assert!(residue.evaluation.detailed.nc < -0.9999, "an inward truth must not pass");
    }

    #[test]
    fn one_joint_of_three_turned_by_sixty_degrees() {
        let rest = Pose::rest(4);
        let mut turned = rest.clone();
        turned.rotations[0] = Quat::from_rotation_x(1.0);
        turned.rotations[2] = Quat::from_rotation_y(60f32.to_radians());
        let distance = pose_distance_degrees(&rest, &turned);
        assert!((distance - 60.0 / 3f32.sqrt()).abs() < 1e-2, "the root has no say: {distance}");
    }
}
