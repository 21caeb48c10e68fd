use super::*;
use crate::fixture::{bent_pose, compact_avatar, plain_avatar};
use crate::laplacian::scale_per_area;
use crate::mesh::Adjacency;
use crate::network::SurfaceFunction;
use crate::solver::CoarseFactor;
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use glam::{Quat, Vec3};

fn animator(avatar: Avatar) -> Animator {
    Animator::new(Arc::new(avatar)).unwrap()
}

fn options(stage: Stage, detail: f32) -> Options {
    Options { stage, detail, ..Options::default() }
}

fn largest_distance(a: &[Vec3A], b: &[Vec3A]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn without_detail_the_result_is_the_base_and_detail_is_linear() {
    for avatar in [compact_avatar(), plain_avatar()] {
        let mut animator = animator(avatar);
        let mut animate = |stage, detail| {
            // Enough iterations for the last bit that f32 has.
            let options = Options { stop: Stop::Iterations(30), ..options(stage, detail) };
            animator.animate(&bent_pose(), &options).to_vec()
        };
        let base = animate(Stage::Base, 1.0);
        assert_eq!(animate(Stage::Detailed, 0.0), base);
        let (half, once, twice) =
            (animate(Stage::Detailed, 0.5), animate(Stage::Detailed, 1.0), animate(Stage::Detailed, 2.0));
        let size = largest_distance(&once, &base);
        assert!(size > 1e-3, "detail moves the surface: {size} m");
        for k in 0..base.len() {
            let displacement = once[k] - base[k];
            assert!((half[k] - base[k] - 0.5 * displacement).length() < 1e-3 * size);
            assert!((twice[k] - base[k] - 2.0 * displacement).length() < 1e-3 * size);
        }
    }
}

#[test]
fn the_body_is_the_base_without_its_offsets() {
    let avatar = compact_avatar();
    let mut bare = avatar.clone();
    silence(&mut bare.deformation);
    let body = animator(avatar.clone()).animate(&bent_pose(), &options(Stage::Body, 1.0)).to_vec();
    let base = animator(avatar).animate(&bent_pose(), &options(Stage::Base, 1.0)).to_vec();
    let bare_base = animator(bare).animate(&bent_pose(), &options(Stage::Base, 1.0)).to_vec();
    assert_eq!(body, bare_base);
    let offset = largest_distance(&body, &base);
    assert!((0.003..0.06).contains(&offset), "cloth stands off by {offset} m");
}

/// Makes a compact function zero everywhere.
fn silence(function: &mut SurfaceFunction) {
    let SurfaceFunction::Compact(compact) = function else { panic!("compact") };
    compact.mean.fill(0.0);
    compact.basis.fill(0);
}

#[test]
fn the_relative_form_of_nothing_is_the_base() {
    let mut avatar = compact_avatar();
    silence(&mut avatar.laplacian);
    let mut animator = animator(avatar);
    let base = animator.animate(&bent_pose(), &options(Stage::Base, 1.0)).to_vec();
    assert_eq!(animator.animate(&bent_pose(), &options(Stage::Detailed, 1.0)), base);
}

#[test]
fn turning_the_root_turns_the_result() {
    for avatar in [compact_avatar(), plain_avatar()] {
        let pivot = avatar.rig.rest_joints[0];
        let mut animator = animator(avatar);
        let options = Options { stop: Stop::Iterations(20), ..Options::default() };
        let pose = bent_pose();
        let turn = Quat::from_euler(glam::EulerRot::YXZ, 2.0, 0.7, -1.1);
        let mut turned = pose.clone();
        turned.rotations[0] = turn * pose.rotations[0];
        turned.translation = Vec3::new(1.0, -2.0, 0.5);
        let before = animator.animate(&pose, &options).to_vec();
        let after = animator.animate(&turned, &options).to_vec();
        let expected: Vec<Vec3A> = before
            .iter()
            .map(|&v| turn * (v - pivot - Vec3A::from(pose.translation)) + pivot + Vec3A::from(turned.translation))
            .collect();
        let error = largest_distance(&after, &expected);
        assert!(error < 2e-5, "{error} m");
        assert!(largest_distance(&before, &after) > 0.5, "the test would notice");
    }
}

#[test]
fn the_result_depends_on_pose_and_options_alone() {
    let mut animator = animator(compact_avatar());
    let options = Options::default();
    let first = animator.animate(&bent_pose(), &options).to_vec();
    animator.animate(&Pose::rest(24), &Options { detail: 2.0, ..options });
    assert_eq!(animator.animate(&bent_pose(), &options), first);
    let cold = animator.iterations();
    let warm = Options { warm_start: true, ..options };
    let again = animator.animate(&bent_pose(), &warm).to_vec();
    assert!(largest_distance(&again, &first) < 2e-5, "within the tolerance of both");
    assert!(animator.iterations() < cold, "{} iterations after {cold}", animator.iterations());
}

#[test]
fn agrees_with_the_direct_solution() {
    for avatar in [compact_avatar(), plain_avatar()] {
        let mut animator = animator(avatar);
        let detailed = animator.animate(&bent_pose(), &Options::default()).to_vec();
        let expected = solve_directly(&animator);
        let error = largest_distance(&detailed, &expected);
        assert!(error < 2e-5, "{}: {error} m", animator.avatar().name);
        let moved = largest_distance(&expected, animator.surface().finest());
        assert!(moved > 1e-3, "there is something to solve: {moved} m");
    }
}

/// u' of (LᵀL + w_a S) u' = Lᵀ s δ (+ Lᵀ L u in the relative form) + w_a S u in f64, from what the last call left of base and δ.
fn solve_directly(animator: &Animator) -> Vec<Vec3A> {
    let base = animator.surface().finest();
    let adjacency = &Adjacency::new(base.len(), animator.triangles());
    let mut areas = vec![0.0; base.len()];
    crate::mesh::mixed_voronoi_areas(base, animator.triangles(), &mut areas);
    let row = |k: usize| {
        let neighbours = adjacency.of(k);
        let weight = -1.0 / neighbours.len() as f64;
        std::iter::once((k, 1.0)).chain(neighbours.iter().map(move |&j| (j as usize, weight)))
    };
    let anchor_weight = f64::from(animator.avatar().anchor_weight);
    let mut triplets = Vec::new();
    let mut right = faer::Mat::<f64>::zeros(base.len(), 3);
    let deltas = animator.laplacians.last().unwrap();
    for k in 0..base.len() {
        let scale = areas[k] * scale_per_area(adjacency.valence(k));
        for axis in 0..3 {
            let mut wanted = f64::from(scale) * f64::from(deltas[k][axis]);
            if animator.avatar().form == Form::Relative {
                wanted += row(k).map(|(j, weight)| weight * f64::from(base[j][axis])).sum::<f64>();
            }
            for (j, weight) in row(k) {
                right[(j, axis)] += weight * wanted;
            }
        }
        for (i, a) in row(k) {
            triplets.extend(row(k).map(|(j, b)| Triplet::new(i, j, a * b)));
        }
    }
    for &anchor in &animator.avatar().anchors {
        let anchor = anchor as usize;
        triplets.push(Triplet::new(anchor, anchor, anchor_weight));
        for axis in 0..3 {
            right[(anchor, axis)] += anchor_weight * f64::from(base[anchor][axis]);
        }
    }
    let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(base.len(), base.len(), &triplets).unwrap();
    let solution = matrix.sp_cholesky(faer::Side::Lower).unwrap().solve(&right);
    (0..base.len()).map(|k| Vec3A::from_array([0, 1, 2].map(|axis| solution[(k, axis)] as f32))).collect()
}

#[test]
fn coarser_levels_are_near_and_their_vertices_come_first() {
    for avatar in [compact_avatar(), plain_avatar()] {
        let mut animator = animator(subdivided_once_more(avatar));
        let (coarsest, finest) = animator.levels().into_inner();
        assert!(coarsest < finest, "there is a choice of levels");
        let mut animate = |level, solve_level| {
            let options = Options { level, solve_level, ..Options::default() };
            animator.animate(&bent_pose(), &options).to_vec()
        };
        let full = animate(finest, finest);
        assert_eq!(animate(usize::MAX, usize::MAX), full, "the default is the finest");
        let carried_up = animate(finest, coarsest);
        let coarse = animate(coarsest, finest);
        assert_eq!(animate(0, 0), coarse, "no coarser than the avatar allows");
        let base = animator.surface().positions(finest).to_vec();
        assert_eq!((full.len(), carried_up.len()), (base.len(), base.len()));
        assert_eq!(coarse.len(), animator.subdivision().vertex_count(coarsest));
        let detail = largest_distance(&full, &base);
        let lost = largest_distance(&full, &carried_up);
        assert!(lost > 1e-5 && lost < 0.4 * detail, "{lost} of {detail} m");
        // Loop moves an old vertex a little when it refines.
        let apart = largest_distance(&coarse, &full[..coarse.len()]);
        assert!(apart < 0.02, "{apart} m");
    }
}

fn subdivided_once_more(mut avatar: Avatar) -> Avatar {
    avatar.level_count += 1;
    let subdivision = Subdivision::new(avatar.rig.rest.len(), &avatar.triangles, avatar.level_count as usize);
    avatar.factor = CoarseFactor::new(&subdivision, &avatar.anchors, avatar.anchor_weight);
    avatar
}

#[test]
fn each_part_is_reported_in_its_order() {
    let mut animator = animator(compact_avatar());
    let mut parts = |stage| {
        let mut parts = Vec::new();
        animator.animate_observed(&bent_pose(), &options(stage, 1.0), &mut |part| parts.push(part));
        parts
    };
    let all = [Part::Deformation, Part::Base, Part::Laplacian, Part::Residual, Part::Solve];
    assert_eq!(parts(Stage::Detailed), all);
    assert_eq!(parts(Stage::Base), all[..2]);
}

#[test]
fn pose_blend_shapes_are_added_before_skinning() {
    let mut avatar = compact_avatar();
    silence(&mut avatar.deformation);
    let count = avatar.rig.rest.len();
    let mut directions = vec![vec![Vec3A::ZERO; count]; 207];
    // Entry (row 0, column 1) of the first joint after the root.
    directions[1] = vec![Vec3A::new(0.0, 0.0, 0.01); count];
    let plain = animator(avatar.clone()).animate(&bend(0.0), &options(Stage::Body, 1.0)).to_vec();
    avatar.rig.pose_directions = Some(directions);
    let mut animator = animator(avatar);
    assert_eq!(animator.animate(&bend(0.0), &options(Stage::Body, 1.0)), plain, "R = I adds nothing");
    let bent = animator.animate(&bend(0.6), &options(Stage::Body, 1.0)).to_vec();
    // The head is far from the hip and moves by the direction alone: R₀₁ = −sin 0.6.
    let head = (0..count).max_by(|&a, &b| plain[a].y.total_cmp(&plain[b].y)).unwrap();
    let moved = bent[head] - plain[head];
    let expected = Vec3A::new(0.0, 0.0, -0.01 * 0.6f32.sin());
    assert!(moved.distance(expected) < 1e-5, "{moved}");
}

/// The left hip turned about z.
fn bend(angle: f32) -> Pose {
    let mut pose = Pose::rest(24);
    pose.rotations[1] = Quat::from_rotation_z(angle);
    pose
}

#[test]
fn a_factor_of_another_topology_is_an_error() {
    let mut avatar = compact_avatar();
    avatar.factor.values.pop();
    let error = Animator::new(Arc::new(avatar)).err().expect("one value is missing");
    assert_eq!(error.field, "factor.values");
}

#[test]
fn finite_weights_of_values_that_are_not_are_errors_at_load() {
    type Pick = fn(&mut Avatar) -> &mut SurfaceFunction;
    let functions: [(&str, Pick); 2] = [("deformation", |a| &mut a.deformation), ("laplacian", |a| &mut a.laplacian)];
    for (field, function) in functions {
        for avatar in [compact_avatar(), plain_avatar()] {
            let mut avatar = avatar;
            match function(&mut avatar) {
                SurfaceFunction::Mlp(mlp) => {
                    mlp.layers.iter_mut().flat_map(|layer| &mut layer.weight).for_each(|weight| *weight *= 1e25);
                }
                SurfaceFunction::Compact(compact) => compact.basis_step.fill(f32::MAX),
            }
            avatar.validate("test").expect("every number is finite");
            let error = Animator::new(Arc::new(avatar)).err().expect("values are not");
            assert_eq!(error.field, field, "{error}");
        }
    }
}
