//! Scans of a clothed person in, a crease avatar out.
//!
//! [`sequence`] reads what was captured; [`train`] turns it into an [`crease::avatar::Avatar`] by strategies that share one
//! [`context`]; [`evaluate`] says how good it is. Units are metres, radians and seconds; y is up; Laplacian coordinates δ are in
//! 1/m and point outward on a sphere.

pub mod ablation;
pub mod animation;
pub mod appearance;
pub mod check;
pub mod checkpoint;
pub mod closest;
pub mod coefficients;
pub mod compact;
pub mod comparison;
pub mod config;
pub mod context;
pub mod cotangent;
pub mod evaluate;
pub mod files;
pub mod frames;
pub mod import;
pub mod interrupt;
pub mod localise;
pub mod mesh_file;
pub mod motion_measures;
pub mod nearest;
pub mod normals;
pub mod options;
pub mod plain;
pub mod ply;
pub mod progress;
pub mod quadratic;
pub mod refinement;
pub mod registration;
pub mod report;
pub mod resident;
pub mod residue;
pub mod run_log;
pub mod sampling;
pub mod scan_file;
pub mod sequence;
#[cfg(test)]
mod shapes;
pub mod sizes;
pub mod studio;
pub mod targets;
#[cfg(test)]
mod test_folder;
pub mod texture;
pub mod train;
pub mod visibility;
