//! One vertex of the figure as the GPU sees it each frame: position and packed normal, 16 bytes.

use crate::threads::for_rows;
use bytemuck::Zeroable;
use glam::{Vec2, Vec3, Vec3A};

/// Host twin of the `vec4u` that `figure_vertex` gives in the shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SurfaceVertex {
    /// Metres.
    pub position: [f32; 3],
    /// Unit normal: octahedral, two signed 16-bit numbers; or the bits of a number.
    pub normal: u32,
}

impl SurfaceVertex {
    /// Packs a position (metres) and a unit normal.
    pub fn new(position: Vec3A, normal: Vec3A) -> Self {
        Self { position: position.to_array(), normal: pack_octahedral(normal.into()) }
    }

    /// A position (metres) and a number in place of the normal.
    pub fn of_value(position: Vec3A, value: f32) -> Self {
        Self { position: position.to_array(), normal: value.to_bits() }
    }
}

/// Packs `positions` (metres) and as many unit `normals`, one each for every vertex, in place of what `vertices` had.
pub fn pack_surface(positions: &[Vec3A], normals: &[Vec3A], vertices: &mut Vec<SurfaceVertex>) {
    vertices.resize(positions.len(), SurfaceVertex::zeroed());
    for_rows(vertices, |first, vertices| {
        for ((vertex, &position), &normal) in vertices.iter_mut().zip(&positions[first..]).zip(&normals[first..]) {
            *vertex = SurfaceVertex::new(position, normal);
        }
    });
}

/// Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors", oct32.
fn pack_octahedral(normal: Vec3) -> u32 {
    let length = normal.abs().element_sum();
    if length.is_nan() || length <= 0.0 {
        return 0;
    }
    let projected = normal / length;
    let mut octahedral = Vec2::new(projected.x, projected.y);
    if projected.z < 0.0 {
        let folded = Vec2::ONE - Vec2::new(octahedral.y, octahedral.x).abs();
        octahedral = Vec2::new(folded.x.copysign(octahedral.x), folded.y.copysign(octahedral.y));
    }
    // The instruction that processors have; rounding half away from zero is a call in wasm.
    let quantised = |x: f32| (x.clamp(-1.0, 1.0) * 32767.0).round_ties_even() as i16 as u16;
    u32::from(quantised(octahedral.x)) | u32::from(quantised(octahedral.y)) << 16
}

/// The unit normal that is packed so: what `unpack_normal` in surface_vertex.wgsl does, for tests.
#[cfg(any(test, feature = "fixture"))]
pub fn unpack_normal(packed: u32) -> Vec3 {
    let number = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let (x, y) = (number(packed), number(packed >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_normals_come_back_within_a_hundredth_of_a_degree() {
        for i in 0..500 {
            let (z, angle) = (1.0 - 2.0 * i as f32 / 499.0, 2.4 * i as f32);
            let ring = (1.0 - z * z).max(0.0).sqrt();
            let normal = Vec3::new(ring * angle.cos(), ring * angle.sin(), z);
            let error = unpack_normal(pack_octahedral(normal)).distance(normal);
            assert!(error < 1.7e-4, "{normal}: {error}");
        }
    }

    #[test]
    fn a_vertex_without_a_normal_packs_to_zero() {
        assert_eq!(pack_octahedral(Vec3::ZERO), 0);
        assert_eq!(pack_octahedral(Vec3::NAN), 0);
    }
}
