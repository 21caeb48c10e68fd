//! Pose to vertex buffer, as a list of dispatches that is made once.

use super::conjugate_gradients::{GpuSolver, GpuSolvers};
use super::error::GpuError;
use super::finite::FiniteCheck;
use super::frame::{Frame, is_detailed};
use super::inverse_factor::InverseFactor;
use super::kernel::{Dispatch, Gpu, WORKGROUP, WORKGROUP_LIMIT, uniform_of, vectors};
use super::outline::Outline;
use super::residual::ResidualKernel;
use super::sparse::{GpuMatrix, LoopMatrices, SparseKernels, stencils};
use super::surface::SurfaceKernel;
use super::timestamps::Timestamps;
use super::topology::GpuCorners;
use super::{compact, perceptron, rotation, skinning};
use crate::animate::{Animator, Options, Stage};
use crate::avatar::Avatar;
use crate::body::Pose;
use crate::mesh::Scheme;
use crate::network::SurfaceFunction;
use crate::solver::Stop;
use glam::Vec3A;
use std::ops::RangeInclusive;
use std::sync::Arc;
use wgpu::{AdapterInfo, Buffer, CommandEncoderDescriptor, ComputePassDescriptor, Device, DeviceType, Features, Queue};

/// The stages of a frame, in order.
pub(super) const STAGES: [&str; 6] = ["deformation", "base", "laplacian", "residual", "solve", "surface"];

/// Iterations that reach 0.02 mm from nothing, and from the last frame's displacement at ordinary speeds.
const COLD_ITERATIONS: u32 = 5;
const WARM_ITERATIONS: u32 = 3;

/// A joint that turns by more than this from frame to frame, radians, makes the last frame a worse guess than none.
const POSE_JUMP: f32 = 0.35;

/// An avatar on a GPU, ready to move.
pub struct GpuAnimator {
    avatar: Arc<Avatar>,
    gpu: Gpu,
    frame: Buffer,
    /// Levels that can be asked for; lists over levels begin with the first.
    levels: RangeInclusive<usize>,
    deformation: Vec<Dispatch>,
    skinning: Dispatch,
    /// The base from each level to the next, from level 0 on.
    base: Vec<Dispatch>,
    /// f_l and its rotation.
    laplacian: Vec<Dispatch>,
    /// δ from each level to the next, from that of f_l on.
    deltas: Vec<Dispatch>,
    solvers: GpuSolvers,
    solves: Vec<LevelSolve>,
    /// The displacement from each level to the next.
    displacement: Vec<Dispatch>,
    surfaces: Vec<Dispatch>,
    finite: FiniteCheck,
    /// Pose, detail and level that was solved last.
    solved: Option<Solved>,
    outline: Outline,
    operations: u64,
}

/// From δ on a level to the displacement there.
struct LevelSolve {
    residual: Dispatch,
    solver: GpuSolver,
}

/// What a frame costs, counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost {
    /// Dispatches.
    pub dispatches: u32,
    /// Bytes moved between memory and processors if each dispatch touches each number of its buffers once.
    pub memory_bytes: u64,
    /// Multiplications and additions of perceptrons.
    pub operations: u64,
    /// Bytes from CPU to GPU.
    pub upload_bytes: u64,
    /// Bytes of all buffers, the drawn vertices included: what the avatar occupies.
    pub buffer_bytes: u64,
}

impl GpuAnimator {
    /// What is worth asking an adapter for.
    pub fn features() -> Features {
        Features::SHADER_F16 | Features::TIMESTAMP_QUERY
    }

    /// An error where computing on the adapter is no gain.
    pub fn check_adapter(info: &AdapterInfo) -> Result<(), GpuError> {
        match info.device_type {
            DeviceType::Cpu => Err(GpuError::Software { name: info.name.clone() }),
            _ => Ok(()),
        }
    }

