//! The arithmetic of a frame: from a pose to a detailed surface.
//!
//! What every frame runs is here, and what it needs to be set up. It is a crate of its own because the web's module compiles it for speed,
//! and everything else for size. `crease` shows these rooms as its own.

pub mod encoding;
pub mod joint_names;
pub mod laplacian;
pub mod mesh;
pub mod network;
pub mod order;
pub mod pose_feature;
pub mod posed_surface;
pub mod rig;
pub mod rotation;
pub mod solver;
pub mod surface_vertex;
pub mod threads;
