//! Names of the joints of SMPL, SMPL-H and SMPL-X.

/// SMPL's joint names, in its order.
pub const SMPL_JOINT_NAMES: [&str; 24] = [
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_hand",
    "right_hand",
];
/// So many of them SMPL-H and SMPL-X share.
const SHARED_COUNT: usize = 22;
const FINGERS: [&str; 5] = ["index", "middle", "pinky", "ring", "thumb"];

/// Names for a skeleton of `count` joints: SMPL's (24), SMPL-H's (52), SMPL-X's (55); beyond those, numbers.
pub fn joint_names(count: usize) -> Vec<String> {
    let mut names: Vec<String> = SMPL_JOINT_NAMES[..SHARED_COUNT].iter().map(ToString::to_string).collect();
    match count {
        52 => names.extend(fingers()),
        55 => {
            names.extend(["jaw", "left_eye", "right_eye"].map(ToOwned::to_owned));
            names.extend(fingers());
        }
        _ => names.extend(SMPL_JOINT_NAMES[SHARED_COUNT..].iter().map(ToString::to_string)),
    }
    names.truncate(count);
    for joint in names.len()..count {
        names.push(format!("joint_{joint}"));
    }
    names
}

/// Three joints a finger, first of the left hand.
fn fingers() -> impl Iterator<Item = String> {
    ["left", "right"].into_iter().flat_map(|side| {
        FINGERS.into_iter().flat_map(move |finger| (1..=3).map(move |joint| format!("{side}_{finger}{joint}")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_names_as_joints() {
        for count in [0, 3, 24, 30, 52, 55, 60] {
            assert_eq!(joint_names(count).len(), count);
        }
        assert_eq!(joint_names(24)[23], "right_hand");
        assert_eq!(joint_names(52)[22], "left_index1");
        assert_eq!(joint_names(55)[54], "right_thumb3");
    }
}
