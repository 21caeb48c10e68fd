//! Passes from pose to residual, and the last one. Tolerances are shares of the largest value unless they say otherwise.

use super::super::frame::Frame;
use super::super::kernel::{Dispatch, storage, uniform_of};
use super::super::residual::ResidualKernel;
use super::super::sparse::{GpuMatrix, SparseKernels, stencils};
use super::super::surface::SurfaceKernel;
use super::super::topology::{GpuCorners, GpuRings};
use super::super::{compact, perceptron, rotation, skinning};
use super::{Gpu, gpu, largest_distance, size};
use crate::animate::{Animator, Options, PosedSurface, Stage};
use crate::avatar::{Avatar, Form};
use crate::body::Pose;
use crate::fixture::{bent_pose, compact_avatar, plain_avatar};
use crate::laplacian::{apply_topological, scale_per_area};
use crate::mesh::test_meshes::noise_vectors;
use crate::mesh::{Adjacency, Scheme, mixed_voronoi_areas, vertex_normals};
use crate::network::{Compact, Domain, Layer, Mlp, Scratch, SurfaceFunction};
use crease_posing::surface_vertex::unpack_normal;
use glam::Vec3A;
use std::sync::Arc;
use wgpu::Buffer;

/// Rounding of sums of some dozen numbers.
const ROUNDING: f32 = 2e-6;

fn frame_of(gpu: &Gpu, avatar: &Avatar, pose: &Pose, options: &Options) -> Buffer {
    uniform_of(gpu, "frame", &Frame::new(avatar, pose, options))
}

fn assert_close(found: &[Vec3A], expected: &[Vec3A], tolerance: f32, what: &str) {
    let (error, size) = (largest_distance(found, expected), size(expected));
    assert!(size > 0.0 && error <= tolerance * size, "{what}: {error} of {size}");
}

/// GPU's and CPU's values of a function in the bent pose.
fn evaluations(function: &SurfaceFunction, avatar: &Avatar, domain: &Domain) -> [Vec<Vec3A>; 2] {
    let gpu = gpu();
    let options = Options { liveliness: 0.7, ..Options::default() };
    let frame = frame_of(gpu, avatar, &bent_pose(), &options);
    let count = domain.canonical.len();
    let values = gpu.empty(count);
    let dispatches = match function {
        SurfaceFunction::Mlp(mlp) => perceptron::evaluate(gpu, mlp, domain, &frame, &values),
        SurfaceFunction::Compact(tables) => compact::evaluate(gpu, tables, 24, &frame, &values, count),
    };
    let mut expected = vec![Vec3A::ZERO; count];
    function.evaluate_lively(domain, &bent_pose(), options.liveliness, &mut Scratch::default(), &mut expected);
    [gpu.run(&dispatches, &values), expected]
}

#[test]
fn compact() {
    let animator = Animator::new(Arc::new(compact_avatar())).unwrap();
    let avatar = animator.avatar();
    for function in [&avatar.deformation, &avatar.laplacian] {
        let [found, expected] = evaluations(function, avatar, &animator.domains()[function.level()]);
        assert_close(&found, &expected, ROUNDING, "tables");
    }
}

