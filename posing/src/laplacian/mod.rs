//! The uniform-angle Laplacian (paper Eq. approxLB, divided to topology only) and its anchors.

mod anchors;
mod operator;

pub use anchors::sample_elimination;
pub use operator::{
    apply_topological, apply_topological_transposed, put_residual, reciprocal_valence, reciprocal_valences,
    scale_per_area,
};
