//! A = c LᵀL + BᵀB on one level, and its smoother.

use super::kernel::{Dispatch, Gpu, Kernel, Shader, storage_of, uniform_of, vectors};
use super::topology::GpuRings;
use crate::solver::OperatorParts;
use crate::wgsl::wgsl;
use wgpu::Buffer;

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("normal_operator.wgsl"));

/// The entry points.
pub(super) struct OperatorKernels {
    halfway: Kernel,
    product: Kernel,
    residual: Kernel,
    right_side: Kernel,
    smooth_first: Kernel,
    smooth_more: Kernel,
}

/// One level's operator in GPU buffers.
pub(super) struct GpuOperator {
    level: Buffer,
    rings: GpuRings,
    anchor_offsets: Buffer,
    anchor_entries: Buffer,
    scaling: Buffer,
    middle: Buffer,
    vertex_count: usize,
}

impl OperatorKernels {
    pub fn new(gpu: &Gpu) -> Self {
        let shader = Shader::new(gpu, "normal operator", SOURCE);
        let [halfway, product, residual, right_side, smooth_first, smooth_more] =
            ["halfway", "product", "residual", "right_side", "smooth_first", "smooth_more"]
                .map(|entry| shader.kernel(entry));
        Self { halfway, product, residual, right_side, smooth_first, smooth_more }
    }
}

impl GpuOperator {
    /// `scaling` and `weights` are the smoother's a, α and β.
    pub fn new(gpu: &Gpu, operator: &OperatorParts<'_>, scaling: &[f32], weights: [f32; 2]) -> Self {
        let vertex_count = operator.vertex_count();
        let anchors = operator.anchors.transposed().times(operator.anchors);
        Self {
            level: uniform_of(gpu, "operator", &[operator.scale, weights[0], weights[1], 0.0]),
            rings: GpuRings::new(gpu, (0..vertex_count).map(|vertex| operator.neighbours(vertex))),
            anchor_offsets: storage_of(gpu, "operator: anchors' offsets", &anchors.offsets),
            anchor_entries: storage_of(gpu, "operator: anchors", &anchors.entries),
            scaling: storage_of(gpu, "operator: scaling", scaling),
            middle: vectors(gpu, "operator: middle", vertex_count),
            vertex_count,
        }
    }

    pub fn rings(&self) -> &GpuRings {
        &self.rings
    }

    /// out = A x.
    pub fn product(&self, kernels: &OperatorKernels, x: &Buffer, out: &Buffer) -> [Dispatch; 2] {
        [self.halfway(kernels, x), self.other_half(&kernels.product, x, out, None)]
    }

    /// out = b − A x.
    pub fn residual(&self, kernels: &OperatorKernels, x: &Buffer, b: &Buffer, out: &Buffer) -> [Dispatch; 2] {
        [self.halfway(kernels, x), self.other_half(&kernels.residual, x, out, Some(b))]
    }

    /// out = c Lᵀ r.
    pub fn right_side(&self, kernels: &OperatorKernels, r: &Buffer, out: &Buffer) -> Dispatch {
        let buffers = [(0, &self.level), (1, &self.rings.offsets), (2, &self.rings.neighbours), (3, r), (4, out)];
        kernels.right_side.over(self.vertex_count, &buffers)
    }

    /// out = Q r.
    pub fn smooth_first(&self, kernels: &OperatorKernels, r: &Buffer, out: &Buffer) -> Dispatch {
        self.smooth(&kernels.smooth_first, r, out)
    }

    /// out += Q r.
    pub fn smooth_more(&self, kernels: &OperatorKernels, r: &Buffer, out: &Buffer) -> Dispatch {
        self.smooth(&kernels.smooth_more, r, out)
    }

    fn smooth(&self, kernel: &Kernel, r: &Buffer, out: &Buffer) -> Dispatch {
        let Self { level, rings, scaling, .. } = self;
        let buffers = [(0, level), (1, &rings.offsets), (2, &rings.neighbours), (3, r), (4, out), (9, scaling)];
        kernel.over(self.vertex_count, &buffers)
    }

    fn halfway(&self, kernels: &OperatorKernels, x: &Buffer) -> Dispatch {
        let Self { level, rings, middle, .. } = self;
        let buffers = [(0, level), (1, &rings.offsets), (2, &rings.neighbours), (3, x), (4, middle)];
        kernels.halfway.over(self.vertex_count, &buffers)
    }

    fn other_half(&self, kernel: &Kernel, x: &Buffer, out: &Buffer, side: Option<&Buffer>) -> Dispatch {
        let Self { rings, anchor_offsets, anchor_entries, middle, .. } = self;
        let mut buffers = vec![
            (1, &rings.offsets),
            (2, &rings.neighbours),
            (3, x),
            (4, out),
            (5, anchor_offsets),
            (6, anchor_entries),
            (7, middle),
        ];
        buffers.extend(side.map(|side| (8, side)));
        kernel.over(self.vertex_count, &buffers)
    }
}
