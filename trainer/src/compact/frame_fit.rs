//! A training frame made ready for fitting: the scan with normals and weights.

use super::surface_fit::OrientedScan;
use crate::context::{Sample, TrainContext};
use crate::nearest::NearestPoints;
use crate::normals::point_normals;
use glam::Vec3A;

/// Neighbours whose plane is a point's normal.
const NORMAL_NEIGHBOURS: usize = 16;

/// The scan of one frame.
pub struct PreparedScan {
    points: Vec<Vec3A>,
    normals: Vec<Vec3A>,
    weights: Vec<f32>,
}

impl PreparedScan {
    /// Reads a frame's scan and estimates its normals.
    pub fn new(context: &TrainContext, sample: Sample) -> anyhow::Result<Self> {
        let points = context.scan(sample)?.points;
        let normals = point_normals(&points, &NearestPoints::new(&points), NORMAL_NEIGHBOURS);
        Ok(Self { weights: vec![1.0; points.len()], points, normals })
    }

    /// What fitting takes.
    pub fn oriented(&self) -> OrientedScan<'_> {
        OrientedScan { points: &self.points, normals: &self.normals, weights: &self.weights }
    }
}
