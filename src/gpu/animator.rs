//! Pose to vertex buffer, as a list of dispatches that is made once.

use super::conjugate_gradients::GpuSolver;
use super::error::GpuError;
use super::frame::{Frame, is_detailed};
use super::inverse_factor::InverseFactor;
use super::kernel::{Dispatch, WORKGROUP, WORKGROUP_LIMIT, uniform_of, vectors};
use super::outline::Outline;
use super::sparse::{GpuMatrix, SparseKernels, stencils};
use super::timestamps::Timestamps;
use super::topology::GpuCorners;
use super::{compact, perceptron, residual, rotation, skinning, surface};
use crate::animate::{Animator, Options, Stage};
use crate::avatar::Avatar;
use crate::body::Pose;
use crate::mesh::Scheme;
use crate::network::SurfaceFunction;
use crate::solver::Stop;
use glam::Vec3A;
use std::sync::Arc;
use wgpu::{AdapterInfo, Buffer, CommandEncoder, ComputePassDescriptor, Device, DeviceType, Features, Queue};

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
    queue: Queue,
    frame: Buffer,
    deformation: Vec<Dispatch>,
    base: Vec<Dispatch>,
    laplacian: Vec<Dispatch>,
    residual: Dispatch,
    solver: GpuSolver,
    surface: Dispatch,
    displacement: Buffer,
    /// Pose and detail that `displacement` belongs to.
    solved: Option<(Pose, f32)>,
    outline: Outline,
    operations: u64,
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
        let (avatar, subdivision) = (animator.shared_avatar(), animator.subdivision());
        let finest = subdivision.level_count();
        let (vertex_count, laplacian_level) = (subdivision.vertex_count(finest), avatar.laplacian.level());
        let frame = uniform_of(
            device,
            "frame",
            &Frame::new(&avatar, &Pose::rest(avatar.rig.parents.len()), &Options::default()),
        );
        let on_level = |label, level| vectors(device, label, subdivision.vertex_count(level));
        let (row_residual, displacement) = (on_level("row residual", finest), on_level("displacement", finest));
        let solver = GpuSolver::new(device, &animator.solver, subdivision, &row_residual, &displacement);
        let corners = GpuCorners::new(device, vertex_count, subdivision.triangles(finest));
        let sparse = SparseKernels::new(device);

        let evaluate = |function: &SurfaceFunction, values: &Buffer| {
            let domain = &animator.domains()[function.level()];
            match function {
                SurfaceFunction::Mlp(mlp) => perceptron::evaluate(device, mlp, domain, &frame, values),
                SurfaceFunction::Compact(tables) => {
                    compact::evaluate(device, tables, avatar.rig.parents.len(), &frame, values, domain.canonical.len())
                }
            }
        };
        let refine = |scheme, first: usize, mut coarse: Buffer, dispatches: &mut Vec<Dispatch>| {
            for level in first..finest {
                let fine = on_level("refined", level + 1);
                let matrix = GpuMatrix::new(device, &stencils(subdivision, scheme, level));
                dispatches.push(sparse.apply(&matrix, &coarse, &fine));
                coarse = fine;
            }
            coarse
        };

        let (offsets, posed) = (on_level("offsets", 0), on_level("posed", 0));
        let deformation = evaluate(&avatar.deformation, &offsets);
        let mut base = vec![skinning::pose(device, &avatar.rig, &frame, &offsets, &posed)];
        let finest_base = refine(avatar.scheme, 0, posed, &mut base);

        let deltas = on_level("deltas", laplacian_level);
        let mut laplacian = evaluate(&avatar.laplacian, &deltas);
        laplacian.push(rotation::rotate(device, &avatar.rig.skin, subdivision, laplacian_level, &frame, &deltas));
        let finest_deltas = refine(Scheme::Loop, laplacian_level, deltas, &mut laplacian);

        let fields = [&finest_base, &finest_deltas, &row_residual];
        let residual = residual::row_residual(device, &frame, fields, &corners, solver.rings(), vertex_count);
        let surface = surface::surface(device, &frame, [&finest_base, &displacement, vertices], &corners, vertex_count);
        Ok(Self {
            operations: [&avatar.deformation, &avatar.laplacian].map(|f| operations(f, animator)).iter().sum(),
            outline: Outline::new(&avatar.rig),
            avatar,
            queue: queue.clone(),
            frame,
            deformation,
            base,
            laplacian,
            residual,
            solver,
            surface,
            displacement,
            solved: None,
        })
    }

    /// Records the frame of `pose` on `encoder`, and its times if `timestamps` are given.
    ///
    /// As nothing is read back, [`Stop::Tolerance`] stands for a fixed number of iterations that reaches 0.02 mm. A warm start is left
    /// out where the pose jumps, so that a frame depends on pose and options alone, within that tolerance.
    pub fn animate(
        &mut self,
        encoder: &mut CommandEncoder,
        pose: &Pose,
        options: &Options,
        mut timestamps: Option<&mut Timestamps>,
    ) {
        self.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&Frame::new(&self.avatar, pose, options)));
        let mut iterations = 0;
        if is_detailed(options) {
            let is_warm =
                options.warm_start && self.solved.as_ref().is_some_and(|solved| is_near(solved, pose, options));
            if !is_warm {
                encoder.clear_buffer(&self.displacement, 0, None);
            }
            iterations = iteration_count(options.stop, is_warm);
            self.solved = Some((pose.clone(), options.detail));
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
            timestamps.finish(encoder);
        }
    }

    /// Points whose box holds the figure in `pose`, for shadows and cameras: its vertices stay on the GPU.
    pub fn outline(&self, pose: &Pose) -> Vec<Vec3A> {
        self.outline.points(&self.avatar.rig, pose)
    }

    /// What a frame that starts from nothing costs.
    pub fn cost(&self, options: &Options) -> Cost {
        let upload_bytes = size_of::<Frame>() as u64;
        let mut cost =
            Cost { dispatches: 0, memory_bytes: 0, operations: self.operations, upload_bytes, buffer_bytes: 0 };
        let mut buffers: Vec<Buffer> = Vec::new();
        self.for_each_stage(options, iteration_count(options.stop, false), |_, dispatches| {
            for dispatch in dispatches {
                cost.dispatches += 1;
                cost.memory_bytes += dispatch.bytes;
                for buffer in &dispatch.buffers {
                    if !buffers.contains(buffer) {
                        buffers.push(buffer.clone());
                    }
                }
            }
        });
        cost.buffer_bytes = buffers.iter().map(Buffer::size).sum();
        cost
    }

    fn for_each_stage(
        &self,
        options: &Options,
        iterations: u32,
        mut visit: impl FnMut(&'static str, &mut dyn Iterator<Item = &Dispatch>),
    ) {
        let [deformation, base, laplacian, residual, solve, surface] = STAGES;
        if options.stage != Stage::Body {
            visit(deformation, &mut self.deformation.iter());
        }
        visit(base, &mut self.base.iter());
        if is_detailed(options) {
            visit(laplacian, &mut self.laplacian.iter());
            visit(residual, &mut std::iter::once(&self.residual));
            visit(solve, &mut self.solver.dispatches(iterations));
        }
        visit(surface, &mut std::iter::once(&self.surface));
    }
}

fn iteration_count(stop: Stop, is_warm: bool) -> u32 {
    match stop {
        Stop::Iterations(count) => count,
        Stop::Tolerance(_) if is_warm => WARM_ITERATIONS,
        Stop::Tolerance(_) => COLD_ITERATIONS,
    }
}

/// Whether the displacement that was solved for `solved` is a good first guess for `pose`.
fn is_near((solved, detail): &(Pose, f32), pose: &Pose, options: &Options) -> bool {
    let mut pairs = solved.rotations.iter().zip(&pose.rotations);
    *detail == options.detail && pairs.all(|(a, b)| a.angle_between(*b) <= POSE_JUMP)
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
