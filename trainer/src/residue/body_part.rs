//! Parts of the body by which errors are told apart.

use crate::compact::refine_between;
use crease::body::Rig;
use crease::mesh::{Scheme, Subdivision};

/// A part of the body; left and right are one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum BodyPart {
    Head,
    Torso,
    UpperArms,
    Forearms,
    Hands,
    Thighs,
    Shins,
    Feet,
}

/// All of them, from above.
pub const BODY_PARTS: [BodyPart; 8] = [
    BodyPart::Head,
    BodyPart::Torso,
    BodyPart::UpperArms,
    BodyPart::Forearms,
    BodyPart::Hands,
    BodyPart::Thighs,
    BodyPart::Shins,
    BodyPart::Feet,
];

impl BodyPart {
    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Head => "head",
            Self::Torso => "torso",
            Self::UpperArms => "upper arms",
            Self::Forearms => "forearms",
            Self::Hands => "hands",
            Self::Thighs => "thighs",
            Self::Shins => "shins",
            Self::Feet => "feet",
        }
    }

    /// The part that a joint moves, by SMPL's names; the torso where the name says nothing.
    fn of_joint(name: &str) -> Self {
        let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
        if has(&["neck", "head", "jaw", "eye"]) {
            Self::Head
        } else if has(&["shoulder"]) {
            Self::UpperArms
        } else if has(&["elbow"]) {
            Self::Forearms
        } else if has(&["wrist", "hand", "index", "middle", "pinky", "ring", "thumb"]) {
            Self::Hands
        } else if has(&["hip"]) {
            Self::Thighs
        } else if has(&["knee"]) {
            Self::Shins
        } else if has(&["ankle", "foot"]) {
            Self::Feet
        } else {
            Self::Torso
        }
    }

    /// The part of each vertex of the finest level: the one whose joints have most of its skinning weight.
    pub fn of_vertices(rig: &Rig, subdivision: &Subdivision) -> Vec<Self> {
        let of_joints: Vec<Self> = rig.joint_names.iter().map(|name| Self::of_joint(name)).collect();
        let share = |part: Self| {
            let weight = |(joints, weights): (&[u8; 4], &[f32; 4])| -> f32 {
                let pairs = joints.iter().zip(weights);
                pairs.filter(|(joint, _)| of_joints[**joint as usize] == part).map(|(_, weight)| weight).sum()
            };
            let shares: Vec<f32> = rig.skin.joints.iter().zip(&rig.skin.weights).map(weight).collect();
            refine_between(subdivision, Scheme::Midpoint, 0..subdivision.level_count(), &shares)
        };
        let shares = BODY_PARTS.map(share);
        let strongest = |vertex: usize| {
            let order = |a: &usize, b: &usize| shares[*a][vertex].total_cmp(&shares[*b][vertex]);
            BODY_PARTS[(0..BODY_PARTS.len()).max_by(order).unwrap_or_default()]
        };
        (0..shares[0].len()).map(strongest).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::read_body_model;

    #[test]
    fn parts_lie_where_they_belong_on_every_level() {
        let body = read_body_model(None).unwrap();
        let rig = body.shaped(&[]);
        let subdivision = Subdivision::new(rig.rest.len(), &body.triangles, 1);
        let parts = BodyPart::of_vertices(&rig, &subdivision);
        assert_eq!(parts.len(), subdivision.vertex_count(1));
        let mut fine = vec![glam::Vec3A::ZERO; parts.len()];
        subdivision.refine(Scheme::Midpoint, 0, &rig.rest, &mut fine);
        let mean = |part: BodyPart, axis: fn(glam::Vec3A) -> f32| {
            let of_part: Vec<f32> =
                parts.iter().zip(&fine).filter(|(p, _)| **p == part).map(|(_, v)| axis(*v)).collect();
            assert!(!of_part.is_empty(), "{part:?}");
            of_part.iter().sum::<f32>() / of_part.len() as f32
        };
        let heights = [BodyPart::Head, BodyPart::Torso, BodyPart::Thighs, BodyPart::Shins, BodyPart::Feet];
        assert!(heights.map(|part| mean(part, |v| v.y)).is_sorted_by(|a, b| a > b));
        let reaches = [BodyPart::Torso, BodyPart::UpperArms, BodyPart::Forearms, BodyPart::Hands];
        assert!(reaches.map(|part| mean(part, |v| v.x.abs())).is_sorted());
    }
}
