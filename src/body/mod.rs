//! SMPL-family bodies: shape space, skeleton, skinning.

mod read;

pub use crease_posing::joint_names::SMPL_JOINT_NAMES;
pub use crease_posing::rig::{Pose, Rig, Skin, posed_from_rest, put_posed_from_rest};

use crate::mesh::Triangle;
use glam::Vec3A;

/// Texture coordinates with their own topology: a seam has several coordinates for one vertex.
#[derive(Clone, Debug)]
pub struct TextureCoordinates {
    /// (u, v), v up, as OBJ and MakeHuman have them.
    pub coordinates: Vec<[f32; 2]>,
    /// Indices into `coordinates`, corner by corner of the body's triangles.
    pub triangles: Vec<Triangle>,
}

/// A body model of SMPL's convention.
#[derive(Clone, Debug)]
pub struct Body {
    /// Rest vertices of zero shape (`v_template`), metres, T-pose, y up, facing +z.
    pub template: Vec<Vec3A>,
    /// `shapedirs`: one displacement field per shape component, metres per unit.
    pub shape_directions: Vec<Vec<Vec3A>>,
    /// `posedirs`, if the model has them: one displacement field per entry of (R_j − I), joints 1.., row-major.
    pub pose_directions: Option<Vec<Vec<Vec3A>>>,
    /// `J_regressor`: for each joint, (vertex, weight) pairs.
    pub joint_regressor: Vec<Vec<(u32, f32)>>,
    /// Skinning weights, four influences a vertex.
    pub skin: Skin,
    /// Parent of each joint; the root has none; parents come before children.
    pub parents: Vec<Option<usize>>,
    /// Joint names, SMPL's where the file has none.
    pub joint_names: Vec<String>,
    /// Triangles.
    pub triangles: Vec<Triangle>,
    /// Texture coordinates, if the file has them (`vt`, `ft`).
    pub texture_coordinates: Option<TextureCoordinates>,
}

impl Body {
    /// Rest vertices and joints for shape coefficients `betas` (missing ones are zero).
    pub fn shaped(&self, betas: &[f32]) -> Rig {
        let mut rest = self.template.clone();
        for (direction, &beta) in self.shape_directions.iter().zip(betas) {
            for (vertex, offset) in rest.iter_mut().zip(direction) {
                *vertex += beta * *offset;
            }
        }
        let rest_joints =
            self.joint_regressor.iter().map(|row| row.iter().map(|&(v, w)| w * rest[v as usize]).sum()).collect();
        Rig {
            rest,
            rest_joints,
            parents: self.parents.clone(),
            joint_names: self.joint_names.clone(),
            skin: self.skin.clone(),
            pose_directions: self.pose_directions.clone(),
        }
    }
}
