//! The little that this room needs of wgpu: kernels, buffers, and dispatches that are recorded once and run every frame.

use crate::filled_buffer::filled_buffer;
use wgpu::*;

/// Invocations of a workgroup where a thread does a vertex.
pub(super) const WORKGROUP: usize = 64;

/// Most workgroups of a dispatch in one dimension, by WebGPU's default limits.
pub(super) const WORKGROUP_LIMIT: usize = 65_535;

/// A device, and the queue through which its buffers are filled.
#[derive(Clone)]
pub(super) struct Gpu {
    pub device: Device,
    pub queue: Queue,
}

/// A WGSL module on a device.
pub(super) struct Shader<'a> {
    device: &'a Device,
    module: ShaderModule,
    label: &'static str,
}

/// One entry point, ready to be bound.
pub(super) struct Kernel {
    device: Device,
    pipeline: ComputePipeline,
    label: &'static str,
}

/// A kernel with its buffers and its size.
#[derive(Clone)]
pub(super) struct Dispatch {
    pipeline: ComputePipeline,
    group: BindGroup,
    workgroups: [u32; 3],
    /// Bytes of all its bindings: what it moves if it touches each number once.
    pub bytes: u64,
    /// What it is bound to.
    pub buffers: Vec<Buffer>,
}

impl<'a> Shader<'a> {
    pub fn new(Gpu { device, .. }: &'a Gpu, label: &'static str, source: &str) -> Self {
        let descriptor = ShaderModuleDescriptor { label: Some(label), source: ShaderSource::Wgsl(source.into()) };
        Self { device, module: device.create_shader_module(descriptor), label }
    }

    pub fn kernel(&self, entry: &'static str) -> Kernel {
        let pipeline = self.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: Some(self.label),
            layout: None,
            module: &self.module,
            entry_point: Some(entry),
            // Every kernel writes its workgroup's memory before it reads it.
            compilation_options: PipelineCompilationOptions {
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        });
        Kernel { device: self.device.clone(), pipeline, label: entry }
    }
}

impl Kernel {
    /// A thread for each of `count`, in workgroups of [`WORKGROUP`]; `buffers` are those that the entry point uses, with their numbers.
    pub fn over(&self, count: usize, buffers: &[(u32, &Buffer)]) -> Dispatch {
        self.in_groups([count.div_ceil(WORKGROUP) as u32, 1, 1], buffers)
    }

    /// The same over parts of buffers.
    pub fn over_ranges(&self, count: usize, bindings: &[(u32, BufferBinding<'_>)]) -> Dispatch {
        self.with_ranges([count.div_ceil(WORKGROUP) as u32, 1, 1], bindings)
    }

    /// So many workgroups.
    pub fn in_groups(&self, workgroups: [u32; 3], buffers: &[(u32, &Buffer)]) -> Dispatch {
        let bindings: Vec<_> = buffers.iter().map(|&(number, buffer)| (number, whole(buffer))).collect();
        self.with_ranges(workgroups, &bindings)
    }

    /// So many workgroups, over parts of buffers.
    pub fn with_ranges(&self, workgroups: [u32; 3], bindings: &[(u32, BufferBinding<'_>)]) -> Dispatch {
        let size = |binding: &BufferBinding<'_>| binding.size.map_or(binding.buffer.size() - binding.offset, u64::from);
        let entries: Vec<BindGroupEntry<'_>> = bindings
            .iter()
            .map(|(number, binding)| BindGroupEntry {
                binding: *number,
                resource: BindingResource::Buffer(binding.clone()),
            })
            .collect();
        let group = self.device.create_bind_group(&BindGroupDescriptor {
            label: Some(self.label),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let bytes = bindings.iter().map(|(_, binding)| size(binding)).sum();
        let buffers = bindings.iter().map(|(_, binding)| binding.buffer.clone()).collect();
        Dispatch { pipeline: self.pipeline.clone(), group, workgroups, bytes, buffers }
    }
}

impl Dispatch {
    pub fn record(&self, pass: &mut ComputePass<'_>) {
        let [x, y, z] = self.workgroups;
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(x, y, z);
    }
}

/// All of a buffer.
pub(super) fn whole(buffer: &Buffer) -> BufferBinding<'_> {
    buffer.as_entire_buffer_binding()
}

/// The first `bytes` of a buffer.
pub(super) fn front(buffer: &Buffer, bytes: u64) -> BufferBinding<'_> {
    BufferBinding { buffer, offset: 0, size: BufferSize::new(bytes) }
}

/// Buffers at bindings 0, 1, 2 …
pub(super) fn numbered<const N: usize>(buffers: [&Buffer; N]) -> [(u32, &Buffer); N] {
    let mut number = 0..;
    buffers.map(|buffer| (number.next().unwrap_or_default(), buffer))
}

/// A storage buffer with room for `bytes`, zeros at first.
pub(super) fn storage(gpu: &Gpu, label: &'static str, bytes: usize) -> Buffer {
    gpu.device.create_buffer(&BufferDescriptor {
        label: Some(label),
        // Binding size of no buffer may be zero.
        size: bytes.max(size_of::<[f32; 4]>()) as u64,
        usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// A storage buffer of one vector (xyz and an unused number) for each of `count` vertices.
pub(super) fn vectors(gpu: &Gpu, label: &'static str, count: usize) -> Buffer {
    storage(gpu, label, count * size_of::<[f32; 4]>())
}

/// A storage buffer that holds `items`.
pub(super) fn storage_of<T: bytemuck::NoUninit>(gpu: &Gpu, label: &'static str, items: &[T]) -> Buffer {
    filled_buffer(&gpu.device, &gpu.queue, label, bytemuck::cast_slice(items), BufferUsages::STORAGE)
}

/// A uniform buffer that holds `item`.
pub(super) fn uniform_of<T: bytemuck::NoUninit>(gpu: &Gpu, label: &'static str, item: &T) -> Buffer {
    filled_buffer(&gpu.device, &gpu.queue, label, bytemuck::bytes_of(item), BufferUsages::UNIFORM)
}