    /// Prepares what `animator` has prepared. Frames are written to `vertices`: 16 bytes for each vertex of the finest level, position
    /// and octahedral normal, usable as storage.
    pub fn new(device: &Device, queue: &Queue, animator: &Animator, vertices: &Buffer) -> Result<Self, GpuError> {
        check_limits(device, animator)?;
        let gpu = &Gpu { device: device.clone(), queue: queue.clone() };
        let (avatar, subdivision, levels) = (animator.shared_avatar(), animator.subdivision(), animator.levels());
        let (coarsest, finest) = (*levels.start(), *levels.end());
        let laplacian_level = avatar.laplacian.level();
        let rest = Frame::new(&avatar, &Pose::rest(avatar.rig.parents.len()), &Options::default());
        let frame = uniform_of(gpu, "frame", &rest);
        let on_level = |label, level| vectors(gpu, label, subdivision.vertex_count(level));
        let sparse = SparseKernels::new(gpu);

        let evaluate = |function: &SurfaceFunction, values: &Buffer| {
            let domain = &animator.domains()[function.level()];
            match function {
                SurfaceFunction::Mlp(mlp) => perceptron::evaluate(gpu, mlp, domain, &frame, values),
                SurfaceFunction::Compact(tables) => {
                    compact::evaluate(gpu, tables, avatar.rig.parents.len(), &frame, values, domain.canonical.len())
                }
            }
        };
        let loops = &LoopMatrices::new(gpu, subdivision);
        // Carries a field from each level to the next, the first of which is `level`.
        let refined = |scheme, level: usize, fields: &[Buffer]| -> Vec<Dispatch> {
            let steps = (level..).zip(fields).zip(&fields[1..]);
            let step = |((level, coarse), fine): ((usize, &Buffer), &Buffer)| match scheme {
                Scheme::Loop => sparse.apply(loops.upwards(level), coarse, fine),
                Scheme::Midpoint => {
                    sparse.apply(&GpuMatrix::new(gpu, &stencils(subdivision, scheme, level)), coarse, fine)
                }
            };
            steps.map(step).collect()
        };

        let offsets = on_level("offsets", 0);
        let deformation = evaluate(&avatar.deformation, &offsets);
        let bases: Vec<Buffer> = (0..=finest).map(|level| on_level("posed", level)).collect();
        let base = refined(avatar.scheme, 0, &bases);
        let skinning = skinning::pose(gpu, &avatar.rig, &frame, &offsets, &bases[0]);

        let solvers = GpuSolvers::new(gpu, &animator.solver, subdivision, loops);
        let all_deltas: Vec<Buffer> = (laplacian_level..=finest).map(|level| solvers.deltas(level).clone()).collect();
        let deltas = refined(Scheme::Loop, laplacian_level, &all_deltas);
        let mut laplacian = evaluate(&avatar.laplacian, &all_deltas[0]);
        laplacian.push(rotation::rotate(gpu, &avatar.rig.skin, subdivision, laplacian_level, &frame, &all_deltas[0]));

        let (residual_kernel, surface_kernel) = (ResidualKernel::new(gpu), SurfaceKernel::new(gpu));
        let displacements: Vec<Buffer> = levels.clone().map(|level| on_level("displacement", level)).collect();
        let displacement = refined(Scheme::Loop, coarsest, &displacements);
        let finite = FiniteCheck::new(gpu);
        let (mut solves, mut surfaces) = (Vec::new(), Vec::new());
        for (level, displacement) in levels.clone().zip(&displacements) {
            let vertex_count = subdivision.vertex_count(level);
            let corners = GpuCorners::new(gpu, vertex_count, subdivision.triangles(level));
            let fields = [&bases[level], solvers.deltas(level), solvers.row_residual(level)];
            solves.push(LevelSolve {
                residual: residual_kernel.dispatch(&frame, fields, &corners, solvers.rings(level), vertex_count),
                solver: solvers.on_level(gpu, level, vertex_count, displacement),
            });
            let fields = [&bases[level], displacement, vertices, finite.count()];
            surfaces.push(surface_kernel.dispatch(&frame, fields, &corners, vertex_count));
        }
        Ok(Self {
            operations: [&avatar.deformation, &avatar.laplacian].map(|f| operations(f, animator)).iter().sum(),
            outline: Outline::new(&avatar.rig),
            avatar,
            gpu: gpu.clone(),
            frame,
            levels,
            deformation,
            skinning,
            base,
            laplacian,
            deltas,
            solvers,
            solves,
            displacement,
            surfaces,
            finite,
            solved: None,
        })
    }

