//! The mean look of an avatar over a motion, on few triangles: its base at rest, and its wrinkles as a normal map.

use crate::compact::refine_between;
use crate::normals::unit_normals;
use crate::texture::{ColouredPoint, TextureAccumulator};
use anyhow::Context;
use crease::animate::{Animator, Options, PosedSurface};
use crease::avatar::Appearance;
use crease::body::{Pose, TextureCoordinates};
use crease::mesh::{Scheme, Subdivision};
use crease::network::{Domain, Scratch};
use crease::render::DrawnSurface;
use glam::Vec3A;

/// Frames whose mean is taken, spread over the motion.
const FRAME_COUNT: usize = 24;
/// Texels of the normal map for each of the finest vertices.
const TEXELS: usize = 8;
/// Where in each of the finest triangles the map is sampled.
const SAMPLES: [[f32; 3]; 4] = [[1.0 / 3.0; 3], [0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]];

/// A figure at rest. Lists have one entry a drawn vertex of level 0.
pub struct BakedFigure {
    /// Metres.
    pub positions: Vec<Vec3A>,
    /// Unit vectors.
    pub normals: Vec<Vec3A>,
    /// Unit tangents and the sign of the bitangent, as glTF has them; empty without a texture.
    pub tangents: Vec<[f32; 4]>,
    /// The normal map in the tangents' frame, as PNG; none without a texture.
    pub normal_map: Option<Vec<u8>>,
}

/// Bakes the mean of `poses`, of which there is at least one, as lively as [`Options::liveliness`] says.
///
/// Vertices lie on the subdivided base, which sixteen times as many triangles draw; the map has what lies between them and the detailed mesh.
pub fn bake(animator: &mut Animator, poses: &[Pose], liveliness: f32) -> anyhow::Result<BakedFigure> {
    let avatar = animator.shared_avatar();
    let step = poses.len().div_ceil(FRAME_COUNT).max(1);
    let chosen: Vec<&Pose> = poses.iter().step_by(step).collect();
    let share = 1.0 / chosen.len() as f32;
    let (rig, level) = (&avatar.rig, animator.subdivision().level_count());
    let domain = Domain::coarsest(&avatar.canonical, &rig.skin);
    let mut offsets = vec![Vec3A::ZERO; rig.rest.len()];
    let mut own = offsets.clone();
    let mut displacement = vec![Vec3A::ZERO; animator.subdivision().vertex_count(level)];
    let mut body = PosedSurface::new(animator.subdivision());
    for pose in chosen {
        avatar.deformation.evaluate_lively(&domain, pose, liveliness, &mut Scratch::default(), &mut own);
        offsets.iter_mut().zip(&own).for_each(|(mean, own)| *mean += *own * share);
        let detailed = animator.animate(pose, &Options { liveliness, ..Options::default() }).to_vec();
        let base = animator.surface().finest();
        body.pose(rig, &[], pose, animator.subdivision(), avatar.scheme, 0);
        let rotations = body.rotations(animator.subdivision(), level);
        for (vertex, mean) in displacement.iter_mut().enumerate() {
            *mean += rotations[vertex].inverse() * (detailed[vertex] - base[vertex]) * share;
        }
    }
    let rest = Pose::rest(rig.parents.len());
    body.pose(rig, &offsets, &rest, animator.subdivision(), avatar.scheme, level);
    let base = body.finest();
    let detailed: Vec<Vec3A> = base.iter().zip(&displacement).map(|(&base, &off)| base + off).collect();
    let fine_normals = unit_normals(&detailed, animator.triangles());

    let coarse = &base[..rig.rest.len()];
    let coarse_normals = unit_normals(coarse, &avatar.triangles);
    let appearance = &avatar.appearance;
    let drawn = |values: &[Vec3A]| -> Vec<Vec3A> {
        appearance.drawn_vertices.iter().map(|&vertex| values[vertex as usize]).collect()
    };
    let (positions, normals) = (drawn(coarse), drawn(&coarse_normals));
    let normals: Vec<Vec3A> = normals.iter().map(|normal| normal.normalize_or(Vec3A::Y)).collect();
    if appearance.texture_coordinates.is_empty() {
        return Ok(BakedFigure { positions, normals, tangents: Vec::new(), normal_map: None });
    }
    let (tangents, signs) = tangents(appearance, &positions, &normals);
    let surface = DrawnSurface::new(appearance, animator.triangles(), &avatar.name)?;
    let map = normal_map(&surface, appearance, [&normals, &tangents], &signs, &fine_normals)?;
    let tangents = tangents.iter().zip(&signs).map(|(t, sign)| [t.x, t.y, t.z, *sign]).collect();
    Ok(BakedFigure { positions, normals, tangents, normal_map: Some(map) })
}

