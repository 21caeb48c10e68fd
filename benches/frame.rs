//! What a frame costs on one thread of the CPU, part by part; the solver against a prefactored direct one; set-up.
//!
//! `cargo xtask bench` runs this and collects the medians. The avatar is the demo's, or the file that `CREASE_AVATAR` names.

use crease::animate::{Animator, Options, Part};
use crease::avatar::Avatar;
use crease::laplacian::apply_topological;
use crease::mesh::{Adjacency, Scheme, Subdivision, vertex_normals};
use crease::motion::Motion;
use crease::network::{Compact, SurfaceFunction};
use crease::player::{Player, QUALITY_LEVELS};
use crease::solver::{CoarseFactor, Solver, Start, Stop};
use criterion::{Criterion, criterion_group, criterion_main};
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use glam::Vec3A;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Pictures a second of the motion that is played.
const RATE: f32 = 60.0;

/// Wrinkles of the solver's problem, metres.
const WRINKLE_HEIGHT: f32 = 0.005;
const WRINKLE_LENGTH: f32 = 0.06;

/// Accuracy at which the solvers are compared, metres.
const ACCURACY: f32 = 2e-5;

fn asset(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("web/assets").join(path)
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn avatar() -> Avatar {
    let path = std::env::var_os("CREASE_AVATAR").map_or_else(|| asset("shirt-dancer.glb"), PathBuf::from);
    Avatar::read(&read(&path), &path.to_string_lossy()).unwrap_or_else(|error| panic!("{error}"))
}

fn dance() -> Motion {
    Motion::read(&read(&asset("motions/dance_a.pkl")), "dance_a.pkl", Some(RATE)).expect("the demo's motion")
}

/// The avatar with its base subdivided `level_count` times. Where f_l stands on a finer level, its values there are dropped.
fn subdivided(mut avatar: Avatar, level_count: u32) -> Avatar {
    avatar.level_count = level_count;
    if let SurfaceFunction::Compact(tables) = &mut avatar.laplacian
        && tables.level > level_count
    {
        let levels = Subdivision::new(avatar.rig.rest.len(), &avatar.triangles, level_count as usize);
        *tables = coarsened(tables, level_count, levels.vertex_count(level_count as usize) as u32);
    }
    let subdivision = Subdivision::new(avatar.rig.rest.len(), &avatar.triangles, level_count as usize);
    avatar.anchors.retain(|&anchor| (anchor as usize) < subdivision.vertex_count(level_count as usize));
    avatar.factor = CoarseFactor::new(&subdivision, &avatar.anchors, avatar.anchor_weight);
    avatar
}

/// The rows of the first `vertex_count` vertices, which are those of the coarser `level`.
fn coarsened(tables: &Compact, level: u32, vertex_count: u32) -> Compact {
    let mut coarse = Compact { level, row_vertices: vec![], mean: vec![], basis: vec![], ..tables.clone() };
    let mut basis = tables.basis.as_slice();
    for region in &mut coarse.regions {
        let (first, row_length) = (coarse.row_vertices.len() as u32, 3 * region.basis_count as usize);
        for row in region.rows.0 as usize..region.rows.1 as usize {
            let (of_row, rest) = basis.split_at(row_length);
            basis = rest;
            if tables.row_vertices[row] < vertex_count {
                coarse.row_vertices.push(tables.row_vertices[row]);
                coarse.mean.extend_from_slice(&tables.mean[3 * row..3 * row + 3]);
                coarse.basis.extend_from_slice(of_row);
            }
        }
        region.rows = (first, coarse.row_vertices.len() as u32);
    }
    coarse
}

/// Plays the dance and measures the time of what `is_counted` selects in each frame.
fn play(animator: &mut Animator, options: Options, frames: u64, is_counted: impl Fn(Part) -> bool) -> Duration {
    let motion = dance();
    let mut total = Duration::ZERO;
    for frame in 0..frames {
        let pose = motion.sample_looped(frame as f32 / RATE);
        let mut last = Instant::now();
        animator.animate_observed(&pose, &options, &mut |part| {
            let now = Instant::now();
            if is_counted(part) {
                total += now - last;
            }
            last = now;
        });
    }
    total
}

fn frames(criterion: &mut Criterion) {
    let shared = Arc::new(avatar());
    let mut animator = Animator::new(shared.clone()).expect("the avatar is valid");
    let options = Options { warm_start: true, ..Options::default() };
    criterion.bench_function("frame", |bencher| {
        let mut normals = vec![Vec3A::ZERO; animator.subdivision().vertex_count(animator.subdivision().level_count())];
        let motion = dance();
        let mut frame = 0;
        bencher.iter(|| {
            frame += 1;
            let pose = motion.sample_looped(frame as f32 / RATE);
            let positions = animator.animate(&pose, &options).to_vec();
            vertex_normals(&positions, animator.triangles(), &mut normals);
            black_box(&normals);
        });
    });
    for (name, part) in [
        ("frame/deformation", Part::Deformation),
        ("frame/base", Part::Base),
        ("frame/laplacian", Part::Laplacian),
        ("frame/residual", Part::Residual),
        ("frame/solve", Part::Solve),
    ] {
        criterion.bench_function(name, |bencher| {
            bencher.iter_custom(|count| play(&mut animator, options, count, |played| played == part));
        });
    }
    for level in animator.levels() {
        let name = format!("frame/solved on level {level}");
        let options = Options { solve_level: level, ..options };
        criterion.bench_function(&name, |bencher| {
            bencher.iter_custom(|count| play(&mut animator, options, count, |_| true));
        });
    }
    criterion.bench_function("frame/from the base", |bencher| {
        let cold = Options { warm_start: false, ..options };
        bencher.iter_custom(|count| play(&mut animator, cold, count, |_| true));
    });
    for (index, level) in QUALITY_LEVELS.iter().enumerate() {
        let mut player = Player::new(shared.clone()).expect("the avatar is valid");
        player.set_motions(vec![dance()]).expect("the demo's motion fits");
        player.set_quality(Some(index));
        player.clock.set_looping(true);
        player.clock.play();
        criterion.bench_function(&format!("quality/{}", level.name), |bencher| {
            bencher.iter(|| black_box(player.advance(1.0 / f64::from(RATE), &mut |_| ()).expect("finite").is_some()));
        });
    }
    for level_count in [0, 1, 2, 3] {
        let mut animator = Animator::new(Arc::new(subdivided((*shared).clone(), level_count))).expect("still valid");
        let name = format!("scaling/{} vertices", animator.subdivision().vertex_count(level_count as usize));
        criterion.bench_function(&name, |bencher| {
            bencher.iter_custom(|count| play(&mut animator, options, count, |_| true));
        });
    }
    criterion.bench_function("animator setup", |bencher| bencher.iter(|| Animator::new(shared.clone())));
}

/// Wrinkles on the rest pose, the rows' residual that asks for them, and what solves it.
struct Problem {
    subdivision: Subdivision,
    adjacency: Adjacency,
    avatar: Avatar,
    residual: Vec<Vec3A>,
}

impl Problem {
    fn new() -> Self {
        let avatar = avatar();
        let finest = avatar.level_count as usize;
        let subdivision = Subdivision::new(avatar.rig.rest.len(), &avatar.triangles, finest);
        let mut positions = avatar.rig.rest.clone();
        for level in 0..finest {
            let mut finer = vec![Vec3A::ZERO; subdivision.vertex_count(level + 1)];
            subdivision.refine(Scheme::Loop, level, &positions, &mut finer);
            positions = finer;
        }
        let mut wrinkles = positions.clone();
        vertex_normals(&positions, subdivision.triangles(finest), &mut wrinkles);
        for (wrinkle, position) in wrinkles.iter_mut().zip(&positions) {
            let phase = std::f32::consts::TAU / WRINKLE_LENGTH * (position.y + 0.4 * position.x);
            *wrinkle *= WRINKLE_HEIGHT * phase.sin();
        }
        let adjacency = Adjacency::new(positions.len(), subdivision.triangles(finest));
        let mut residual = positions;
        apply_topological(&adjacency, &wrinkles, &mut residual);
        Self { subdivision, adjacency, avatar, residual }
    }

    fn solver(&self) -> Solver {
        let Avatar { anchors, anchor_weight, factor, .. } = &self.avatar;
        Solver::new(&self.subdivision, anchors, *anchor_weight, factor).expect("the avatar's own factor")
    }

    /// LᵀL + w_a S and Lᵀ r in double precision.
    fn system(&self) -> (SparseColMat<usize, f64>, faer::Mat<f64>) {
        let count = self.residual.len();
        let mut entries = Vec::new();
        let mut right = faer::Mat::<f64>::zeros(count, 3);
        for k in 0..count {
            let neighbours = self.adjacency.of(k);
            let weight = -1.0 / neighbours.len() as f64;
            let row: Vec<(usize, f64)> = neighbours.iter().map(|&j| (j as usize, weight)).chain([(k, 1.0)]).collect();
            for &(i, left) in &row {
                entries.extend(row.iter().map(|&(j, value)| Triplet::new(i, j, left * value)));
                for axis in 0..3 {
                    right[(i, axis)] += left * f64::from(self.residual[k][axis]);
                }
            }
        }
        let anchor_weight = f64::from(self.avatar.anchor_weight);
        entries.extend(self.avatar.anchors.iter().map(|&a| Triplet::new(a as usize, a as usize, anchor_weight)));
        let matrix = SparseColMat::try_new_from_triplets(count, count, &entries).expect("indices are in range");
        (matrix, right)
    }
}

fn solvers(criterion: &mut Criterion) {
    let problem = Problem::new();
    let finest = problem.subdivision.level_count();
    let (matrix, right) = problem.system();
    // One thread against one thread.
    faer::set_global_parallelism(faer::Par::Seq);
    let factor = matrix.sp_cholesky(faer::Side::Lower).expect("positive definite");
    let exact = factor.solve(&right);
    let mut solver = problem.solver();
    let mut displacement = problem.residual.clone();
    let stop = Stop::Tolerance(ACCURACY);
    let iterations = solver.solve(finest, &problem.residual, &mut displacement, Start::Base, stop);
    let distance = |k: usize| {
        let exact = Vec3A::from_array([0, 1, 2].map(|axis| exact[(k, axis)] as f32));
        exact.distance(displacement[k])
    };
    let error = (0..displacement.len()).map(distance).fold(0.0, f32::max);
    assert!(error <= ACCURACY, "{iterations} iterations leave {error} m");
    println!("solve: {iterations} iterations, {:.4} mm from the direct solution", 1e3 * error);

    criterion.bench_function("solve", |bencher| {
        bencher.iter(|| solver.solve(finest, &problem.residual, &mut displacement, Start::Base, stop));
    });
    criterion.bench_function("solve directly", |bencher| bencher.iter(|| factor.solve(black_box(&right))));
    criterion.bench_function("solver setup", |bencher| bencher.iter(|| problem.solver()));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(4));
    targets = frames, solvers
}
criterion_main!(benches);
