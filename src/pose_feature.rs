//! The pose mask: which joints a surface point listens to (paper Eq. pose_feature).

use crate::body::Skin;

/// A set of joints, one bit a joint. The root is never in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct PoseMask(pub u32);

impl PoseMask {
    /// Whether joint `joint` is in the mask.
    pub fn contains(self, joint: usize) -> bool {
        self.0 >> joint & 1 == 1
    }

    /// The joints in the mask, ascending.
    pub fn joints(self) -> impl Iterator<Item = usize> {
        (0..32).filter(move |&joint| self.contains(joint))
    }
}

/// Non-zero pattern of row-vectors of W for SMPL's 24 joints: `association()[i]` holds the joints that a point skinned to joint i
/// listens to. Head, feet and hands listen to none.
pub fn association() -> [PoseMask; 24] {
    todo!()
}

/// θ̄'s mask of each vertex: the union of the association of the joints that influence it.
pub fn vertex_masks(skin: &Skin) -> Vec<PoseMask> {
    let _ = skin;
    todo!()
}