#[test]
fn compact_with_many_centres_and_overlapping_regions() {
    let animator = Animator::new(Arc::new(compact_avatar())).unwrap();
    let avatar = animator.avatar();
    let SurfaceFunction::Compact(mut tables) = avatar.laplacian.clone() else { panic!("compact") };
    // 150 centres take three rounds of a workgroup, 70 basis functions two; some recall 100 centres, some none; a second row on the vertices
    // of the first region's overlaps.
    let (centre_count, basis_count) = (150, 70);
    let more = noise_vectors(centre_count * 24 * 2, 3);
    tables.centres = more.iter().flat_map(|v| v.to_array()).collect();
    tables.centre_count = centre_count as u32;
    for (seed, region) in tables.regions.iter_mut().enumerate() {
        let numbers = noise_vectors(centre_count * basis_count, seed as u32);
        region.basis_count = basis_count as u32;
        region.coefficient_from_kernel = numbers.iter().map(|v| v.x).collect();
        let recalled = if seed % 2 == 0 { 100 * basis_count } else { 0 };
        region.recalled = numbers.iter().map(|v| 30.0 * v.y).take(recalled).collect();
        // Any distance is between these bounds.
        region.fade = (seed % 4 == 0).then_some([0.0, 1.0]);
    }
    let steps = tables.regions.len() * basis_count;
    tables.basis_step = (0..steps).map(|k| 0.01 * (1 + k % 3) as f32).collect();
    let entries = 3 * basis_count * tables.row_vertices.len();
    tables.basis = (0..entries).map(|i| ((i * 37 + i / 90) % 255) as i8).collect();
    let last = tables.row_vertices.len() - 1;
    tables.row_vertices[last] = tables.row_vertices[0];
    let calm = {
        let mut values = vec![Vec3A::ZERO; animator.domains()[1].canonical.len()];
        tables.evaluate(&bent_pose(), &mut Scratch::default(), &mut values);
        values
    };
    let function = SurfaceFunction::Compact(tables);
    let [found, expected] = evaluations(&function, avatar, &animator.domains()[1]);
    assert_close(&found, &expected, 1e-5, "tables");
    assert!(largest_distance(&found, &calm) > 0.1 * size(&calm), "what is recalled shows");
}

#[test]
fn perceptron() {
    let animator = Animator::new(Arc::new(plain_avatar())).unwrap();
    let avatar = animator.avatar();
    // The encoding's highest angles differ by their rounding on both sides. Halves have eleven bits.
    let is_half = gpu().device.features().contains(wgpu::Features::SHADER_F16);
    let tolerance = if is_half { 5e-3 } else { 2e-5 };
    for function in [&avatar.deformation, &avatar.laplacian] {
        let [found, expected] = evaluations(function, avatar, &animator.domains()[function.level()]);
        assert_close(&found, &expected, tolerance, "perceptron");
    }
    // Widths that fill no tile, several hidden layers, more vertices than a batch; and no hidden layer at all.
    let domain = &animator.domains()[2];
    let many = Domain { canonical: domain.canonical.repeat(3), masks: domain.masks.repeat(3) };
    assert!(many.canonical.len() > 8192, "{}", many.canonical.len());
    let SurfaceFunction::Mlp(mlp) = &avatar.laplacian else { panic!("plain") };
    for (widths, domain) in [(&[99, 70, 130, 20, 3][..], domain), (&[99, 3], domain), (&[99, 16, 3], &many)] {
        let layers = widths.windows(2).map(|w| random_layer(w[0], w[1])).collect();
        let function = SurfaceFunction::Mlp(Mlp { layers, ..mlp.clone() });
        let [found, expected] = evaluations(&function, avatar, domain);
        assert_close(&found, &expected, tolerance, "perceptron");
    }
}

fn random_layer(inputs: usize, outputs: usize) -> Layer {
    let bound = (3.0 / inputs as f32).sqrt();
    let numbers = |count: usize, seed: usize| -> Vec<f32> {
        noise_vectors(count, (17 * inputs + seed) as u32).iter().map(|v| bound * v.x).collect()
    };
    Layer { weight: numbers(inputs * outputs, 1), bias: numbers(outputs, 2) }
}

