//! What every pass of the picture shares: camera, lights, maps, colours.

use super::camera::OrbitCamera;
use super::light::{self, Bounds, KEY_DIRECTION, KEY_MAP};
use glam::{Mat4, Vec3};

/// Colours around the figure. Linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Theme {
    /// Backdrop at the bottom of the picture.
    pub backdrop_low: Vec3,
    /// Backdrop at the top.
    pub backdrop_high: Vec3,
    /// The lit floor.
    pub floor: Vec3,
    /// How dark the floor gets in shadow, 0 ..= 1.
    pub shadow_strength: f32,
}

impl Theme {
    /// A pale studio.
    pub const LIGHT: Self = Self {
        backdrop_low: Vec3::new(0.74, 0.75, 0.77),
        backdrop_high: Vec3::new(0.87, 0.89, 0.92),
        floor: Vec3::new(0.84, 0.845, 0.855),
        shadow_strength: 0.6,
    };
    /// A dim one.
    pub const DARK: Self = Self {
        backdrop_low: Vec3::new(0.020, 0.021, 0.025),
        backdrop_high: Vec3::new(0.009, 0.010, 0.013),
        floor: Vec3::new(0.046, 0.048, 0.054),
        shadow_strength: 0.8,
    };
}

/// Host twin of `Globals` in globals.wgsl, byte for byte.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Globals {
    pub(super) clip_from_world: Mat4,
    pub(super) key_from_world: Mat4,
    pub(super) below_from_world: Mat4,
    pub(super) eye: Vec3,
    pub(super) key_texel: f32,
    pub(super) key_direction: Vec3,
    pub(super) key_depth: f32,
    pub(super) key_colour: Vec3,
    pub(super) below_width: f32,
    pub(super) sky_colour: Vec3,
    pub(super) floor_radius: f32,
    pub(super) bounce_colour: Vec3,
    pub(super) shadow_strength: f32,
    pub(super) rim_colour: Vec3,
    pub(super) floor_x: f32,
    pub(super) floor_colour: Vec3,
    pub(super) floor_z: f32,
    pub(super) backdrop_low: Vec3,
    pub(super) padding_0: f32,
    pub(super) backdrop_high: Vec3,
    pub(super) padding_1: f32,
}

impl Globals {
    /// Byte offset of the key light's matrix: the one with which its map is drawn.
    pub const KEY_MATRIX_OFFSET: usize = std::mem::offset_of!(Self, key_from_world);
    /// Byte offset of the matrix of the map from beneath.
    pub const BELOW_MATRIX_OFFSET: usize = std::mem::offset_of!(Self, below_from_world);

    /// For a figure within `bounds`, seen by `camera` in a picture of `aspect` = width / height.
    pub(super) fn new(camera: &OrbitCamera, aspect: f32, bounds: Bounds, theme: &Theme) -> Self {
        let key_from_world = light::key_from_world(bounds);
        let below_from_world = light::below_from_world(bounds);
        Self {
            clip_from_world: camera.clip_from_world(aspect),
            key_from_world,
            below_from_world,
            eye: camera.eye(aspect),
            key_texel: light::texel_metres(key_from_world, KEY_MAP.texels),
            key_direction: KEY_DIRECTION.normalize(),
            key_depth: 4.0 * bounds.radius(),
            key_colour: 2.3 * Vec3::new(1.0, 0.965, 0.91),
            below_width: light::texel_metres(below_from_world, 1),
            sky_colour: 0.80 * Vec3::new(0.86, 0.94, 1.08),
            floor_radius: 5.0,
            bounce_colour: 0.52 * Vec3::new(1.0, 0.95, 0.9),
            shadow_strength: theme.shadow_strength,
            rim_colour: 0.55 * Vec3::new(0.95, 0.98, 1.05),
            floor_x: camera.target().x,
            floor_colour: theme.floor,
            floor_z: camera.target().z,
            backdrop_low: theme.backdrop_low,
            padding_0: 0.0,
            backdrop_high: theme.backdrop_high,
            padding_1: 0.0,
        }
    }
}
