//! What every pass of the picture shares: camera, lights, maps, colours.

use super::camera::OrbitCamera;
use super::environment::Environment;
use super::light::{self, Bounds, KEY_MAP};
use super::view::View;
use crate::colour::linear_from_srgb;
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
    /// Opacity of the backdrop, 0 ..= 1; the shadow stays where it is less.
    pub opacity: f32,
    /// How dark the floor gets in shadow, 0 ..= 1.
    pub shadow_strength: f32,
}

impl Theme {
    /// A pale studio.
    pub const LIGHT: Self = Self {
        backdrop_low: Vec3::new(0.74, 0.75, 0.77),
        backdrop_high: Vec3::new(0.87, 0.89, 0.92),
        floor: Vec3::new(0.84, 0.845, 0.855),
        opacity: 1.0,
        shadow_strength: 0.6,
    };
    /// A dim one.
    pub const DARK: Self = Self {
        backdrop_low: Vec3::new(0.020, 0.021, 0.025),
        backdrop_high: Vec3::new(0.009, 0.010, 0.013),
        floor: Vec3::new(0.046, 0.048, 0.054),
        opacity: 1.0,
        shadow_strength: 0.8,
    };

    /// This theme with one sRGB colour (red, green, blue, opacity, 0 ..= 1) behind the figure and on the floor.
    pub fn with_background(self, [red, green, blue, opacity]: [f32; 4]) -> Self {
        let colour = Vec3::new(red, green, blue).map(linear_from_srgb);
        Self { backdrop_low: colour, backdrop_high: colour, floor: colour, opacity, ..self }
    }
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
    pub(super) backdrop_opacity: f32,
    pub(super) backdrop_high: Vec3,
    pub(super) view: u32,
}

impl Globals {
    /// Byte offset of the key light's matrix: the one with which its map is drawn.
    pub const KEY_MATRIX_OFFSET: usize = std::mem::offset_of!(Self, key_from_world);
    /// Byte offset of the matrix of the map from beneath.
    pub const BELOW_MATRIX_OFFSET: usize = std::mem::offset_of!(Self, below_from_world);

    /// For a figure within `bounds`, seen by `camera` in a picture of `aspect` = width / height.
    pub(super) fn new(
        camera: &OrbitCamera,
        aspect: f32,
        bounds: Bounds,
        theme: &Theme,
        environment: &Environment,
        view: View,
    ) -> Self {
        let key_from_world = light::key_from_world(bounds, environment.key_direction);
        let below_from_world = light::below_from_world(bounds);
        Self {
            clip_from_world: camera.clip_from_world(aspect),
            key_from_world,
            below_from_world,
            eye: camera.eye(aspect),
            key_texel: light::texel_metres(key_from_world, KEY_MAP.texels),
            key_direction: environment.key_direction,
            key_depth: 4.0 * bounds.radius(),
            key_colour: environment.key_colour,
            below_width: light::texel_metres(below_from_world, 1),
            sky_colour: environment.sky_colour,
            floor_radius: 5.0,
            bounce_colour: environment.bounce_colour,
            shadow_strength: theme.shadow_strength,
            rim_colour: environment.rim_colour,
            floor_x: camera.target().x,
            floor_colour: theme.floor,
            floor_z: camera.target().z,
            backdrop_low: theme.backdrop_low,
            backdrop_opacity: theme.opacity,
            backdrop_high: theme.backdrop_high,
            view: view as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_background_is_srgb_and_keeps_the_theme_s_shadow() {
        let theme = Theme::DARK.with_background([1.0, 0.5, 0.0, 0.25]);
        assert!(theme.floor.distance(Vec3::new(1.0, 0.214_041, 0.0)) < 1e-4, "{}", theme.floor);
        assert_eq!((theme.opacity, theme.shadow_strength), (0.25, Theme::DARK.shadow_strength));
        assert_eq!(theme.backdrop_low, theme.backdrop_high);
    }
}
