//! The pose of a clothed body: as registration, but what stands off the skin is known, and every point counts alike.

use super::articulated::{ArticulatedBody, State};
use super::frame_fit::{Evidence, Model, fit_frame};
use super::priors::{Expected, PriorWeights};
use super::scan_term::{Cloud, Surface};
use super::separation::Proxies;
use super::start::stage;
use crate::sequence::Frame;
use crease::body::{Body, Pose};
use glam::Vec3A;

/// A person whose poses are refined.
pub struct DressedPerson<'a> {
    body: &'a Body,
    betas: &'a [f32],
    surface: Surface,
    proxies: Proxies,
}

/// How strongly a refined pose is held to the one that it started from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Weight of a radian of a joint's rotation, squared, against the scan's mean square in m².
    pub rotation_weight: f64,
    /// Weight of a metre of the translation, squared.
    pub translation_weight: f64,
}

impl<'a> DressedPerson<'a> {
    /// A person of this shape.
    pub fn new(body: &'a Body, betas: &'a [f32]) -> Self {
        let articulated = ArticulatedBody::new(body, 0);
        Self { body, betas, surface: Surface::dressed(&articulated), proxies: Proxies::new(&articulated) }
    }

    /// The pose, near `initial`, in which the body with `clothes` on (metres from its rest vertices) is closest to the scan of `frame`.
    pub fn refined(&self, frame: &Frame, clothes: Vec<Vec3A>, initial: &Pose, hold: Hold) -> anyhow::Result<Pose> {
        let model = Model {
            body: ArticulatedBody::new(self.body, 0).wearing(clothes),
            surface: self.surface.clone(),
            proxies: self.proxies.clone(),
            // How people usually stand is in the pose that it starts from.
            priors: PriorWeights { pose: 0.0, ..PriorWeights::default() },
        };
        let expected = Expected {
            rotations: initial.rotations.clone(),
            translation: initial.translation,
            rotation_weight: hold.rotation_weight,
            translation_weight: hold.translation_weight,
        };
        let cloud = Cloud::new(frame);
        let evidence = Evidence { cloud: &cloud, keypoints: None, expected: Some(&expected) };
        let start = State { betas: self.betas.to_vec(), pose: initial.clone() };
        let stages = [stage(2_500, 0.06, 0.4, 4), stage(5_000, 0.03, 0.5, 6)];
        Ok(fit_frame(&model, evidence, &start, &stages, false)?.0.pose)
    }
}
