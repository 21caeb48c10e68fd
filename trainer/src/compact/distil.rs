//! A trained avatar's perceptrons made into tables: sampled on the vertices at many poses, then regressed as scans' fits are.

use super::CompactOptions;
use super::laplacian::coarsen;
use super::surface_fit::refine_to_finest;
use super::two_scales::{BranchOptions, regress_surface};
use anyhow::ensure;
use crease::animate::{Animator, Options};
use crease::avatar::Avatar;
use crease::body::Pose;
use crease::mesh::{Scheme, Subdivision};
use crease::network::{Domain, Scratch, SurfaceFunction};
use glam::Vec3A;
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Arc;

/// How far a distilled avatar is from the one it was made from: root mean squares over vertices and poses.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// f_d, mm.
    pub deformation_mm: f64,
    /// f_l on its tables' level carried to the finest, 1/m.
    pub laplacian_per_metre: f64,
    /// Detailed vertices, mm.
    pub vertices_mm: f64,
}

/// `avatar` with both functions as tables, sampled at `poses`.
///
/// Fails where a function is compact already, or where there are fewer than two poses.
pub fn distil(avatar: &Avatar, poses: &[Pose], options: &CompactOptions) -> anyhow::Result<Avatar> {
    ensure!(poses.len() > 1, "poses: expected at least 2, found {}", poses.len());
    for (field, function) in [("f_d", &avatar.deformation), ("f_l", &avatar.laplacian)] {
        ensure!(matches!(function, SurfaceFunction::Mlp(_)), "{field}: expected a perceptron, found tables");
    }
    let subdivision = subdivision(avatar);
    let domains = Domain::levels(&avatar.canonical, &avatar.rig.skin, &subdivision, subdivision.level_count());
    let sampled = |function: &SurfaceFunction, level: usize, options: &BranchOptions| {
        let targets: Vec<Vec<Vec3A>> =
            poses.par_iter().map(|pose| values(function, &subdivision, &domains, pose, level)).collect();
        let compact = regress_surface(level, &subdivision, &domains, &avatar.rig, poses, &targets, options)?;
        anyhow::Ok(SurfaceFunction::Compact(compact))
    };
    let level = (options.laplacian_level as usize).min(avatar.laplacian.level());
    Ok(Avatar {
        deformation: sampled(&avatar.deformation, 0, &options.deformation)?,
        laplacian: sampled(&avatar.laplacian, level, &options.laplacian)?,
        ..avatar.clone()
    })
}

/// Compares two avatars of one body over `poses`.
pub fn difference(a: &Avatar, b: &Avatar, poses: &[Pose]) -> anyhow::Result<Difference> {
    let subdivision = subdivision(a);
    let domains = Domain::levels(&a.canonical, &a.rig.skin, &subdivision, subdivision.level_count());
    let finest = subdivision.level_count();
    let mut animators = [Animator::new(Arc::new(a.clone()))?, Animator::new(Arc::new(b.clone()))?];
    let mut sums = [0.0; 3];
    for pose in poses {
        let pairs = [
            [a, b].map(|avatar| values(&avatar.deformation, &subdivision, &domains, pose, 0)),
            [a, b].map(|avatar| values(&avatar.laplacian, &subdivision, &domains, pose, finest)),
            animators.each_mut().map(|animator| animator.animate(pose, &Options::default()).to_vec()),
        ];
        for (sum, [a, b]) in sums.iter_mut().zip(&pairs) {
            let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a.distance_squared(*b))).sum();
            *sum += squares / (a.len() * poses.len()) as f64;
        }
    }
    let [deformation, laplacian, vertices] = sums.map(f64::sqrt);
    Ok(Difference { deformation_mm: 1e3 * deformation, laplacian_per_metre: laplacian, vertices_mm: 1e3 * vertices })
}

fn subdivision(avatar: &Avatar) -> Subdivision {
    Subdivision::new(avatar.rig.rest.len(), &avatar.triangles, avatar.level_count as usize)
}

/// A function's values on the vertices of `level`: Loop's stencils carry a coarser function up, and the field whose refinement is closest
/// stands for a finer one.
fn values(
    function: &SurfaceFunction,
    subdivision: &Subdivision,
    domains: &[Domain],
    pose: &Pose,
    level: usize,
) -> Vec<Vec3A> {
    let own = function.level();
    let mut field = vec![Vec3A::ZERO; subdivision.vertex_count(own)];
    function.evaluate(&domains[own], pose, &mut Scratch::default(), &mut field);
    if own == level {
        return field;
    }
    let field = refine_to_finest(subdivision, Scheme::Loop, own, &field);
    if level == subdivision.level_count() { field } else { coarsen(subdivision, level, &field) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crease::fixture::{bent_pose, compact_avatar, plain_avatar};
    use glam::Quat;

    /// From rest to bent and a little beyond.
    fn poses(count: usize, offset: f32) -> Vec<Pose> {
        let (rest, bent) = (Pose::rest(24), bent_pose());
        (0..count)
            .map(|i| {
                let t = (i as f32 + offset) / (count - 1) as f32;
                let mut pose = bent.clone();
                for (rotation, (a, b)) in pose.rotations.iter_mut().zip(rest.rotations.iter().zip(&bent.rotations)) {
                    *rotation = Quat::slerp(*a, *b, t);
                }
                pose
            })
            .collect()
    }

    fn options(basis_count: usize) -> CompactOptions {
        let mut options = CompactOptions::for_perceptrons();
        options.deformation.wide.basis_count = basis_count;
        options.laplacian.wide.basis_count = basis_count;
        options
    }

    #[test]
    fn the_plain_fixture_comes_back_within_a_fraction_of_its_detail() {
        let plain = plain_avatar();
        let compact = distil(&plain, &poses(9, 0.0), &options(8)).unwrap();
        let read = Avatar::read(&compact.write(), "distilled").unwrap();
        // Between the poses it was sampled at.
        let found = difference(&plain, &read, &poses(9, 0.5)[..8]).unwrap();
        let mean_alone = distil(&plain, &poses(9, 0.0), &options(0)).unwrap();
        let coarse = difference(&plain, &mean_alone, &poses(9, 0.5)[..8]).unwrap();
        assert!(found.deformation_mm < 0.25 * coarse.deformation_mm, "{found:?} and {coarse:?}");
        assert!(found.laplacian_per_metre < 0.5 * coarse.laplacian_per_metre, "{found:?} and {coarse:?}");
        assert!(found.vertices_mm < 0.5 * coarse.vertices_mm && found.vertices_mm < 1.0, "{found:?} and {coarse:?}");
    }

    #[test]
    fn tables_are_refused_and_so_is_a_single_pose() {
        let options = options(4);
        assert!(distil(&compact_avatar(), &poses(4, 0.0), &options).unwrap_err().to_string().contains("f_d"));
        assert!(distil(&plain_avatar(), &poses(4, 0.0)[..1], &options).unwrap_err().to_string().contains("poses"));
    }

    #[test]
    fn an_avatar_does_not_differ_from_itself() {
        let plain = plain_avatar();
        let found = difference(&plain, &plain, &poses(3, 0.0)).unwrap();
        assert_eq!(found, Difference { deformation_mm: 0.0, laplacian_per_metre: 0.0, vertices_mm: 0.0 });
    }
}