/// Directions in which u grows, across the normals, and the sign of normal × tangent against the direction in which v, as it counts from below,
/// grows.
fn tangents(appearance: &Appearance, positions: &[Vec3A], normals: &[Vec3A]) -> (Vec<Vec3A>, Vec<f32>) {
    let count = positions.len();
    let (mut along_u, mut along_v) = (vec![Vec3A::ZERO; count], vec![Vec3A::ZERO; count]);
    for &triangle in &appearance.drawn_triangles {
        let [a, b, c] = triangle.map(|vertex| vertex as usize);
        let (first, second) = (positions[b] - positions[a], positions[c] - positions[a]);
        let uv = |vertex: usize| glam::Vec2::from(appearance.texture_coordinates[vertex]);
        let (s, t) = (uv(b) - uv(a), uv(c) - uv(a));
        let area = s.x * t.y - s.y * t.x;
        if area.abs() < 1e-12 {
            continue;
        }
        let u = (first * t.y - second * s.y) / area;
        // glTF's v counts from above.
        let v = (first * s.x - second * t.x) / area;
        for vertex in [a, b, c] {
            along_u[vertex] += u.normalize_or_zero();
            along_v[vertex] += v.normalize_or_zero();
        }
    }
    (0..count)
        .map(|vertex| {
            let normal = normals[vertex];
            let across = along_u[vertex].reject_from_normalized(normal).try_normalize();
            let tangent = across.unwrap_or_else(|| normal.any_orthonormal_vector());
            let sign = if normal.cross(tangent).dot(along_v[vertex]) > 0.0 { -1.0 } else { 1.0 };
            (tangent, sign)
        })
        .unzip()
}

/// The detailed normals in the frames of level 0, as a viewer interpolates them.
fn normal_map(
    surface: &DrawnSurface,
    appearance: &Appearance,
    frames: [&[Vec3A]; 2],
    signs: &[f32],
    fine_normals: &[Vec3A],
) -> anyhow::Result<Vec<u8>> {
    let level_count = surface.levels.len() - 1;
    let subdivision = Subdivision::new(appearance.drawn_vertices.len(), &appearance.drawn_triangles, level_count);
    let refined = |values: &[Vec3A]| refine_between(&subdivision, Scheme::Midpoint, 0..level_count, values);
    let signs: Vec<Vec3A> = signs.iter().map(|&sign| Vec3A::splat(sign)).collect();
    let [normals, tangents, signs] = [frames[0], frames[1], &signs].map(refined);
    let seen: Vec<Vec3A> = (surface.vertices.iter().enumerate())
        .map(|(vertex, drawn)| {
            let (normal, tangent) = (normals[vertex].normalize_or(Vec3A::Y), tangents[vertex].normalize_or(Vec3A::X));
            let bitangent = normal.cross(tangent) * signs[vertex].x.signum();
            let fine = fine_normals[drawn.body_vertex as usize];
            Vec3A::new(fine.dot(tangent), fine.dot(bitangent), fine.dot(normal)).normalize_or(Vec3A::Z)
        })
        .collect();
    let coordinates = TextureCoordinates {
        coordinates: surface
            .vertices
            .iter()
            .map(|v| [v.texture_coordinates[0], 1.0 - v.texture_coordinates[1]])
            .collect(),
        triangles: surface.levels[level_count].clone(),
    };
    let points: Vec<ColouredPoint> = (coordinates.triangles.iter().enumerate())
        .flat_map(|(triangle, corners)| {
            let [a, b, c] = corners.map(|vertex| seen[vertex as usize]);
            SAMPLES.map(|barycentrics| {
                let normal = (a * barycentrics[0] + b * barycentrics[1] + c * barycentrics[2]).normalize_or(Vec3A::Z);
                let colour = ((normal * 0.5 + 0.5) * 255.0).to_array().map(|channel| channel.round() as u8);
                ColouredPoint { triangle: triangle as u32, barycentrics, colour, weight: 1.0 }
            })
        })
        .collect();
    let size = (TEXELS * surface.vertices.len()).isqrt().next_power_of_two();
    let mut map = TextureAccumulator::new(size);
    map.splat(&coordinates, &points);
    let image = image::RgbImage::from_raw(size as u32, size as u32, map.finish()).context("the normal map")?;
    let mut png = std::io::Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png)?;
    Ok(png.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::fixture::{bent_pose, compact_avatar, plain_avatar};
    use glam::Quat;
    use std::sync::Arc;

    #[test]
    fn base_and_wrinkles_are_as_lively_as_is_asked_for() {
        let mut avatar = compact_avatar();
        avatar.appearance = plain_avatar().appearance;
        let mut animator = Animator::new(Arc::new(avatar)).unwrap();
        // Far from the poses that the tables have.
        let mut pose = bent_pose();
        pose.rotations.iter_mut().for_each(|rotation| *rotation *= Quat::from_rotation_z(2.0));
        let mut baked = |liveliness: f32| {
            let figure = bake(&mut animator, std::slice::from_ref(&pose), liveliness).unwrap();
            let avatar = animator.shared_avatar();
            let mut offsets = vec![Vec3A::ZERO; avatar.rig.rest.len()];
            let domain = Domain::coarsest(&avatar.canonical, &avatar.rig.skin);
            avatar.deformation.evaluate_lively(&domain, &pose, liveliness, &mut Scratch::default(), &mut offsets);
            let mut rest = PosedSurface::new(animator.subdivision());
            let still = Pose::rest(avatar.rig.parents.len());
            rest.pose(&avatar.rig, &offsets, &still, animator.subdivision(), avatar.scheme, 2);
            for (&position, &vertex) in figure.positions.iter().zip(&avatar.appearance.drawn_vertices) {
                assert!(position.distance(rest.finest()[vertex as usize]) < 1e-6, "the base of that liveliness");
            }
            figure
        };
        let (calm, lively) = (baked(0.0), baked(1.0));
        let apart = calm.positions.iter().zip(&lively.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(apart > 1e-3, "{apart} m");
        assert_ne!(calm.normal_map, lively.normal_map);
    }
}
