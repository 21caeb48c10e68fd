//! Buffers on a GPU that hold something from the start.

use wgpu::{BufferDescriptor, BufferUsages, COPY_BUFFER_ALIGNMENT, Device, Queue};

/// Binding size of no buffer may be zero.
const SMALLEST_BUFFER: u64 = 16;

/// A buffer that holds `contents`, zeros beyond them.
///
/// It is written through the queue and not mapped: a browser throws where it cannot map a buffer, and no error of the device tells of it. What
/// the device has no memory for is the device's error.
pub(crate) fn filled_buffer(
    device: &Device,
    queue: &Queue,
    label: &'static str,
    contents: &[u8],
    usage: BufferUsages,
) -> wgpu::Buffer {
    let size = (contents.len() as u64).next_multiple_of(COPY_BUFFER_ALIGNMENT).max(SMALLEST_BUFFER);
    let usage = usage | BufferUsages::COPY_DST;
    let buffer = device.create_buffer(&BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false });
    let (words, rest) = contents.as_chunks::<{ COPY_BUFFER_ALIGNMENT as usize }>();
    if !words.is_empty() {
        queue.write_buffer(&buffer, 0, words.as_flattened());
    }
    if !rest.is_empty() {
        let mut word = [0; COPY_BUFFER_ALIGNMENT as usize];
        word[..rest.len()].copy_from_slice(rest);
        queue.write_buffer(&buffer, size_of_val(words) as u64, &word);
    }
    buffer
}