    /// Computes the frame of `pose`, and its times if `timestamps` are given.
    ///
    /// As nothing is read back, [`Stop::Tolerance`] stands for a fixed number of iterations that reaches 0.02 mm. A warm start is left
    /// out where the pose jumps, so that a frame depends on pose and options alone, within that tolerance.
    pub fn animate(&mut self, pose: &Pose, options: &Options, mut timestamps: Option<&mut Timestamps>) {
        self.gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&Frame::new(&self.avatar, pose, options)));
        let mut encoder = self.gpu.device.create_command_encoder(&CommandEncoderDescriptor::default());
        let mut iterations = 0;
        if is_detailed(options) {
            let [_, solve_level] = self.levels_of(options);
            let is_warm = options.warm_start
                && self.solved.as_ref().is_some_and(|solved| is_near(solved, pose, options, solve_level));
            if !is_warm {
                self.solvers.forget(&mut encoder);
            }
            iterations = iteration_count(options.stop, is_warm);
            self.solved = Some((pose.clone(), shape_of(options), solve_level));
        }
        if let Some(timestamps) = &mut timestamps {
            timestamps.start();
        }
        self.for_each_stage(options, iterations, |name, dispatches| {
            let timestamp_writes = timestamps.as_mut().map(|timestamps| timestamps.stage(name));
            let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor { label: Some(name), timestamp_writes });
            dispatches.for_each(|dispatch| dispatch.record(&mut pass));
        });
        if let Some(timestamps) = timestamps {
            timestamps.finish(&mut encoder);
        }
        self.finite.record(&mut encoder);
        self.gpu.queue.submit([encoder.finish()]);
        self.finite.read();
    }

    /// How many vertices of earlier frames had no finite place, as far as the GPU has told by now. They have kept their last one.
    pub fn take_not_finite(&mut self) -> usize {
        self.finite.take()
    }

    /// The mesh's level and the one that is solved on.
    fn levels_of(&self, options: &Options) -> [usize; 2] {
        let (coarsest, finest) = (*self.levels.start(), *self.levels.end());
        let level = options.level.clamp(coarsest, finest);
        [level, options.solve_level.clamp(coarsest, level)]
    }

    /// Points whose box holds the figure in `pose`, for shadows and cameras: its vertices stay on the GPU.
    pub fn outline(&self, pose: &Pose) -> Vec<Vec3A> {
        self.outline.points(&self.avatar.rig, pose)
    }

    /// What a frame that starts from nothing costs.
    pub fn cost(&self, options: &Options) -> Cost {
        let upload_bytes = size_of::<Frame>() as u64;
        let buffer_bytes = self.buffer_bytes();
        let mut cost = Cost { dispatches: 0, memory_bytes: 0, operations: self.operations, upload_bytes, buffer_bytes };
        self.for_each_stage(options, iteration_count(options.stop, false), |_, dispatches| {
            for dispatch in dispatches {
                cost.dispatches += 1;
                cost.memory_bytes += dispatch.bytes;
            }
        });
        cost
    }

    /// Bytes of all buffers, of every level, the drawn vertices included.
    pub fn buffer_bytes(&self) -> u64 {
        let mut buffers: Vec<Buffer> = Vec::new();
        for level in self.levels.clone() {
            let options = Options { level, solve_level: level, ..Options::default() };
            self.for_each_stage(&options, 2, |_, dispatches| {
                for buffer in dispatches.flat_map(|dispatch| &dispatch.buffers) {
                    if !buffers.contains(buffer) {
                        buffers.push(buffer.clone());
                    }
                }
            });
        }
        buffers.iter().map(Buffer::size).sum()
    }

    fn for_each_stage(
        &self,
        options: &Options,
        iterations: u32,
        mut visit: impl FnMut(&'static str, &mut dyn Iterator<Item = &Dispatch>),
    ) {
        let [deformation, base, laplacian, residual, solve, surface] = STAGES;
        let coarsest = *self.levels.start();
        let [level, solve_level] = self.levels_of(options);
        if options.stage != Stage::Body {
            visit(deformation, &mut self.deformation.iter());
        }
        visit(base, &mut std::iter::once(&self.skinning).chain(&self.base[..level]));
        if is_detailed(options) {
            let deltas = &self.deltas[..solve_level - self.avatar.laplacian.level()];
            let LevelSolve { residual: of_level, solver } = &self.solves[solve_level - coarsest];
            let carried = &self.displacement[solve_level - coarsest..level - coarsest];
            visit(laplacian, &mut self.laplacian.iter().chain(deltas));
            visit(residual, &mut std::iter::once(of_level));
            visit(solve, &mut solver.dispatches(iterations).chain(carried));
        }
        visit(surface, &mut std::iter::once(&self.surfaces[level - coarsest]));
    }
}

