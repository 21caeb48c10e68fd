//! Multilayer perceptrons trained on what the compact form's tables are made from: meshes fitted to the scans, and the reconstruction's own
//! operator on them.

use super::regression::{Pairs, Regression};
use crate::compact::{CompactDeformation, CompactLaplacian};
use crate::context::{DeformationTrainer, LaplacianTrainer, TrainContext, TrainedDeformation};
use crate::targets::Target;
use crease::network::{Mlp, SurfaceFunction};
use glam::Vec3A;

/// Trains f_d on fitted offsets.
pub struct FittedDeformation;

/// Trains f_l on operator Laplacians, on the level of the compact form's tables.
pub struct FittedLaplacian;

impl DeformationTrainer for FittedDeformation {
    fn train(&self, context: &TrainContext) -> anyhow::Result<TrainedDeformation> {
        Ok(SurfaceFunction::Mlp(self.regress(context, &CompactDeformation.fit(context)?)?).into())
    }
}

impl LaplacianTrainer for FittedLaplacian {
    fn train(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<SurfaceFunction> {
        Ok(SurfaceFunction::Mlp(self.regress(context, &CompactLaplacian.fit(context, deformation)?)?))
    }
}

impl FittedDeformation {
    /// f_d from the offsets of every training frame on level 0.
    pub fn regress(&self, context: &TrainContext, offsets: &[Vec<Vec3A>]) -> anyhow::Result<Mlp> {
        let regression = Regression {
            name: "fitted-deformation",
            title: "training the base",
            level: 0,
            network: &context.options.deformation.network,
            seed: context.options.seed,
            rate: FALLING,
        };
        regress(context, offsets, regression)
    }
}

impl FittedLaplacian {
    /// f_l from the canonical δ of every training frame on the level of the compact form's tables.
    pub fn regress(&self, context: &TrainContext, deltas: &[Vec<Vec3A>]) -> anyhow::Result<Mlp> {
        let regression = Regression {
            name: "fitted-laplacian",
            title: "training the detail",
            level: context.laplacian_level(),
            network: &context.options.laplacian.network,
            seed: context.options.seed.wrapping_add(1),
            rate: FALLING,
        };
        regress(context, deltas, regression)
    }
}

/// Fits have no outliers left, so the last steps may be as small as they like.
const FALLING: fn(f64) -> f64 = |done| 1.0 - done;

fn regress(context: &TrainContext, fields: &[Vec<Vec3A>], regression: Regression<'_>) -> anyhow::Result<Mlp> {
    let domain = &context.domains[regression.level];
    let read = |index: usize| {
        let points = domain.canonical.iter().zip(&domain.masks).zip(&fields[index]);
        let target = |((&canonical, &mask), &value)| Target { canonical, mask, value, weight: 1.0 };
        Ok(points.map(target).collect())
    };
    Ok(Pairs::read(context, "collecting fits", read)?.regress(context, regression)?.0)
}
