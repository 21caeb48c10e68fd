//! Training in compact form: fits to every scan, closed-form regression on the pose, tables.

mod cotangent;
mod deformation;
mod displacement;
mod distil;
mod frame_fit;
mod laplacian;
mod least_squares;
mod mirror;
mod regions;
mod regression;
mod surface_fit;
mod two_scales;
mod views;

pub use cotangent::CompactCotangent;
pub use deformation::CompactDeformation;
pub use displacement::CompactDisplacement;
pub use distil::{Difference, difference, distil};
pub use laplacian::CompactLaplacian;
pub use regression::RegressionOptions;
pub use surface_fit::{FitOptions, OrientedScan, fit_surface, refine_between};
pub use two_scales::BranchOptions;
pub use views::View;

use serde::{Deserialize, Serialize};

/// Settings of the compact form.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CompactOptions {
    /// First fit of the base, from the naked body: far reach, heavy smoothing.
    pub coarse_fit: FitOptions,
    /// Second fit of the base, from the mean of the first: light smoothing.
    pub base_fit: FitOptions,
    /// Fit of the finest mesh to each scan, from the base.
    pub detail_fit: FitOptions,
    /// Smoothness of all fits to the view of a single camera, as a multiple of that for whole scans.
    pub view_smoothness: f32,
    /// Pose regression of f_d.
    pub deformation: BranchOptions,
    /// Pose regression of f_l.
    pub laplacian: BranchOptions,
    /// Subdivision level on which f_l's tables stand; the finest where there are not so many.
    pub laplacian_level: u32,
    /// Longer operator Laplacians are shortened to this length, 1/m.
    pub clamp: f32,
}

impl Default for CompactOptions {
    fn default() -> Self {
        let common = FitOptions {
            smoothness: vec![],
            reject_distance: vec![],
            magnitude: 1e-3,
            tangential: 0.1,
            reject_cosine: 0.5,
            iteration_count: 25,
        };
        let regression =
            |basis_count, kernel_length, ridge, step| RegressionOptions { basis_count, kernel_length, ridge, step };
        Self {
            coarse_fit: FitOptions {
                smoothness: vec![200.0, 60.0, 30.0, 20.0],
                reject_distance: vec![0.15, 0.12, 0.10, 0.08],
                ..common.clone()
            },
            base_fit: FitOptions {
                smoothness: vec![20.0, 5.0, 1.0, 0.3, 0.15],
                reject_distance: vec![0.08, 0.05],
                ..common.clone()
            },
            detail_fit: FitOptions { smoothness: vec![5.0, 1.5, 0.5], reject_distance: vec![0.05], ..common },
            view_smoothness: 8.0,
            deformation: BranchOptions {
                blend_steps: 2,
                smoothness: 6.0,
                shrinkage: 0.9,
                mirrored: true,
                keeps_rough_mean: true,
                wide: regression(8, 2.0, 1.0, 1.0 / 8192.0),
                narrow: regression(120, 0.6, 0.01, 1.0 / 8192.0),
                fade: [0.25, 0.41],
            },
            laplacian: BranchOptions {
                blend_steps: 2,
                smoothness: 30.0,
                // Far from training nothing is said: what all poses share is in the base, and any more makes strange poses worse.
                shrinkage: 0.0,
                mirrored: false,
                keeps_rough_mean: false,
                wide: regression(0, 2.0, 1.0, 2.0),
                narrow: regression(64, 0.25, 0.01, 2.0),
                fade: [0.06, 0.15],
            },
            laplacian_level: 1,
            clamp: 600.0,
        }
    }
}

impl CompactOptions {
    /// For sampled perceptrons in place of scans: free of noise and smooth in pose, so one kernel with hardly any ridge and finer steps.
    pub fn for_perceptrons() -> Self {
        let branch = |step| BranchOptions {
            blend_steps: 2,
            smoothness: 0.0,
            shrinkage: 1.0,
            mirrored: false,
            keeps_rough_mean: false,
            wide: RegressionOptions { basis_count: 32, kernel_length: 1.0, ridge: 1e-3, step },
            narrow: RegressionOptions { basis_count: 0, kernel_length: 1.0, ridge: 1e-3, step },
            fade: [0.0; 2],
        };
        Self { deformation: branch(3e-5), laplacian: branch(0.1), ..Self::default() }
    }
}
