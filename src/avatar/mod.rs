//! The avatar and its file: a valid GLB with an extension (docs/format.md).

mod deflate;
mod document;
mod extension;
mod glb;
mod json;
mod quantise;
mod read;
mod source;
#[cfg(test)]
mod tests;
mod transfer;
mod validate;
mod write;

pub use glb::Glb;

use crate::body::Rig;
use crate::mesh::{Scheme, Triangle};
use crate::network::SurfaceFunction;
use crate::solver::{CoarseFactor, FactorError};
use glam::Vec3A;

/// What δ is relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// f_l is the surface's Laplacian (the paper's).
    Absolute,
    /// f_l is added to the Laplacian of the subdivided base: zero gives the base back exactly.
    Relative,
}

/// An encoded picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// `image/png` or `image/jpeg`.
    pub mime: String,
    /// The file's bytes.
    pub bytes: Vec<u8>,
}

/// What is drawn on the surface. Drawn vertices differ from the body's at texture seams.
#[derive(Clone, Debug, PartialEq)]
pub struct Appearance {
    /// Body vertex of each drawn vertex of level 0.
    pub drawn_vertices: Vec<u32>,
    /// Triangles of level 0 over drawn vertices, in the order of the body's triangles.
    pub drawn_triangles: Vec<Triangle>,
    /// (u, v) of each drawn vertex, v down, as glTF has it. Empty where there is no texture.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// The texture.
    pub texture: Option<Texture>,
    /// Linear RGB of each drawn vertex where there is no texture.
    pub vertex_colours: Vec<[u8; 3]>,
}

/// A trained avatar.
#[derive(Clone, Debug, PartialEq)]
pub struct Avatar {
    /// Name for people.
    pub name: String,
    /// The shaped body.
    pub rig: Rig,
    /// M_C: the neutral template with zero shape, where Q lives.
    pub canonical: Vec<Vec3A>,
    /// The body's triangles, level 0.
    pub triangles: Vec<Triangle>,
    /// What is drawn on it.
    pub appearance: Appearance,
    /// How the base is subdivided.
    pub scheme: Scheme,
    /// How often.
    pub level_count: u32,
    /// f_d, on level 0.
    pub deformation: SurfaceFunction,
    /// f_l.
    pub laplacian: SurfaceFunction,
    /// What f_l is relative to.
    pub form: Form,
    /// Anchor vertices on the finest level, ascending.
    pub anchors: Vec<u32>,
    /// w_a.
    pub anchor_weight: f32,
    /// The solver's prefactored data.
    pub factor: CoarseFactor,
    /// Free-form facts: command, seed, data, licence, trainer version.
    pub provenance: serde_json::Map<String, serde_json::Value>,
}

/// Why a file is not a usable avatar.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}: {field}: expected {expected}, found {found}")]
pub struct AvatarError {
    /// The file's name.
    pub file: String,
    /// Chunk, accessor or JSON path.
    pub field: String,
    /// What should be there.
    pub expected: String,
    /// What is there.
    pub found: String,
}

impl AvatarError {
    fn new(file: &str, field: &str, expected: impl ToString, found: impl ToString) -> Self {
        Self { file: file.into(), field: field.into(), expected: expected.to_string(), found: found.to_string() }
    }

    /// The surface function `field` of the avatar `name` leaves the range of numbers, at `vertex` in the rest pose.
    pub(crate) fn not_finite(name: &str, field: &str, vertex: usize) -> Self {
        Self::new(
            name,
            field,
            "finite values in the rest pose; train the avatar again",
            format!("others at vertex {vertex}"),
        )
    }

    /// The solver's complaint about the factor in `file`.
    pub(crate) fn from_factor(file: &str, error: &FactorError) -> Self {
        match error {
            FactorError::Length { field, expected, found } => {
                Self::new(file, &format!("factor.{field}"), format!("{expected} entries"), found)
            }
            FactorError::NotAPermutation { expected } => {
                let expected = format!("each of {expected} vertices once");
                Self::new(file, "factor.permutation", expected, "another list")
            }
            FactorError::Value { field, index, expected, found } => {
                Self::new(file, &format!("factor.{field}[{index}]"), expected, found)
            }
        }
    }
}
