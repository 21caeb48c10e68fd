//! Why frames cannot be computed on an adapter, so that a page can fall to its next backend.

/// What stands in the way.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GpuError {
    /// The adapter is a program on the CPU: computing there without it is faster.
    #[error("the adapter {name} is a software renderer")]
    Software {
        /// The adapter's name.
        name: String,
    },
    /// The avatar needs more than the device grants.
    #[error("the avatar needs {needed} of {limit}, the device has {found}")]
    Limit {
        /// WebGPU's name of the limit.
        limit: &'static str,
        /// What the avatar needs.
        needed: u64,
        /// What there is.
        found: u64,
    },
}
