//! f_l as a multilayer perceptron (paper, Neural surface Laplacian function).

use super::regression::{Pairs, Regression};
use crate::checkpoint::Fingerprint;
use crate::context::{LaplacianTrainer, TrainContext};
use crate::targets::{offsets, quadratic_targets};
use crease::network::{Mlp, SurfaceFunction};
use std::sync::OnceLock;

/// Trains f_l by gradient descent on E_l, with quadratic fits at scan points.
pub struct PlainLaplacian;

impl LaplacianTrainer for PlainLaplacian {
    fn train(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<SurfaceFunction> {
        Ok(SurfaceFunction::Mlp(self.fit(context, deformation)?.0))
    }
}

impl PlainLaplacian {
    /// The trained network, and the mean of E_l (of standardised targets) over each epoch.
    pub fn fit(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<(Mlp, Vec<f32>)> {
        let inputs: Vec<OnceLock<Fingerprint>> = vec![OnceLock::new(); context.samples.len()];
        let read = |index: usize| {
            let sample = context.samples[index];
            let inputs = match inputs[index].get() {
                Some(&known) => known,
                None => {
                    let base = offsets(context, deformation, sample);
                    let found = context.frame_ingredients("targets", sample)?.points(&base).finish();
                    *inputs[index].get_or_init(|| found)
                }
            };
            let measure = || quadratic_targets(context, deformation, sample);
            context.checkpoint.remember(&sample.name("targets"), inputs, measure)
        };
        let pairs = Pairs::read(context, "measuring Laplacians", read)?;
        pairs.regress(
            context,
            Regression {
                name: "laplacian",
                title: "training the detail",
                level: context.level_count(),
                network: &context.options.laplacian.network,
                // A seed of its own, so that f_l does not depend on how many numbers f_d drew.
                seed: context.options.seed.wrapping_add(1),
                rate: |_| 1.0,
            },
        )
    }
}
