use super::*;
#[cfg(feature = "factor")]
use crate::animate::Stage;

#[cfg(feature = "factor")]
fn fixture() -> Player {
    Player::new(Arc::new(crate::fixture::compact_avatar())).unwrap()
}

#[cfg(feature = "factor")]
fn advance(player: &mut Player, seconds: f64) -> Result<Option<Posed<'_>>, NotFiniteError> {
    player.advance(seconds, &mut |_| ())
}

/// A detail that no number can hold.
#[cfg(feature = "factor")]
const BEYOND: f32 = f32::INFINITY;

#[test]
#[cfg(feature = "factor")]
fn only_what_changes_is_posed_again() {
    let mut player = fixture();
    assert!(advance(&mut player, 0.0).unwrap().is_some());
    assert!(advance(&mut player, 1.0).unwrap().is_none(), "it stands");
    player.options.detail = 0.5;
    assert!(advance(&mut player, 0.0).unwrap().is_some());
}

#[test]
#[cfg(feature = "factor")]
fn the_base_is_there_before_the_solver_and_the_detail_after_it() {
    let mut whole = fixture();
    let detailed = advance(&mut whole, 0.0).unwrap().unwrap().positions.to_vec();
    whole.options.stage = Stage::Base;
    let base = advance(&mut whole, 0.0).unwrap().unwrap().positions.to_vec();
    assert_ne!(detailed, base);

    let mut player = Player::with_base(Arc::new(crate::fixture::compact_avatar())).unwrap();
    assert!(!player.is_detailed());
    assert_eq!(advance(&mut player, 0.0).unwrap().unwrap().positions, base);
    player.prepare_detail().unwrap();
    assert!(player.is_detailed());
    assert_eq!(advance(&mut player, 0.0).unwrap().unwrap().positions, detailed);
    assert_eq!(advance(&mut player, 0.0), Ok(None));
}

#[test]
#[cfg(feature = "factor")]
fn a_factor_that_does_not_fit_is_an_error_of_the_detail() {
    let mut avatar = crate::fixture::compact_avatar();
    avatar.factor.values.pop();
    let mut player = Player::with_base(Arc::new(avatar)).unwrap();
    assert!(advance(&mut player, 0.0).unwrap().is_some());
    assert_eq!(player.prepare_detail().unwrap_err().field, "factor.values");
    assert!(!player.is_detailed());
}

#[test]
#[cfg(feature = "factor")]
fn a_surface_that_is_not_finite_is_an_error_once_and_leaves_no_trace() {
    let mut player = fixture();
    let before = advance(&mut player, 0.0).unwrap().unwrap().positions.to_vec();
    player.options.detail = BEYOND;
    let error = advance(&mut player, 0.0).unwrap_err();
    assert!(error.count > 0 && error.to_string().contains("finite"), "{error}");
    assert_eq!(advance(&mut player, 0.0), Ok(None), "said once");
    player.options.detail = 1.0;
    let after = advance(&mut player, 0.0).unwrap().unwrap().positions.to_vec();
    assert_eq!(after, before, "the solver starts afresh");
}

#[test]
#[cfg(feature = "factor")]
fn a_picture_that_stands_depends_on_its_pose_alone_and_one_that_moves_is_as_near() {
    let moving = Motion { poses: vec![Pose::rest(24), crate::fixture::bent_pose()], ..motion(&[]) };
    let playing = || {
        let mut player = fixture();
        player.set_quality(Some(0));
        player.set_motions(vec![moving.clone()]).unwrap();
        player.clock.play();
        player
    };
    let mut player = playing();
    for _ in 0..4 {
        advance(&mut player, 0.004).unwrap();
    }
    let moved = player.positions.clone();
    player.clock.pause();
    let stands = advance(&mut player, 0.0).unwrap().expect("posed anew").positions.to_vec();
    let mut other = playing();
    other.clock.pause();
    other.clock.seek(player.clock.seconds());
    assert_eq!(advance(&mut other, 0.0).unwrap().unwrap().positions, stands);
    let apart = moved.iter().zip(&stands).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(apart > 0.0 && apart < 4e-5, "the solver started elsewhere: {apart} m");
}

#[test]
#[cfg(feature = "factor")]
fn a_fixed_quality_gives_the_same_mesh_whatever_was_before() {
    let mut player = fixture();
    for level in 0..QUALITY_LEVELS.len() {
        player.set_quality(Some(level));
        player.options.detail = 1.0;
        let first = advance(&mut player, 0.0).unwrap().unwrap().positions.to_vec();
        player.options.detail = 2.0;
        advance(&mut player, 0.0).unwrap();
        player.options.detail = 1.0;
        assert_eq!(advance(&mut player, 0.0).unwrap().unwrap().positions, first, "{}", QUALITY_LEVELS[level].name);
    }
}

