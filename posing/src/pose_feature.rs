//! The pose mask: which joints a surface point listens to (paper Eq. pose_feature).

use crate::rig::Skin;

/// A set of joints, one bit a joint. The root is never in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default, serde::Serialize, serde::Deserialize)]
#[serde(transparent)]
pub struct PoseMask(pub u32);

impl PoseMask {
    /// The mask of `joints`.
    pub const fn of(joints: &[usize]) -> Self {
        let mut bits = 0;
        let mut i = 0;
        while i < joints.len() {
            bits |= 1 << joints[i];
            i += 1;
        }
        Self(bits)
    }

    /// Joints of either mask.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether joint `joint` is in the mask.
    pub fn contains(self, joint: usize) -> bool {
        self.0 >> joint & 1 == 1
    }

    /// The joints in the mask, ascending.
    pub fn joints(self) -> impl Iterator<Item = usize> {
        (0..32).filter(move |&joint| self.contains(joint))
    }
}

/// A skinning weight below this does not count as influence: it is zero in the avatar file, which has 16-bit weights.
pub const SMALLEST_WEIGHT: f32 = 0.5 / 65535.0;

/// Non-zero pattern of row-vectors of W for SMPL's 24 joints: `association()[i]` holds the joints that a point skinned to joint i
/// listens to. Head, feet and hands listen to none.
///
/// The hips region follows both hips and the lowest spine joint, a leg its hip and knee, the torso the spine, collars and shoulders
/// (its lowest part both hips too), an arm its collar, shoulder and elbow.
pub const fn association() -> [PoseMask; 24] {
    const NONE: PoseMask = PoseMask(0);
    const HIPS: PoseMask = PoseMask::of(&[1, 2, 3]);
    const LEFT_LEG: PoseMask = PoseMask::of(&[1, 4]);
    const RIGHT_LEG: PoseMask = PoseMask::of(&[2, 5]);
    const TORSO: PoseMask = PoseMask::of(&[3, 6, 9, 13, 14, 16, 17]);
    const WAIST: PoseMask = TORSO.union(HIPS);
    const LEFT_ARM: PoseMask = PoseMask::of(&[13, 16, 18]);
    const RIGHT_ARM: PoseMask = PoseMask::of(&[14, 17, 19]);
    [
        HIPS, LEFT_LEG, RIGHT_LEG, WAIST, LEFT_LEG, RIGHT_LEG, TORSO, NONE, NONE, TORSO, NONE, NONE, NONE, TORSO,
        TORSO, NONE, LEFT_ARM, RIGHT_ARM, LEFT_ARM, RIGHT_ARM, NONE, NONE, NONE, NONE,
    ]
}

/// θ̄'s mask of each vertex: the union of the association of the joints that influence it.
pub fn vertex_masks(skin: &Skin) -> Vec<PoseMask> {
    let association = association();
    skin.joints
        .iter()
        .zip(&skin.weights)
        .map(|(joints, weights)| {
            joints
                .iter()
                .zip(weights)
                .filter(|&(_, &weight)| weight >= SMALLEST_WEIGHT)
                .fold(PoseMask::default(), |mask, (&joint, _)| mask.union(association[joint as usize]))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_names::SMPL_JOINT_NAMES;

    fn joint(name: &str) -> usize {
        SMPL_JOINT_NAMES.iter().position(|&n| n == name).unwrap()
    }

    #[test]
    fn nobody_listens_to_the_root_the_head_feet_or_hands() {
        for mask in association() {
            for name in ["pelvis", "head", "left_foot", "right_ankle", "left_hand", "right_wrist"] {
                assert!(!mask.contains(joint(name)), "{name} in {mask:?}");
            }
        }
        for name in ["head", "neck", "left_foot", "right_foot", "left_hand", "right_hand", "left_wrist"] {
            assert_eq!(association()[joint(name)], PoseMask(0), "{name}");
        }
    }

    #[test]
    fn association_is_symmetric_left_to_right() {
        let mirrored = |i: usize| match SMPL_JOINT_NAMES[i].split_once('_') {
            Some(("left", rest)) => joint(&format!("right_{rest}")),
            Some(("right", rest)) => joint(&format!("left_{rest}")),
            _ => i,
        };
        let association = association();
        for i in 0..24 {
            let expected = association[i].joints().fold(0, |mask, j| mask | 1 << mirrored(j));
            assert_eq!(association[mirrored(i)], PoseMask(expected), "{}", SMPL_JOINT_NAMES[i]);
        }
    }

    #[test]
    fn a_vertex_listens_to_the_union_of_its_influences() {
        let skin = Skin {
            joints: vec![[4, 7, 0, 0], [7, 4, 0, 0]],
            weights: vec![[0.5, 0.5, 0.0, 0.0], [1.0, 1e-6, 0.0, 0.0]],
        };
        let masks = vertex_masks(&skin);
        assert_eq!(masks[0].joints().collect::<Vec<_>>(), [1, 4], "weight 0 to the pelvis adds nothing");
        assert_eq!(masks[1], PoseMask(0), "a weight that the file rounds to zero adds nothing");
    }
}
