//! Anchors by Poisson-disk sample elimination (Yuksel 2015).

use glam::Vec3A;

/// Chooses `count` of `positions`, spread evenly over a surface of `area` m²; ascending indices. All of them if there are no more.
pub fn sample_elimination(positions: &[Vec3A], area: f32, count: usize) -> Vec<u32> {
    let _ = (positions, area, count);
    todo!()
}