#[test]
#[cfg(feature = "factor")]
fn the_last_level_draws_the_coarsest_triangles_with_the_normals_of_a_finer_mesh() {
    let mut player = fixture();
    let [low, lowest] = [3, 4].map(|level| {
        player.set_quality(Some(level));
        let posed = advance(&mut player, 0.0).unwrap().unwrap();
        (posed.positions.len(), posed.normals.to_vec(), posed.coarser)
    });
    let subdivision = player.animator().unwrap().subdivision();
    assert_eq!((low.0, low.2), (subdivision.vertex_count(1), 1));
    assert_eq!((lowest.0, lowest.2), (subdivision.vertex_count(0), 2));
    let furthest = lowest.1.iter().zip(&low.1).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(furthest < 0.2, "one iteration less and no other mesh: {furthest}");
}

#[test]
#[cfg(feature = "factor")]
fn neighbouring_levels_of_quality_look_alike() {
    let mut player = fixture();
    let mut better: [Vec<Vec3A>; 2] = Default::default();
    for level in 0..QUALITY_LEVELS.len() {
        player.set_quality(Some(level));
        let posed = advance(&mut player, 0.0).unwrap().unwrap();
        let (positions, normals) = (posed.positions.to_vec(), posed.normals.to_vec());
        // Levels of the mesh begin with the vertices of the coarser one.
        let furthest = |a: &[Vec3A], b: &[Vec3A]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let apart = [furthest(&positions, &better[0]), furthest(&normals, &better[1])];
        let name = QUALITY_LEVELS[level].name;
        assert!(apart[0] < 0.01 && apart[1] < 0.5, "{name}: {} m, normals {}", apart[0], apart[1]);
        better = [positions, normals];
    }
}

#[test]
#[cfg(feature = "factor")]
fn an_exact_frame_is_the_same_whatever_was_before() {
    let mut player = fixture();
    player.set_crossfade(0.3);
    player.set_motions(vec![turning()]).unwrap();
    player.show_exactly(0.5);
    let first = advance(&mut player, 0.0).unwrap().unwrap().positions.to_vec();
    player.clock.play();
    for _ in 0..4 {
        advance(&mut player, 0.13).unwrap();
    }
    player.show_exactly(0.5);
    assert_eq!(advance(&mut player, 0.0).unwrap().unwrap().positions, first);
    assert!(!player.clock.playing());
}

#[test]
#[cfg(feature = "factor")]
fn a_loop_fades_over_its_seam_only_while_it_plays() {
    let mut player = fixture();
    player.set_crossfade(0.4);
    player.set_motions(vec![turning()]).unwrap();
    player.clock.set_looping(true);
    player.seek(0.95);
    player.clock.play();
    player.step(0.05 + 1e-6);
    let seam = player.pose();
    let turn = |pose: &Pose| pose.rotations[0].to_scaled_axis().y;
    assert!((turn(&seam) - 1.0).abs() < 0.05, "still as at the end: {}", turn(&seam));
    player.seek(0.0);
    assert!(turn(&player.pose()).abs() < 1e-3, "a seek cuts");
}

#[test]
#[cfg(feature = "factor")]
fn another_crossfade_keeps_the_moment() {
    let mut player = fixture();
    player.set_motions(vec![turning(), turning()]).unwrap();
    assert!((player.clock.duration() - 2.0).abs() < 1e-6);
    player.seek(0.3);
    player.set_crossfade(0.4);
    assert!((player.clock.duration() - 1.6).abs() < 1e-6);
    assert_eq!(player.clock.seconds(), 0.3);
}

#[test]
#[cfg(feature = "factor")]
fn a_live_pose_takes_the_place_of_the_motion_and_must_fit_the_skeleton() {
    let mut player = fixture();
    player.set_motions(vec![turning()]).unwrap();
    player.clock.play();
    let joints = player.avatar().rig.parents.len();
    let mut numbers = vec![0.0; 3 * joints];
    numbers[1] = 0.5;
    player.set_live_pose(Some(&numbers), Some(Vec3::X)).unwrap();
    player.step(0.3);
    assert_eq!(player.pose().translation, Vec3::X);
    assert!(!player.moving(), "a live pose moves when it is set");
    assert_eq!(player.set_live_pose(Some(&[0.0; 6]), None).unwrap_err().found, 2);
    player.set_live_pose(None, None).unwrap();
    assert!(player.moving());
}

/// Turns by one radian in one second.
#[cfg(feature = "factor")]
fn turning() -> Motion {
    let joints = crate::fixture::compact_avatar().rig.parents.len();
    let poses = (0..=10).map(|i| {
        let mut pose = Pose::rest(joints);
        pose.rotations[0] = glam::Quat::from_rotation_y(0.1 * i as f32);
        pose
    });
    Motion { poses: poses.collect(), frames_per_second: 10.0, notes: Vec::new() }
}

fn motion(joint_counts: &[usize]) -> Motion {
    Motion {
        poses: joint_counts.iter().map(|&count| Pose::rest(count)).collect(),
        frames_per_second: 30.0,
        notes: Vec::new(),
    }
}

#[test]
fn a_motion_for_this_skeleton_is_accepted() {
    assert_eq!(check_joints(&motion(&[24, 24]), 24), Ok(()));
}

#[test]
fn a_motion_for_another_skeleton_is_named() {
    let error = check_joints(&motion(&[24, 22]), 24).unwrap_err();
    assert_eq!(error, JointCountError { pose: 1, expected: 24, found: 22 });
    assert_eq!(error.to_string(), "motion: pose 1: expected 24 joint rotations, found 22");
}
