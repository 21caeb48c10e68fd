//! Turning δ from the rest pose's frame into the posed one.

use super::kernel::{Dispatch, Gpu, Shader, storage_of};
use super::sparse::stencils;
use crate::body::Skin;
use crate::mesh::{Scheme, SparseMatrix, Subdivision};
use crate::wgsl::wgsl;
use wgpu::Buffer;

/// WGSL of the pass.
pub(super) const SOURCE: &str = wgsl!(include_str!("frame.wgsl"), include_str!("rotation.wgsl"));

/// Turns `vectors`, one for each vertex of `level`, in place.
pub(super) fn rotate(
    gpu: &Gpu,
    skin: &Skin,
    subdivision: &Subdivision,
    level: usize,
    frame: &Buffer,
    vectors: &Buffer,
) -> Dispatch {
    let influences = influences(skin, subdivision, level);
    Shader::new(gpu, "rotation", SOURCE).kernel("rotate").over(
        subdivision.vertex_count(level),
        &[
            (0, frame),
            (1, &storage_of(gpu, "rotation: offsets", &influences.offsets)),
            (2, &storage_of(gpu, "rotation: influences", &influences.entries)),
            (3, vectors),
        ],
    )
}

/// Skinning weights of the vertices of `level`, vertices × joints: those of a new vertex are the mean of its edge's ends.
fn influences(skin: &Skin, subdivision: &Subdivision, level: usize) -> SparseMatrix {
    const JOINT_COUNT: usize = 1 << u8::BITS;
    let mut weights = SparseMatrix::with_capacity(skin.joints.len(), 4 * skin.joints.len(), JOINT_COUNT);
    let mut row: Vec<(u32, f32)> = Vec::new();
    for (joints, values) in skin.joints.iter().zip(&skin.weights) {
        row.clear();
        for (&joint, &value) in joints.iter().zip(values).filter(|&(_, &value)| value != 0.0) {
            match row.iter_mut().find(|(other, _)| *other == u32::from(joint)) {
                Some((_, sum)) => *sum += value,
                None => row.push((u32::from(joint), value)),
            }
        }
        weights.push_row(&mut row);
    }
    (0..level).fold(weights, |weights, level| stencils(subdivision, Scheme::Midpoint, level).times(&weights))
}
