//! A first guess from the last two solutions of a level, which stay on the GPU. Twin: `solver::history`.

use super::kernel::{Dispatch, Kernel, Shader, storage, vectors};
use wgpu::{Buffer, CommandEncoder, Device};

/// WGSL of the pass.
pub(super) const SOURCE: &str = include_str!("history.wgsl");

/// Partial sums, and workgroups that make them; each has five vectors.
const PARTIAL_COUNT: usize = 64;
const PARTIAL_BYTES: usize = 5 * size_of::<[f32; 4]>();

/// The entry points.
pub(super) struct HistoryKernels {
    products: Kernel,
    guess: Kernel,
    remember: Kernel,
}

/// The last two solutions and what A makes of them: zeros where there are none.
pub(super) struct GpuHistory {
    latest: Buffer,
    latest_product: Buffer,
    before: Buffer,
    before_product: Buffer,
    partial: Buffer,
    vertex_count: usize,
}

impl HistoryKernels {
    pub fn new(device: &Device) -> Self {
        let shader = Shader::new(device, "history", SOURCE);
        let [products, guess, remember] = ["products", "guess", "remember"].map(|entry| shader.kernel(entry));
        Self { products, guess, remember }
    }
}

impl GpuHistory {
    pub fn new(device: &Device, vertex_count: usize) -> Self {
        let field = |label| vectors(device, label, vertex_count);
        Self {
            latest: field("history: latest"),
            latest_product: field("history: product of the latest"),
            before: field("history: before"),
            before_product: field("history: product of the one before"),
            partial: storage(device, "history: inner products", PARTIAL_COUNT * PARTIAL_BYTES),
            vertex_count,
        }
    }

    /// Forgets both: the next guess is zero.
    pub fn clear(&self, encoder: &mut CommandEncoder) {
        for buffer in [&self.latest, &self.latest_product, &self.before, &self.before_product] {
            encoder.clear_buffer(buffer, 0, None);
        }
    }

    /// x = the guess for the right side `side`, and `residual` what it leaves of it.
    pub fn guess(&self, kernels: &HistoryKernels, side: &Buffer, x: &Buffer, residual: &Buffer) -> [Dispatch; 2] {
        let mut bindings = self.bindings(side);
        bindings.push((5, &self.partial));
        let products = kernels.products.in_groups([PARTIAL_COUNT as u32, 1, 1], &bindings);
        bindings.extend([(6, x), (7, residual)]);
        [products, kernels.guess.over(self.vertex_count, &bindings)]
    }

    /// Keeps the solution `x`, which leaves `residual` of `side`, in place of the older one.
    pub fn remember(&self, kernels: &HistoryKernels, side: &Buffer, x: &Buffer, residual: &Buffer) -> Dispatch {
        let mut bindings = self.bindings(side);
        bindings.extend([(6, x), (7, residual)]);
        kernels.remember.over(self.vertex_count, &bindings)
    }

    fn bindings<'a>(&'a self, side: &'a Buffer) -> Vec<(u32, &'a Buffer)> {
        let Self { latest, latest_product, before, before_product, .. } = self;
        vec![(0, side), (1, latest), (2, latest_product), (3, before), (4, before_product)]
    }
}
