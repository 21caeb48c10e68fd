//! The compact form: per region of the surface, value(v) = mean(v) + Σ_k c_k(θ̄) b_k(v).
//!
//! Q(v) never changes and θ̄ takes few distinct values, so the trunk (mean and basis) is tabulated once for each vertex and only the
//! branch c runs every frame, once a region. Neighbouring regions overlap with weights that sum to one (folded into the tables), so
//! that the value is continuous over the surface.

use crate::body::Pose;
use crate::pose_feature::PoseMask;
use glam::Vec3A;

/// A region: the rows `rows.0 .. rows.1` of the tables, one pose mask, one branch.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Joints that the branch listens to.
    pub mask: PoseMask,
    /// First row and one past the last.
    pub rows: (u32, u32),
    /// Length of the kernel in the space of masked six-number rotations.
    pub kernel_length: f32,
    /// (K, centres) row-major: c = `coefficient_from_kernel` · κ(θ̄), κ_i = Matérn-3/2 of the distance to centre i.
    pub coefficient_from_kernel: Vec<f32>,
    /// Added to c (length K).
    pub coefficient_bias: Vec<f32>,
}

/// Trunk tables and branches.
#[derive(Clone, Debug, PartialEq)]
pub struct Compact {
    /// Level on whose vertices the tables stand.
    pub level: u32,
    /// K: basis functions a region.
    pub basis_count: u32,
    /// Poses of training: (centres, joints, 6) rotations as their first two columns.
    pub centres: Vec<f32>,
    /// Number of centres.
    pub centre_count: u32,
    /// The regions; their row ranges follow each other.
    pub regions: Vec<Region>,
    /// Vertex that each row adds to.
    pub row_vertices: Vec<u32>,
    /// (rows, 3): mean, in the function's unit.
    pub mean: Vec<f32>,
    /// (rows, K, 3): basis as small integers.
    pub basis: Vec<i8>,
    /// (regions, K): size of one step of `basis`, in the function's unit.
    pub basis_step: Vec<f32>,
}

impl Compact {
    /// See [`super::SurfaceFunction::evaluate`]; `out` has one entry for each vertex of the level.
    pub fn evaluate(&self, pose: &Pose, out: &mut [Vec3A]) {
        let _ = (pose, out);
        todo!()
    }
}
