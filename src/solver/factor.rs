//! The coarse level's LDLᵀ factor: made once for an avatar, stored in its file in half precision.

use crate::mesh::Subdivision;
use half::f16;

/// P A₀ Pᵀ = L D Lᵀ of the Galerkin operator on level 0.
///
/// As a preconditioner it may be coarse: half precision is enough, and L D Lᵀ stays positive definite whatever the rounding.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarseFactor {
    /// `permutation[i]` is the vertex that elimination step i removes.
    pub permutation: Vec<u32>,
    /// D, one entry a column.
    pub diagonal: Vec<f32>,
    /// Entries of L below the diagonal, column by column, rows ascending; the pattern follows from topology and permutation.
    pub values: Vec<f16>,
}

impl CoarseFactor {
    /// Orders and factors. `anchors` are vertices of the finest level.
    #[cfg(feature = "factor")]
    pub fn new(subdivision: &Subdivision, anchors: &[u32], anchor_weight: f32) -> Self {
        let _ = (subdivision, anchors, anchor_weight);
        todo!()
    }
}
