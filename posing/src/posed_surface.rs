//! The posed body on every level of its subdivision.

use crate::mesh::{Scheme, Subdivision};
use crate::rig::{Pose, Rig, put_posed_from_rest};
use glam::{Affine3A, Mat3A, Vec3A};

/// Positions and rotations of all levels for one pose, in memory that is reused from pose to pose.
#[derive(Clone, Debug)]
pub struct PosedSurface {
    posed_from_rest: Vec<Affine3A>,
    blended: Vec<Affine3A>,
    positions: Vec<Vec<Vec3A>>,
    rotations: Vec<Vec<Mat3A>>,
}

impl PosedSurface {
    /// For all levels of `subdivision`; the first pose makes the room that it needs.
    pub fn new(subdivision: &Subdivision) -> Self {
        let level_count = subdivision.level_count() + 1;
        Self {
            posed_from_rest: Vec::new(),
            blended: Vec::new(),
            positions: vec![Vec::new(); level_count],
            rotations: vec![Vec::new(); level_count],
        }
    }

    /// Poses level 0, v' = LBS_θ(v + `offsets`(v) + pose blend shapes) (paper Eq. pose_dependent_offsets_vert), and subdivides it up to
    /// `level`.
    /// `offsets` has one entry a vertex of level 0, metres, in the rest pose's frame; empty for none.
    pub fn pose(
        &mut self,
        rig: &Rig,
        offsets: &[Vec3A],
        pose: &Pose,
        subdivision: &Subdivision,
        scheme: Scheme,
        level: usize,
    ) {
        for (level, positions) in self.positions[..=level].iter_mut().enumerate() {
            positions.resize(subdivision.vertex_count(level), Vec3A::ZERO);
        }
        let posed = &mut self.positions[0];
        posed.copy_from_slice(&rig.rest);
        self.blended.resize(posed.len(), Affine3A::IDENTITY);
        for (position, offset) in posed.iter_mut().zip(offsets) {
            *position += *offset;
        }
        rig.add_pose_blend_shapes(pose, posed);
        put_posed_from_rest(rig, pose, &mut self.posed_from_rest);
        for (vertex, (position, blended)) in posed.iter_mut().zip(&mut self.blended).enumerate() {
            *blended = rig.skin.blend(vertex, &self.posed_from_rest);
            *position = blended.transform_point3a(*position);
        }
        subdivision.refine_upwards(scheme, 0, &mut self.positions[..=level]);
    }

    /// Positions of the vertices of `level`, metres.
    pub fn positions(&self, level: usize) -> &[Vec3A] {
        &self.positions[level]
    }

    /// Positions of the finest level, metres.
    pub fn finest(&self) -> &[Vec3A] {
        &self.positions[self.positions.len() - 1]
    }

    /// LBS^rot at the vertices of `level`: the blended matrices with the translation dropped, new vertices half-way between the ends
    /// of their edge. They take vectors of the rest pose's frame to the posed frame and are not quite rotations near joints.
    pub fn rotations(&mut self, subdivision: &Subdivision, level: usize) -> &[Mat3A] {
        self.rotations[0].clear();
        self.rotations[0].extend(self.blended.iter().map(|blended| blended.matrix3));
        for coarse_level in 0..level {
            let (coarse, fine) = self.rotations.split_at_mut(coarse_level + 1);
            fine[0].resize(subdivision.vertex_count(coarse_level + 1), Mat3A::IDENTITY);
            subdivision.refine(Scheme::Midpoint, coarse_level, &coarse[coarse_level], &mut fine[0]);
        }
        &self.rotations[level]
    }

    /// Takes `vectors` at the vertices of `level` from the rest pose's frame to the posed one.
    pub fn turn(&mut self, subdivision: &Subdivision, level: usize, vectors: &mut [Vec3A]) {
        for (vector, rotation) in vectors.iter_mut().zip(self.rotations(subdivision, level)) {
            *vector = *rotation * *vector;
        }
    }
}
