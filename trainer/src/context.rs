//! What training strategies are given, and the two traits they implement.

use crate::checkpoint::{Checkpoint, Fingerprint, Ingredients};
use crate::options::TrainOptions;
use crate::progress::Progress;
use crate::run_log::RunLog;
use crate::sequence::{Frame, Sequence};
use anyhow::{Context, ensure};
use crease::body::{Body, Pose, Rig};
use crease::laplacian::sample_elimination;
use crease::mesh::{Adjacency, Subdivision, Triangle, mixed_voronoi_areas};
use crease::network::{Domain, SurfaceFunction};
use crease::numpy::ReadError;
use glam::Vec3A;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// One training frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sample {
    /// Index into [`TrainContext::sequences`].
    pub sequence: usize,
    /// Frame of that sequence.
    pub frame: usize,
}

impl Sample {
    /// Name of this frame's result of the computation `name`.
    pub fn name(self, name: &str) -> String {
        format!("{name}-{}-{:05}", self.sequence, self.frame)
    }
}

/// Everything that training strategies share: constant while they run.
pub struct TrainContext {
    /// The body model.
    pub body: Body,
    /// The body in the person's shape.
    pub rig: Rig,
    /// The sequences: the same person in the same clothes.
    pub sequences: Vec<Sequence>,
    /// Frames to train on, in order; at least one.
    pub samples: Vec<Sample>,
    /// Subdivision of the body's mesh.
    pub subdivision: Subdivision,
    /// Neighbours on the body's mesh, level 0.
    pub adjacency: Adjacency,
    /// Neighbours on the finest level.
    pub finest_adjacency: Adjacency,
    /// Query points and pose masks of levels 0 ..= `level_count`.
    pub domains: Vec<Domain>,
    /// Anchors on the finest level, ascending.
    pub anchors: Vec<u32>,
    /// All choices.
    pub options: TrainOptions,
    /// Where progress is shown.
    pub progress: Progress,
    /// Where results are kept, for a run that is broken off and taken up again.
    pub checkpoint: Checkpoint,
    /// What the run tells when it is over.
    pub log: RunLog,
    /// Of scans that were read already: several stages ask, and a run takes its input not to change.
    scans: Mutex<HashMap<Sample, Fingerprint>>,
}

impl TrainContext {
    /// Prepares training of `body` on `samples` of `sequences`.
    ///
    /// Fails where there is nothing to train on, or where the sequences disagree about the person's shape.
    pub fn new(
        body: Body,
        sequences: Vec<Sequence>,
        samples: Vec<Sample>,
        options: TrainOptions,
        progress: Progress,
    ) -> anyhow::Result<Self> {
        let first = sequences.first().context("sequences: expected at least one, found none")?;
        ensure!(!samples.is_empty(), "frames: expected at least one, found none");
        for other in &sequences {
            let same = other.betas.len() == first.betas.len()
                && other.betas.iter().zip(&first.betas).all(|(a, b)| (a - b).abs() < 1e-4);
            ensure!(
                same,
                "{}: body.npz betas: expected {:?} as in {}, found {:?}",
                other.capture.directory.display(),
                first.betas,
                first.capture.directory.display(),
                other.betas
            );
        }
        for sequence in &sequences {
            let count = sequence.poses[0].rotations.len();
            ensure!(
                count == body.parents.len(),
                "{}: body.npz: expected poses of {} joints as the body has, found {count}",
                sequence.capture.directory.display(),
                body.parents.len()
            );
        }
        let rig = body.shaped(&first.betas);
        let level_count = options.level_count as usize;
        let subdivision = Subdivision::new(body.template.len(), &body.triangles, level_count);
        let domains = Domain::levels(&body.template, &body.skin, &subdivision, level_count);
        let finest = &domains[level_count].canonical;
        Ok(Self {
            adjacency: Adjacency::new(body.template.len(), &body.triangles),
            finest_adjacency: Adjacency::new(finest.len(), subdivision.triangles(level_count)),
            anchors: spread_anchors(finest, subdivision.triangles(level_count), options.anchor_count),
            rig,
            body,
            sequences,
            samples,
            subdivision,
            domains,
            options,
            progress,
            checkpoint: Checkpoint::default(),
            log: RunLog::default(),
            scans: Mutex::default(),
        })
    }

