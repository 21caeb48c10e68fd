//! What of an avatar a command shows: the same options wherever one moves.

use anyhow::ensure;
use clap::{Args, ValueEnum};
use crease::animate::{Options, Stage};

#[derive(Args)]
pub struct Shown {
    /// How far down the pipeline to go
    #[arg(long, value_enum, default_value_t = StageName::Detailed)]
    pub stage: StageName,
    /// 0 is the base, 1 as trained, 2 exaggerated
    #[arg(long, default_value_t = 1.0)]
    pub detail: f32,
    /// What poses far from training wear: 0 what is likeliest, which is smooth; 1 the folds of the nearest training poses
    #[arg(long, default_value_t = 1.0)]
    pub liveliness: f32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StageName {
    /// The skinned body
    Body,
    /// The pose-dependent base mesh
    Base,
    /// The detailed mesh
    Detailed,
}

impl Shown {
    /// For poses that follow each other. Fails where the detail is no number.
    pub fn options(&self) -> anyhow::Result<Options> {
        ensure!(self.detail.is_finite(), "--detail: expected a finite number, found {}", self.detail);
        let stage = match self.stage {
            StageName::Body => Stage::Body,
            StageName::Base => Stage::Base,
            StageName::Detailed => Stage::Detailed,
        };
        let (detail, liveliness) = (self.detail, self.liveliness);
        Ok(Options { stage, detail, liveliness, warm_start: true, ..Options::default() })
    }
}
