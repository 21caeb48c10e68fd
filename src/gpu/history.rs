//! A first guess from the last two solutions, which stay on the GPU. Twin: `solver::history`.

use super::kernel::{Dispatch, Gpu, Kernel, Shader, front, storage, vectors, whole};
use crate::wgsl::wgsl;
use wgpu::{Buffer, BufferBinding, CommandEncoder};

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("history.wgsl"));

/// Partial sums, and workgroups that make them; each has five vectors.
const PARTIAL_COUNT: usize = 64;
const PARTIAL_BYTES: usize = 5 * size_of::<[f32; 4]>();

/// The entry points.
pub(super) struct HistoryKernels {
    products: Kernel,
    guess: Kernel,
    remember: Kernel,
}

/// The last two solutions, both of one level, and what A makes of them: zeros where there are none. All levels share the room.
pub(super) struct GpuHistory {
    latest: Buffer,
    latest_product: Buffer,
    before: Buffer,
    before_product: Buffer,
    partial: Buffer,
}

impl HistoryKernels {
    pub fn new(gpu: &Gpu) -> Self {
        let shader = Shader::new(gpu, "history", SOURCE);
        let [products, guess, remember] = ["products", "guess", "remember"].map(|entry| shader.kernel(entry));
        Self { products, guess, remember }
    }
}

impl GpuHistory {
    /// `vertex_count` is that of the finest level.
    pub fn new(gpu: &Gpu, vertex_count: usize) -> Self {
        let field = |label| vectors(gpu, label, vertex_count);
        Self {
            latest: field("history: latest"),
            latest_product: field("history: product of the latest"),
            before: field("history: before"),
            before_product: field("history: product of the one before"),
            partial: storage(gpu, "history: inner products", PARTIAL_COUNT * PARTIAL_BYTES),
        }
    }

    /// Forgets both: the next guess is zero.
    pub fn clear(&self, encoder: &mut CommandEncoder) {
        for buffer in [&self.latest, &self.latest_product, &self.before, &self.before_product] {
            encoder.clear_buffer(buffer, 0, None);
        }
    }

    /// x = the guess for the right side `side` on a level of `vertex_count` vertices.
    pub fn guess(&self, kernels: &HistoryKernels, vertex_count: usize, side: &Buffer, x: &Buffer) -> [Dispatch; 2] {
        let solutions = self.solutions(vertex_count);
        let [latest, _, before, _] = solutions.clone();
        let partial = (5, whole(&self.partial));
        let products: Vec<_> = solutions.into_iter().chain([(0, whole(side)), partial.clone()]).collect();
        let products = kernels.products.with_ranges([PARTIAL_COUNT as u32, 1, 1], &products);
        let guess = kernels.guess.over_ranges(vertex_count, &[latest, before, partial, (6, whole(x))]);
        [products, guess]
    }

    /// Keeps the solution `x`, which leaves `residual` of `side`, in place of the older one.
    pub fn remember(
        &self,
        kernels: &HistoryKernels,
        vertex_count: usize,
        side: &Buffer,
        x: &Buffer,
        residual: &Buffer,
    ) -> Dispatch {
        let fields = [(0, whole(side)), (6, whole(x)), (7, whole(residual))];
        let bindings: Vec<_> = self.solutions(vertex_count).into_iter().chain(fields).collect();
        kernels.remember.over_ranges(vertex_count, &bindings)
    }

    /// The solutions and their products, as far as a level of `vertex_count` vertices goes.
    fn solutions(&self, vertex_count: usize) -> [(u32, BufferBinding<'_>); 4] {
        let Self { latest, latest_product, before, before_product, .. } = self;
        let bytes = (vertex_count * size_of::<[f32; 4]>()) as u64;
        [(1, latest), (2, latest_product), (3, before), (4, before_product)]
            .map(|(number, buffer)| (number, front(buffer, bytes)))
    }
}
