//! Every pass against its twin on the CPU, and whole frames against `animate`, on whatever adapter there is.

mod frames;
mod passes;
mod shaders;
mod solver_passes;

use super::GpuAnimator;
use super::kernel::{Dispatch, Gpu, storage, vectors};
use glam::Vec3A;
use std::sync::OnceLock;
use wgpu::*;

/// The machine's GPU, or else a software one, for all tests of this process. Never skipped: without an adapter the test fails and says what to do.
pub(super) fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| {
        let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&RequestAdapterOptions::default())).expect(
            "no adapter: run `cargo xtask test`, which uses the software one that comes with Chromium, or set VK_ICD_FILENAMES to its \
             vk_swiftshader_icd.json and LD_LIBRARY_PATH to its folder",
        );
        let descriptor = DeviceDescriptor {
            required_features: adapter.features() & GpuAnimator::features(),
            required_limits: Limits::default(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("WebGPU's default limits");
        Gpu { device, queue }
    })
}

impl Gpu {
    /// A storage buffer of vectors.
    pub fn vectors(&self, values: &[Vec3A]) -> Buffer {
        let buffer = vectors(self, "vectors", values.len());
        self.write(&buffer, values);
        buffer
    }

    /// Puts vectors into a buffer.
    pub fn write(&self, buffer: &Buffer, values: &[Vec3A]) {
        let padded: Vec<[f32; 4]> = values.iter().map(|value| value.extend(0.0).to_array()).collect();
        self.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&padded));
    }

    /// A storage buffer for `count` vectors, which begins with numbers that no pass may leave there.
    pub fn empty(&self, count: usize) -> Buffer {
        self.vectors(&vec![Vec3A::splat(1e9); count])
    }

    /// Runs `dispatches` and returns the vectors in `buffer`.
    pub fn run<'a>(&self, dispatches: impl IntoIterator<Item = &'a Dispatch>, buffer: &Buffer) -> Vec<Vec3A> {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            dispatches.into_iter().for_each(|dispatch| dispatch.record(&mut pass));
        }
        self.queue.submit([encoder.finish()]);
        self.read::<[f32; 4]>(buffer).iter().map(|v| Vec3A::new(v[0], v[1], v[2])).collect()
    }

    /// What `buffer` holds.
    pub fn read<T: bytemuck::Pod>(&self, buffer: &Buffer) -> Vec<T> {
        let readable = self.device.create_buffer(&BufferDescriptor {
            label: None,
            size: buffer.size(),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &readable, 0, buffer.size());
        self.queue.submit([encoder.finish()]);
        readable.slice(..).map_async(MapMode::Read, |mapped| mapped.expect("a buffer to read"));
        self.device.poll(PollType::wait_indefinitely()).expect("the device finishes");
        let view = readable.slice(..).get_mapped_range().expect("a mapped buffer");
        bytemuck::pod_collect_to_vec(&view)
    }

    /// A buffer for drawn vertices.
    pub fn vertices(&self, count: usize) -> Buffer {
        storage(self, "vertices", 16 * count)
    }
}

/// The largest distance between two lists of vectors; not a number where one is not.
pub(super) fn largest_distance(a: &[Vec3A], b: &[Vec3A]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .zip(b)
        .map(|(a, b)| a.distance(*b))
        .fold(0.0, |largest, distance| if distance.is_nan() || largest < distance { distance } else { largest })
}

/// The length of the longest vector.
pub(super) fn size(values: &[Vec3A]) -> f32 {
    values.iter().map(|value| value.length()).fold(0.0, f32::max)
}
