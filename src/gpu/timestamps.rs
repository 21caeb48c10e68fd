//! How long each stage of a frame takes on the GPU, by its own clock.

use super::animator::STAGES;
use wgpu::*;

/// A stage and the time it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageTime {
    /// Name of the stage.
    pub stage: &'static str,
    /// Milliseconds on the GPU.
    pub milliseconds: f64,
}

/// Queries for the stages of one frame at a time. Needs a device with [`Features::TIMESTAMP_QUERY`].
pub struct Timestamps {
    queries: QuerySet,
    resolved: Buffer,
    readable: Buffer,
    /// Nanoseconds of a tick.
    period: f32,
    /// Stages of the last frame, in order.
    stages: Vec<&'static str>,
}

const QUERY_COUNT: usize = 2 * STAGES.len();

impl Timestamps {
    /// `None` where `device` has no timestamps.
    pub fn new(device: &Device, queue: &Queue) -> Option<Self> {
        if !device.features().contains(Features::TIMESTAMP_QUERY) {
            return None;
        }
        let buffer = |usage| {
            device.create_buffer(&BufferDescriptor {
                label: Some("timestamps"),
                size: (QUERY_COUNT * size_of::<u64>()) as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        Some(Self {
            queries: device.create_query_set(&QuerySetDescriptor {
                label: Some("timestamps"),
                ty: QueryType::Timestamp,
                count: QUERY_COUNT as u32,
            }),
            resolved: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            readable: buffer(BufferUsages::COPY_DST | BufferUsages::MAP_READ),
            period: queue.get_timestamp_period(),
            stages: Vec::new(),
        })
    }

    pub(super) fn start(&mut self) {
        self.stages.clear();
    }

    /// Queries around the next stage.
    pub(super) fn stage(&mut self, name: &'static str) -> ComputePassTimestampWrites<'_> {
        let first = 2 * self.stages.len() as u32;
        self.stages.push(name);
        ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    pub(super) fn finish(&self, encoder: &mut CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..2 * self.stages.len() as u32, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readable, 0, self.readable.size());
    }

    /// Gives the times of the last frame to `receive` once the GPU is done with it, and an empty list where the device was lost. The
    /// frame must have been submitted, and no other may be timed before.
    pub fn read(&self, receive: impl FnOnce(Vec<StageTime>) + Send + 'static) {
        let (readable, stages, period) = (self.readable.clone(), self.stages.clone(), f64::from(self.period));
        self.readable.slice(..).map_async(MapMode::Read, move |mapped| {
            let mut times = Vec::new();
            if mapped.is_ok()
                && let Ok(view) = readable.slice(..).get_mapped_range()
            {
                let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&view);
                times.extend(stages.iter().zip(ticks.chunks_exact(2)).map(|(&stage, ticks)| StageTime {
                    stage,
                    milliseconds: 1e-6 * period * ticks[1].saturating_sub(ticks[0]) as f64,
                }));
                drop(view);
                readable.unmap();
            }
            receive(times);
        });
    }
}
