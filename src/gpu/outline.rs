//! Points around a posed figure, for whoever must know where it is without reading it back.

use crate::body::{Pose, Rig, posed_from_rest};
use glam::Vec3A;

/// Cloth stands off the body by no more than this, metres.
const CLOTH: f32 = 0.04;

/// Boxes around what each joint carries, in the rest pose.
pub(super) struct Outline {
    boxes: Vec<(usize, [Vec3A; 2])>,
}

impl Outline {
    pub fn new(rig: &Rig) -> Self {
        let around = |joint: usize| {
            let mut bounds = [Vec3A::INFINITY, Vec3A::NEG_INFINITY];
            for ((vertex, joints), weights) in rig.rest.iter().zip(&rig.skin.joints).zip(&rig.skin.weights) {
                if joints.iter().zip(weights).any(|(&other, &weight)| other as usize == joint && weight >= 0.5) {
                    bounds = [bounds[0].min(*vertex), bounds[1].max(*vertex)];
                }
            }
            bounds[0].cmple(bounds[1]).all().then(|| (joint, [bounds[0] - CLOTH, bounds[1] + CLOTH]))
        };
        Self { boxes: (0..rig.parents.len()).filter_map(around).collect() }
    }

    /// The corners of all boxes, posed.
    pub fn points(&self, rig: &Rig, pose: &Pose) -> Vec<Vec3A> {
        let transforms = posed_from_rest(rig, pose);
        let corners = |&(joint, [low, high]): &(usize, [Vec3A; 2])| {
            let transform = transforms[joint];
            (0..8).map(move |corner| {
                let side = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
                transform.transform_point3a(Vec3A::new(side(0), side(1), side(2)))
            })
        };
        self.boxes.iter().flat_map(corners).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animate::{Options, animate};
    use crate::fixture::{bent_pose, compact_avatar};

    #[test]
    fn a_posed_figure_lies_within_its_outline_which_is_not_much_larger() {
        let avatar = compact_avatar();
        let outline = Outline::new(&avatar.rig);
        for pose in [Pose::rest(24), bent_pose()] {
            let bounds = |points: &[Vec3A]| {
                points.iter().fold([Vec3A::INFINITY, Vec3A::NEG_INFINITY], |[low, high], p| [low.min(*p), high.max(*p)])
            };
            let [low, high] = bounds(&outline.points(&avatar.rig, &pose));
            let [lowest, highest] = bounds(&animate(&avatar, &pose, &Options::default()).unwrap().positions);
            assert!(low.cmple(lowest).all() && highest.cmple(high).all(), "{low} {lowest} {highest} {high}");
            assert!((high - low).length() < 1.4 * (highest - lowest).length());
        }
    }
}
