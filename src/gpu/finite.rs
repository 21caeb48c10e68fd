//! How many vertices of a frame were nowhere: counted on the GPU, told some frames later, so that nothing waits for it.

use super::kernel::{Gpu, storage};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, MapMode};

/// A counter on the GPU and its way back.
pub(super) struct FiniteCheck {
    count: Buffer,
    readable: Buffer,
    /// The frame that is being recorded hands its count over.
    copied: bool,
    /// A count is on its way.
    reading: Arc<AtomicBool>,
    /// What has come back and was not asked for yet.
    found: Arc<AtomicU32>,
}

impl FiniteCheck {
    pub fn new(gpu: &Gpu) -> Self {
        let count = storage(gpu, "finite check: count", size_of::<u32>());
        let readable = gpu.device.create_buffer(&BufferDescriptor {
            label: Some("finite check: readable"),
            size: count.size(),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self { count, readable, copied: false, reading: Arc::default(), found: Arc::default() }
    }

    /// Where the last pass counts.
    pub fn count(&self) -> &Buffer {
        &self.count
    }

    /// Ends a frame. Counts add up until one is read.
    pub fn record(&mut self, encoder: &mut CommandEncoder) {
        self.copied = !self.reading.load(Ordering::Relaxed);
        if self.copied {
            encoder.copy_buffer_to_buffer(&self.count, 0, &self.readable, 0, self.count.size());
            encoder.clear_buffer(&self.count, 0, None);
        }
    }

    /// The frame was submitted.
    pub fn read(&self) {
        if !self.copied {
            return;
        }
        self.reading.store(true, Ordering::Relaxed);
        let (readable, reading, found) = (self.readable.clone(), self.reading.clone(), self.found.clone());
        self.readable.slice(..).map_async(MapMode::Read, move |mapped| {
            // A lost device is told elsewhere.
            if mapped.is_ok()
                && let Ok(view) = readable.slice(..).get_mapped_range()
            {
                let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&view);
                found.fetch_add(counts[0], Ordering::Relaxed);
                drop(view);
                readable.unmap();
                reading.store(false, Ordering::Relaxed);
            }
        });
    }

    /// What was counted since the last call, as far as it has come back.
    pub fn take(&self) -> usize {
        self.found.swap(0, Ordering::Relaxed) as usize
    }
}