    /// Number of subdivisions.
    pub fn level_count(&self) -> usize {
        self.subdivision.level_count()
    }

    /// Subdivision level on which f_l's tables stand.
    pub fn laplacian_level(&self) -> usize {
        (self.options.compact.laplacian_level as usize).min(self.level_count())
    }

    /// The pose of a training frame.
    pub fn pose(&self, sample: Sample) -> &Pose {
        &self.sequences[sample.sequence].poses[sample.frame]
    }

    /// The poses of all training frames, in order.
    pub fn poses(&self) -> Vec<Pose> {
        self.samples.iter().map(|&sample| self.pose(sample).clone()).collect()
    }

    /// What the computation `name` depends on whatever the frame: options and body.
    pub fn ingredients(&self, name: &str) -> Ingredients {
        let Rig { rest, rest_joints, parents, joint_names: _, skin, pose_directions } = &self.rig;
        let directions = pose_directions.iter().flatten();
        let common = Ingredients::new(name)
            .value(&self.options)
            .points(&self.body.template)
            .points(rest)
            .points(rest_joints)
            .value(&(parents, &self.body.triangles, &skin.joints, &skin.weights));
        directions.fold(common, |ingredients, direction| ingredients.points(direction))
    }

    /// What the computation `name` for one training frame depends on: options, body, pose and scan.
    pub fn frame_ingredients(&self, name: &str, sample: Sample) -> Result<Ingredients, ReadError> {
        let Pose { rotations, translation } = self.pose(sample);
        let scan = self.scan_fingerprint(sample)?;
        let ingredients = self.ingredients(name);
        Ok(ingredients.bytes(bytemuck::cast_slice(rotations)).points(&[(*translation).into()]).bytes(&scan.0))
    }

    fn scan_fingerprint(&self, sample: Sample) -> Result<Fingerprint, ReadError> {
        let known = || self.scans.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(&fingerprint) = known().get(&sample) {
            return Ok(fingerprint);
        }
        let fingerprint = self.scan(sample)?.fingerprint();
        known().insert(sample, fingerprint);
        Ok(fingerprint)
    }

    /// Reads the scan of a training frame, its points weighted as the options say.
    pub fn scan(&self, sample: Sample) -> Result<Frame, ReadError> {
        let mut scan = self.sequences[sample.sequence].capture.scan(sample.frame)?;
        scan.weigh(self.options.nearness);
        Ok(scan)
    }
}

/// `count` vertices of a mesh (metres), spread evenly over it; ascending.
pub fn spread_anchors(positions: &[Vec3A], triangles: &[Triangle], count: usize) -> Vec<u32> {
    let mut areas = vec![0.0; positions.len()];
    mixed_voronoi_areas(positions, triangles, &mut areas);
    sample_elimination(positions, areas.iter().sum(), count)
}

/// What training of f_d leaves.
pub struct TrainedDeformation {
    /// f_d on level 0: metres, canonical frame.
    pub function: SurfaceFunction,
    /// The poses of [`TrainContext::samples`] that it goes with, where training moved them.
    pub poses: Option<Vec<Pose>>,
}

impl TrainedDeformation {
    /// Gives `context` the poses that f_d goes with, and f_d.
    pub fn adopt(self, context: &mut TrainContext) -> SurfaceFunction {
        for (&sample, pose) in context.samples.iter().zip(self.poses.into_iter().flatten()) {
            context.sequences[sample.sequence].poses[sample.frame] = pose;
        }
        self.function
    }
}

impl From<SurfaceFunction> for TrainedDeformation {
    /// For poses as they are.
    fn from(function: SurfaceFunction) -> Self {
        Self { function, poses: None }
    }
}

/// Trains f_d.
pub trait DeformationTrainer {
    /// f_d, and the poses where the options ask for them to be refined on the way.
    fn train(&self, context: &TrainContext) -> anyhow::Result<TrainedDeformation>;
}

/// Trains f_l for a given f_d.
pub trait LaplacianTrainer {
    /// f_l: 1/m, canonical frame, absolute or relative as the options say.
    fn train(&self, context: &TrainContext, deformation: &SurfaceFunction) -> anyhow::Result<SurfaceFunction>;
}
