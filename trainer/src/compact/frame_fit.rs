//! A training frame made ready for fitting: the scan with normals and weights.

use super::surface_fit::{FitOptions, OrientedScan};
use crate::context::{Sample, TrainContext};
use crate::normals::scan_normals;
use glam::Vec3A;

/// The scan of one frame.
pub struct PreparedScan {
    points: Vec<Vec3A>,
    normals: Vec<Vec3A>,
    weights: Vec<f32>,
    /// Whether the scan is the view of one camera: then much of the surface has no data, and depth is noisy.
    pub is_view: bool,
}

impl PreparedScan {
    /// Reads a frame's scan, and estimates normals where it has none.
    pub fn new(context: &TrainContext, sample: Sample) -> anyhow::Result<Self> {
        let frame = context.scan(sample)?;
        let normals = frame.normals.unwrap_or_else(|| scan_normals(&frame.points));
        Ok(Self { points: frame.points, normals, weights: frame.weights, is_view: frame.camera.is_some() })
    }

    /// What fitting takes.
    pub fn oriented(&self) -> OrientedScan<'_> {
        OrientedScan { points: &self.points, normals: &self.normals, weights: &self.weights }
    }

    /// `options` for this scan: smoother where it is a view, whose noise must not become wrinkles.
    pub fn fit_options(&self, context: &TrainContext, options: &FitOptions) -> FitOptions {
        let factor = if self.is_view { context.options.compact.view_smoothness } else { 1.0 };
        let smoothness = options.smoothness.iter().map(|smoothness| factor * smoothness).collect();
        FitOptions { smoothness, ..options.clone() }
    }
}