fn iteration_count(stop: Stop, is_warm: bool) -> u32 {
    match stop {
        Stop::Iterations(count) => count,
        Stop::Tolerance(_) if is_warm => WARM_ITERATIONS,
        Stop::Tolerance(_) => COLD_ITERATIONS,
    }
}

/// Pose, shares of detail and liveliness, and level of a solve.
type Solved = (Pose, [f32; 2], usize);

/// What else than the pose shapes the surface.
fn shape_of(options: &Options) -> [f32; 2] {
    [options.detail, options.liveliness]
}

/// Whether what was solved last makes a good first guess for `pose`.
fn is_near((solved, shape, solved_level): &Solved, pose: &Pose, options: &Options, level: usize) -> bool {
    let mut pairs = solved.rotations.iter().zip(&pose.rotations);
    (*shape, *solved_level) == (shape_of(options), level) && pairs.all(|(a, b)| a.angle_between(*b) <= POSE_JUMP)
}

fn operations(function: &SurfaceFunction, animator: &Animator) -> u64 {
    match function {
        SurfaceFunction::Mlp(mlp) => perceptron::operations(mlp, animator.domains()[function.level()].canonical.len()),
        SurfaceFunction::Compact(_) => 0,
    }
}

/// An error where the largest buffers or dispatches exceed what `device` grants.
fn check_limits(device: &Device, animator: &Animator) -> Result<(), GpuError> {
    let (subdivision, limits) = (animator.subdivision(), device.limits());
    let finest = subdivision.level_count();
    let corners = 8 * 3 * subdivision.triangles(finest).len();
    // A row of a refinement has seven entries at most on average, eight bytes each.
    let stencils = 8 * 7 * subdivision.vertex_count(finest);
    let inverse = 2 * InverseFactor::value_count(&animator.solver.factor_parts());
    let directions = animator.avatar().rig.pose_directions.iter().flatten().map(|direction| 12 * direction.len()).sum();
    let largest = [corners, stencils, inverse, directions].into_iter().max().unwrap_or(0) as u64;
    let bindable = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    let workgroups = subdivision.vertex_count(finest).div_ceil(WORKGROUP) as u64;
    for (limit, needed, found) in [
        ("maxStorageBufferBindingSize", largest, bindable),
        ("maxComputeWorkgroupsPerDimension", workgroups, WORKGROUP_LIMIT as u64),
    ] {
        if needed > found {
            return Err(GpuError::Limit { limit, needed, found });
        }
    }
    Ok(())
}