#[test]
fn skinning_with_offsets_and_pose_blend_shapes() {
    let gpu = gpu();
    let mut avatar = compact_avatar();
    let count = avatar.rig.rest.len();
    avatar.rig.pose_directions =
        Some((0..207).map(|i| noise_vectors(count, i).iter().map(|v| 0.01 * *v).collect()).collect());
    let offsets: Vec<Vec3A> = noise_vectors(count, 5).iter().map(|v| 0.02 * *v).collect();
    let animator = Animator::new(Arc::new(avatar.clone())).unwrap();
    let mut posed = PosedSurface::new(animator.subdivision());
    for (stage, cpu_offsets) in [(Stage::Detailed, &offsets[..]), (Stage::Body, &[])] {
        let frame = frame_of(gpu, &avatar, &bent_pose(), &Options { stage, ..Options::default() });
        let positions = gpu.empty(count);
        let dispatch = skinning::pose(gpu, &avatar.rig, &frame, &gpu.vectors(&offsets), &positions);
        posed.pose(
            &avatar.rig,
            cpu_offsets,
            &bent_pose(),
            animator.subdivision(),
            avatar.scheme,
            animator.subdivision().level_count(),
        );
        assert_close(&gpu.run([&dispatch], &positions), posed.positions(0), ROUNDING, "skinning");
    }
}

#[test]
fn rotation() {
    let gpu = gpu();
    let animator = Animator::new(Arc::new(compact_avatar())).unwrap();
    let (avatar, subdivision) = (animator.avatar(), animator.subdivision());
    let frame = frame_of(gpu, avatar, &bent_pose(), &Options::default());
    let mut posed = PosedSurface::new(subdivision);
    posed.pose(&avatar.rig, &[], &bent_pose(), subdivision, avatar.scheme, subdivision.level_count());
    for level in 0..=2 {
        let vectors = noise_vectors(subdivision.vertex_count(level), 9);
        let buffer = gpu.vectors(&vectors);
        let dispatch = rotation::rotate(gpu, &avatar.rig.skin, subdivision, level, &frame, &buffer);
        let pairs = posed.rotations(subdivision, level).iter().zip(&vectors);
        let expected: Vec<Vec3A> = pairs.map(|(rotation, vector)| *rotation * *vector).collect();
        assert_close(&gpu.run([&dispatch], &buffer), &expected, ROUNDING, "rotation");
    }
}

#[test]
fn sparse() {
    let gpu = gpu();
    let animator = Animator::new(Arc::new(compact_avatar())).unwrap();
    let subdivision = animator.subdivision();
    let kernels = SparseKernels::new(gpu);
    for scheme in [Scheme::Midpoint, Scheme::Loop] {
        let coarse = noise_vectors(subdivision.vertex_count(1), 1);
        let mut expected = vec![Vec3A::ZERO; subdivision.vertex_count(2)];
        subdivision.refine(scheme, 1, &coarse, &mut expected);
        let matrix = GpuMatrix::new(gpu, &stencils(subdivision, scheme, 1));
        let (x, out) = (gpu.vectors(&coarse), gpu.empty(expected.len()));
        let apply = kernels.apply(&matrix, &x, &out);
        assert_close(&gpu.run([&apply], &out), &expected, ROUNDING, "apply");
        let twice: Vec<Vec3A> = expected.iter().map(|v| 2.0 * *v).collect();
        assert_close(&gpu.run([&apply, &kernels.add(&matrix, &x, &out)], &out), &twice, ROUNDING, "add");
    }
}

/// Base positions and δ on the finest level of a posed fixture.
fn posed(avatar: Avatar) -> (Animator, Vec<Vec3A>, Vec<Vec3A>) {
    let mut animator = Animator::new(Arc::new(avatar)).unwrap();
    let base = animator.animate(&bent_pose(), &Options { stage: Stage::Base, ..Options::default() }).to_vec();
    let deltas = noise_vectors(base.len(), 4).iter().map(|v| 8.0 * *v).collect();
    (animator, base, deltas)
}

