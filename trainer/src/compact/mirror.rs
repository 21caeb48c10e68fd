//! The reflection of poses and surface fields in the body's plane of symmetry, the plane of its root joint across x.

use crate::closest::{ClosestPoint, SurfacePoint};
use anyhow::ensure;
use crease::body::Pose;
use crease::mesh::Triangle;
use glam::{Quat, Vec3A};

/// A body that is further from its own mirror image than this, in metres, has none to learn from.
const GREATEST_ASYMMETRY: f32 = 0.03;

/// The reflection that takes a body to itself.
pub struct Mirror {
    triangles: Vec<Triangle>,
    /// For every vertex the point of the surface that its reflection meets.
    partners: Vec<SurfacePoint>,
    /// For every joint the one on the other side.
    joints: Vec<usize>,
}

impl Mirror {
    /// The reflection of a surface in its T-pose, metres, left towards +x, in the plane x = `plane`. Joints change sides by their names.
    ///
    /// Fails where the surface is not its own mirror image.
    pub fn new(
        positions: &[Vec3A],
        triangles: &[Triangle],
        plane: f32,
        joint_names: &[String],
    ) -> anyhow::Result<Self> {
        let closest = ClosestPoint::new(positions, triangles)?;
        let reflected: Vec<Vec3A> = positions.iter().map(|p| Vec3A::new(2.0 * plane - p.x, p.y, p.z)).collect();
        let partners = closest.query_all(&reflected);
        let gap = |(partner, p): (&SurfacePoint, &Vec3A)| partner.interpolate(triangles, positions).distance(*p);
        let asymmetry = partners.iter().zip(&reflected).map(gap).fold(0.0, f32::max);
        ensure!(
            asymmetry <= GREATEST_ASYMMETRY,
            "body: expected to be its own mirror image within {:.0} mm, found {:.0} mm: \
             train with --set compact.deformation.mirrored=false",
            1e3 * GREATEST_ASYMMETRY,
            1e3 * asymmetry
        );
        let joints = joint_names.iter().enumerate().map(|(joint, name)| opposite(joint_names, name).unwrap_or(joint));
        Ok(Self { triangles: triangles.to_vec(), partners, joints: joints.collect() })
    }

    /// The mirror image of a pose. Where it stands plays no part in what is learnt, and is left as it is.
    pub fn pose(&self, pose: &Pose) -> Pose {
        let reflected = |q: Quat| Quat::from_xyzw(q.x, -q.y, -q.z, q.w);
        let rotations = self.joints.iter().map(|&joint| reflected(pose.rotations[joint])).collect();
        Pose { rotations, translation: pose.translation }
    }

    /// The mirror image of a field of vectors, one a vertex, canonical frame.
    pub fn field(&self, field: &[Vec3A]) -> Vec<Vec3A> {
        let reflect = Vec3A::new(-1.0, 1.0, 1.0);
        self.partners.iter().map(|partner| reflect * partner.interpolate(&self.triangles, field)).collect()
    }
}

/// The joint whose name differs in its side alone.
fn opposite(names: &[String], name: &str) -> Option<usize> {
    let other = match (name.strip_prefix("left_"), name.strip_prefix("right_")) {
        (Some(rest), _) => format!("right_{rest}"),
        (_, Some(rest)) => format!("left_{rest}"),
        _ => return None,
    };
    names.iter().position(|name| *name == other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::read_body_model;
    use crease::animate::PosedSurface;
    use crease::mesh::{Scheme, Subdivision};

    /// Twice the reflection is nothing; and a mirrored body in a mirrored pose is the mirror image of the body in the pose.
    #[test]
    fn reflection_commutes_with_skinning() {
        let body = read_body_model(None).unwrap();
        let rig = body.shaped(&[]);
        let mirror = Mirror::new(&rig.rest, &body.triangles, rig.rest_joints[0].x, &rig.joint_names).unwrap();
        let mut pose = Pose::rest(24);
        for (joint, angle) in [(0, 0.3), (1, 0.5), (4, 0.9), (16, -0.7), (18, 1.1), (6, 0.2)] {
            pose.rotations[joint] = Quat::from_euler(glam::EulerRot::XYZ, angle, 0.4 * angle, -0.6 * angle);
        }
        let back = mirror.pose(&mirror.pose(&pose));
        assert!(back.rotations.iter().zip(&pose.rotations).all(|(a, b)| a.dot(*b).abs() > 1.0 - 1e-6));

        let subdivision = Subdivision::new(rig.rest.len(), &body.triangles, 0);
        let posed = |pose: &Pose, offsets: &[Vec3A]| {
            let mut surface = PosedSurface::new(&subdivision);
            surface.pose(&rig, offsets, pose, &subdivision, Scheme::Loop, 0);
            surface.positions(0).to_vec()
        };
        // A smooth field, so that what differs is the reflection and not where vertices lie.
        let field: Vec<Vec3A> = rig.rest.iter().map(|p| 0.03 * Vec3A::new(p.y, p.x, 1.0 + p.x)).collect();
        let one = posed(&pose, &field);
        let other = posed(&mirror.pose(&pose), &mirror.field(&field));
        let error = |k: usize| {
            let expected = mirror.partners[k].interpolate(&body.triangles, &one);
            let plane = rig.rest_joints[0].x;
            other[k].distance(Vec3A::new(2.0 * plane - expected.x, expected.y, expected.z))
        };
        let mean = (0..one.len()).map(error).sum::<f32>() / one.len() as f32;
        // The open body itself is that symmetric.
        assert!(mean < 0.004, "{mean}");
        let unmirrored = posed(&pose, &field);
        let apart = unmirrored.iter().zip(&other).map(|(a, b)| a.distance(*b)).sum::<f32>() / one.len() as f32;
        assert!(apart > 0.05, "the pose is not symmetric: {apart}");
    }

    #[test]
    fn a_body_that_is_not_symmetric_is_refused() {
        let body = read_body_model(None).unwrap();
        let found = Mirror::new(&body.template, &body.triangles, 0.1, &body.joint_names);
        assert!(found.err().unwrap().to_string().contains("mirrored=false"));
    }
}
