//! Plain multilayer perceptrons, any width and depth, ReLU between layers.

use super::Domain;
use crate::body::Pose;
use crate::encoding::PositionalEncoding;
use glam::Vec3A;

/// y = W x + b.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// (outputs, inputs), row-major.
    pub weight: Vec<f32>,
    /// (outputs).
    pub bias: Vec<f32>,
}

impl Layer {
    /// Number of inputs.
    pub fn input_count(&self) -> usize {
        self.weight.len() / self.bias.len()
    }

    /// Number of outputs.
    pub fn output_count(&self) -> usize {
        self.bias.len()
    }
}

/// f(γ(Q), θ̄) with θ̄ the masked axis-angle numbers, three per joint (root always zero).
#[derive(Clone, Debug, PartialEq)]
pub struct Mlp {
    /// Level on whose vertices it is evaluated.
    pub level: u32,
    /// γ.
    pub encoding: PositionalEncoding,
    /// First layer takes γ(Q) then θ̄; the last gives three numbers.
    pub layers: Vec<Layer>,
    /// The output is the last layer's times this (targets are standardised in training).
    pub output_scale: f32,
}

impl Mlp {
    /// See [`super::SurfaceFunction::evaluate`].
    pub fn evaluate(&self, domain: &Domain, pose: &Pose, out: &mut [Vec3A]) {
        let _ = (domain, pose, out);
        todo!()
    }
}