#[test]
fn row_residual_of_both_forms() {
    let gpu = gpu();
    for avatar in [compact_avatar(), plain_avatar()] {
        let (animator, base, deltas) = posed(avatar);
        let (avatar, subdivision) = (animator.avatar(), animator.subdivision());
        let options = Options { detail: 1.5, ..Options::default() };
        let triangles = animator.triangles();
        let adjacency = Adjacency::new(base.len(), triangles);
        let mut areas = vec![0.0; base.len()];
        mixed_voronoi_areas(&base, triangles, &mut areas);
        let mut expected = vec![Vec3A::ZERO; base.len()];
        if avatar.form == Form::Absolute {
            apply_topological(&adjacency, &base, &mut expected);
        }
        for (k, ((row, delta), area)) in expected.iter_mut().zip(&deltas).zip(&areas).enumerate() {
            *row = options.detail * (area * scale_per_area(adjacency.valence(k)) * *delta - *row);
        }
        let out = gpu.empty(base.len());
        let dispatch = ResidualKernel::new(gpu).dispatch(
            &frame_of(gpu, avatar, &bent_pose(), &options),
            [&gpu.vectors(&base), &gpu.vectors(&deltas), &out],
            &GpuCorners::new(gpu, base.len(), subdivision.triangles(2)),
            &GpuRings::new(gpu, (0..adjacency.vertex_count()).map(|k| adjacency.of(k).iter().copied())),
            base.len(),
        );
        // The angles of slender triangles magnify the rounding of positions; L u takes differences of metres.
        assert_close(&gpu.run([&dispatch], &out), &expected, 1e-4, "row residual");
    }
}

#[test]
fn surface_with_and_without_displacement() {
    let gpu = gpu();
    let (animator, base, noise) = posed(compact_avatar());
    let displacement: Vec<Vec3A> = noise.iter().map(|v| 0.0005 * *v).collect();
    let corners = GpuCorners::new(gpu, base.len(), animator.triangles());
    for stage in [Stage::Base, Stage::Detailed] {
        let frame = frame_of(gpu, animator.avatar(), &bent_pose(), &Options { stage, ..Options::default() });
        let share = if stage == Stage::Base { 0.0 } else { 1.0 };
        let expected: Vec<Vec3A> = base.iter().zip(&displacement).map(|(b, d)| *b + share * *d).collect();
        let mut normals = expected.clone();
        vertex_normals(&expected, animator.triangles(), &mut normals);
        let vertices = gpu.vertices(base.len());
        let nowhere = storage(gpu, "nowhere", size_of::<u32>());
        let buffers = [&gpu.vectors(&base), &gpu.vectors(&displacement), &vertices, &nowhere];
        let dispatch = SurfaceKernel::new(gpu).dispatch(&frame, buffers, &corners, base.len());
        assert_close(&gpu.run([&dispatch], &vertices), &expected, ROUNDING, "positions");
        let packed: Vec<[u32; 4]> = gpu.read(&vertices);
        let found: Vec<Vec3A> = packed.iter().map(|vertex| unpack_normal(vertex[3]).into()).collect();
        // A step of 16 bits, and what is left of small triangles' precision after subtracting metres.
        assert_close(&found, &normals, 1e-3, "normals");
    }
}

#[test]
fn a_pass_with_other_inputs_is_told_apart() {
    let animator = Animator::new(Arc::new(compact_avatar())).unwrap();
    let avatar = animator.avatar();
    let SurfaceFunction::Compact(tables) = &avatar.deformation else { panic!("compact") };
    let mut other = tables.clone();
    other.basis_step.iter_mut().for_each(|step| *step *= 1.001);
    let count = animator.domains()[0].canonical.len();
    let gpu = gpu();
    let frame = frame_of(gpu, avatar, &bent_pose(), &Options::default());
    let evaluate = |tables: &Compact| {
        let values = gpu.empty(count);
        let dispatches: Vec<Dispatch> = compact::evaluate(gpu, tables, 24, &frame, &values, count);
        gpu.run(&dispatches, &values)
    };
    let (found, changed) = (evaluate(tables), evaluate(&other));
    assert!(largest_distance(&found, &changed) > 10.0 * ROUNDING * size(&found));
}
