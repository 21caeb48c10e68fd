//! What an avatar is measured against: the ground truth of a sequence, or its scans where it has none.

use crate::closest::ClosestPoint;
use crate::normals::{scan_normals, unit_normals};
use crate::sequence::{Frame, GroundTruth, Sequence};
use crease::animate::{BaseAnimator, Options, Stage};
use crease::avatar::Avatar;
use std::cell::RefCell;
use std::sync::Arc;

/// Frames of a sequence as points with outward normals.
pub struct Truth<'a> {
    sequence: &'a Sequence,
    is_ground_truth: bool,
    animator: RefCell<BaseAnimator>,
}

impl<'a> Truth<'a> {
    /// Of `sequence`, the scans of which are turned outward by the base of `avatar`.
    pub fn new(sequence: &'a Sequence, avatar: Arc<Avatar>) -> anyhow::Result<Self> {
        let is_ground_truth = sequence.capture.directory.join("ground_truth").is_dir();
        Ok(Self { sequence, is_ground_truth, animator: RefCell::new(BaseAnimator::new(avatar)?) })
    }

    /// What it is, for people.
    pub fn name(&self) -> &'static str {
        if self.is_ground_truth { "ground truth" } else { "scans themselves, noise and holes and all" }
    }

    /// Frames that there is something to measure against.
    pub fn frames(&self) -> Vec<usize> {
        let capture = &self.sequence.capture;
        let has = |frame: &usize| !self.is_ground_truth || capture.has_ground_truth(*frame);
        (0..capture.frame_count).filter(has).collect()
    }

    /// What to measure against.
    pub fn truth(&self, frame: usize) -> anyhow::Result<GroundTruth> {
        if self.is_ground_truth { Ok(self.sequence.capture.ground_truth(frame)?) } else { self.scan(frame) }
    }

    /// What the scanner saw; the ground truth where there are no scans.
    pub fn scan(&self, frame: usize) -> anyhow::Result<GroundTruth> {
        match self.sequence.capture.scan(frame) {
            Ok(scan) => self.oriented(scan),
            Err(_) if self.is_ground_truth => Ok(self.sequence.capture.ground_truth(frame)?),
            Err(error) => Err(error.into()),
        }
    }

    /// Estimated normals have no side: the surface's nearest point gives it.
    fn oriented(&self, scan: Frame) -> anyhow::Result<GroundTruth> {
        let Frame { points, normals, index, .. } = scan;
        if let Some(normals) = normals {
            return Ok(GroundTruth { points, normals });
        }
        let mut normals = scan_normals(&points);
        let mut animator = self.animator.borrow_mut();
        let triangles = animator.triangles().to_vec();
        let options = Options { stage: Stage::Base, ..Options::default() };
        let surface = animator.animate_observed(&self.sequence.poses[index], &options, &mut |_| ());
        let outward = unit_normals(surface, &triangles);
        for (normal, hit) in normals.iter_mut().zip(ClosestPoint::new(surface, &triangles)?.query_all(&points)) {
            if normal.dot(hit.interpolate(&triangles, &outward)) < 0.0 {
                *normal = -*normal;
            }
        }
        Ok(GroundTruth { points, normals })
    }
}
