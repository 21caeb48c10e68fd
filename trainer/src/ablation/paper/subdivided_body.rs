//! A body with more vertices.

use crate::compact::refine_between;
use crease::body::{Body, Skin};
use crease::mesh::{Scheme, Subdivision};
use glam::Vec3A;

/// `body` with new vertices at its edges' middles, `level_count` times over. A new vertex has the mean of its edge's ends in everything; of the
/// joints that pull at them the four strongest stay. Texture coordinates are left out.
pub fn subdivided(body: &Body, level_count: usize) -> Body {
    let subdivision = Subdivision::new(body.template.len(), &body.triangles, level_count);
    let refined = |field: &[Vec3A]| refine_between(&subdivision, Scheme::Midpoint, 0..level_count, field);
    let all = |fields: &[Vec<Vec3A>]| fields.iter().map(|field| refined(field)).collect();
    let mut skin = body.skin.clone();
    for level in 0..level_count {
        for [a, b] in subdivision.edges(level).iter().map(|edge| edge.map(|end| end as usize)) {
            let (joints, weights) = between(&skin, a, b);
            skin.joints.push(joints);
            skin.weights.push(weights);
        }
    }
    Body {
        template: refined(&body.template),
        shape_directions: all(&body.shape_directions),
        pose_directions: body.pose_directions.as_ref().map(|fields| all(fields)),
        skin,
        triangles: subdivision.triangles(level_count).to_vec(),
        texture_coordinates: None,
        // Old vertices keep their numbers, and joints hang on them alone.
        ..body.clone()
    }
}

/// Joints and weights half-way between two vertices.
fn between(skin: &Skin, a: usize, b: usize) -> ([u8; 4], [f32; 4]) {
    let mut mean: Vec<(u8, f32)> = Vec::new();
    for vertex in [a, b] {
        for (&joint, &weight) in skin.joints[vertex].iter().zip(&skin.weights[vertex]).filter(|pair| *pair.1 > 0.0) {
            match mean.iter_mut().find(|(known, _)| *known == joint) {
                Some((_, sum)) => *sum += 0.5 * weight,
                None => mean.push((joint, 0.5 * weight)),
            }
        }
    }
    mean.sort_by(|a, b| b.1.total_cmp(&a.1));
    mean.truncate(4);
    let total: f32 = mean.iter().map(|(_, weight)| weight).sum();
    let (mut joints, mut weights) = ([0; 4], [0.0; 4]);
    for (i, (joint, weight)) in mean.into_iter().enumerate() {
        (joints[i], weights[i]) = (joint, weight / total);
    }
    (joints, weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::animate::PosedSurface;
    use crease::body::posed_from_rest;
    use crease::fixture::{bent_pose, voxel_person};

    #[test]
    fn a_subdivided_body_moves_as_the_body_does() {
        let body = voxel_person();
        let fine = subdivided(&body, 2);
        assert_eq!(fine.triangles.len(), 16 * body.triangles.len());
        let (coarse_rig, rig) = (body.shaped(&[0.4, -0.3]), fine.shaped(&[0.4, -0.3]));
        assert_eq!(rig.rest_joints, coarse_rig.rest_joints);
        let pose = bent_pose();
        let posed = rig.posed(&pose, &posed_from_rest(&rig, &pose));
        let subdivision = Subdivision::new(body.template.len(), &body.triangles, 2);
        let mut surface = PosedSurface::new(&subdivision);
        surface.pose(&coarse_rig, &[], &pose, &subdivision, Scheme::Midpoint, 2);
        let count = body.template.len();
        let distances: Vec<f32> = posed.iter().zip(surface.finest()).map(|(a, b)| a.distance(*b)).collect();
        assert!(distances[..count].iter().all(|&distance| distance < 1e-5), "old vertices are where they were");
        // A middle that turns by the mean of two rotations is not the middle of what they turn, but near it.
        assert!(distances.iter().all(|&distance| distance < 0.03), "{distances:?}");
        assert!(rig.skin.weights.iter().all(|weights| (weights.iter().sum::<f32>() - 1.0).abs() < 1e-5));
    }
}
