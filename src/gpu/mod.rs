//! Frames on the GPU: everything from a pose to the vertex buffer in compute passes; nothing is read back.
//!
//! Each pass is a pair of files, the shader beside its host code, and names its twin: the function of the CPU's frame
//! (`animate`, `network`, `mesh`, `solver`) that it must agree with. Passes gather and never scatter, so that a frame repeats to the
//! last bit on one adapter. Nothing beyond WebGPU's default limits is used.

mod animator;
mod coarse_solve;
mod compact;
mod conjugate_gradients;
mod error;
mod finite;
mod frame;
mod history;
mod inverse_factor;
mod kernel;
mod multigrid;
mod normal_operator;
mod outline;
mod perceptron;
mod residual;
mod rotation;
mod skinning;
mod sparse;
mod surface;
mod timestamps;
mod topology;

#[cfg(test)]
mod tests;

pub use animator::{Cost, GpuAnimator};
pub use error::GpuError;
pub use timestamps::{StageTime, Timestamps};
