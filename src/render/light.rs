//! The key light and what it must cover.

use glam::{Mat4, Vec3, Vec3A};

/// Up to this height above the floor, metres, the figure darkens the floor beneath it.
pub(super) const CONTACT_HEIGHT: f32 = 0.35;

/// How finely a light sees the figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapSize {
    /// Texels a side.
    pub texels: u32,
    /// Levels by which the figure may be coarser here than in the picture's finest form.
    pub coarser: usize,
}

/// The key light's shadow map.
pub const KEY_MAP: MapSize = MapSize { texels: 2048, coarser: 1 };
/// The map from beneath the floor.
pub const BELOW_MAP: MapSize = MapSize { texels: 256, coarser: 2 };

/// A box around the figure, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub low: Vec3,
    pub high: Vec3,
}

impl Bounds {
    /// Around `positions`; around the origin where there are none. Positions that are not finite are skipped.
    pub fn of(positions: &[Vec3A]) -> Self {
        let mut low = Vec3A::INFINITY;
        let mut high = Vec3A::NEG_INFINITY;
        for &position in positions.iter().filter(|position| position.is_finite()) {
            low = low.min(position);
            high = high.max(position);
        }
        if low.cmpgt(high).any() {
            return Self { low: Vec3::ZERO, high: Vec3::ZERO };
        }
        Self { low: low.into(), high: high.into() }
    }

    pub fn centre(self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    /// Radius of the sphere around the box, at least a centimetre.
    pub fn radius(self) -> f32 {
        (0.5 * (self.high - self.low)).length().max(0.01)
    }
}

/// Clip space of the key light's shadow map from world; the light is in `direction`, a unit vector. The map holds the figure; the depth goes on beyond it to the floor.
pub(super) fn key_from_world(bounds: Bounds, direction: Vec3) -> Mat4 {
    let (centre, radius) = (bounds.centre(), bounds.radius());
    let view = glam::camera::rh::view::look_at_mat4(centre + radius * direction, centre, Vec3::Y);
    glam::camera::rh::proj::directx::orthographic(-radius, radius, -radius, radius, 0.0, 4.0 * radius) * view
}

/// Clip space of the map that sees the figure from beneath the floor, from world: x and y are the figure's x and z, depth its height as a
/// share of [`CONTACT_HEIGHT`]. A wide rim keeps the darkening inside the map.
pub(super) fn below_from_world(bounds: Bounds) -> Mat4 {
    let centre = bounds.centre();
    let half = 0.5 * (bounds.high - bounds.low) + CONTACT_HEIGHT;
    let half = half.x.max(half.z);
    Mat4::from_cols_array_2d(&[
        [1.0 / half, 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0 / CONTACT_HEIGHT, 0.0],
        [0.0, 1.0 / half, 0.0, 0.0],
        [-centre.x / half, -centre.z / half, 0.0, 1.0],
    ])
}

/// Metres across one of the map's `size` texels, for a map of orthographic `clip_from_world`.
pub(super) fn texel_metres(clip_from_world: Mat4, size: u32) -> f32 {
    2.0 / (clip_from_world.row(0).truncate().length() * size as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Environment;

    const KEY_DIRECTION: Vec3 = Environment::STUDIO.key_direction;

    const BOUNDS: Bounds = Bounds { low: Vec3::new(0.5, 0.0, -0.2), high: Vec3::new(1.5, 1.8, 0.6) };

    fn corners(bounds: Bounds) -> impl Iterator<Item = Vec3> {
        (0..8).map(move |i| {
            let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { bounds.low[axis] } else { bounds.high[axis] };
            Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
        })
    }

    #[test]
    fn the_key_light_sees_the_whole_figure() {
        for corner in corners(BOUNDS) {
            let seen = key_from_world(BOUNDS, KEY_DIRECTION).project_point3(corner);
            assert!(seen.x.abs() <= 1.0001 && seen.y.abs() <= 1.0001 && (0.0..=1.0).contains(&seen.z), "{seen}");
        }
    }

    #[test]
    fn what_is_nearer_to_the_light_has_less_depth() {
        let matrix = key_from_world(BOUNDS, KEY_DIRECTION);
        let nearer = matrix.project_point3(BOUNDS.centre() + 0.1 * KEY_DIRECTION);
        assert!(nearer.z < matrix.project_point3(BOUNDS.centre()).z);
    }

    #[test]
    fn seen_from_beneath_depth_is_height() {
        let matrix = below_from_world(BOUNDS);
        let foot = matrix.project_point3(Vec3::new(0.6, 0.1, 0.5));
        assert!((foot.z - 0.1 / CONTACT_HEIGHT).abs() < 1e-6);
        assert!(foot.x.abs() < 1.0 && foot.y.abs() < 1.0);
        assert!(matrix.project_point3(Vec3::new(1.0, 1.0, 0.0)).z > 1.0, "the trunk is out of the map");
    }

    #[test]
    fn texels_measure_the_map() {
        let size = texel_metres(key_from_world(BOUNDS, KEY_DIRECTION), 1000);
        assert!((size - 2.0 * BOUNDS.radius() / 1000.0).abs() < 1e-6);
    }

    #[test]
    fn no_vertices_and_bad_vertices_give_usable_bounds() {
        assert!(key_from_world(Bounds::of(&[]), KEY_DIRECTION).is_finite());
        let bounds = Bounds::of(&[Vec3A::NAN, Vec3A::ONE, Vec3A::ZERO]);
        assert_eq!((bounds.low, bounds.high), (Vec3::ZERO, Vec3::ONE));
    }
}
