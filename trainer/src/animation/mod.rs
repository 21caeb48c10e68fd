//! A whole motion in one file: USD with every frame's mesh, or a GLB that moves its bones.

mod baked;
mod skinned;
mod usda;

pub use baked::{BakedFigure, bake};
pub use skinned::skinned_glb;
pub use usda::{Length, UsdaFile};
