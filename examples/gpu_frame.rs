//! What a frame costs on this machine's GPU, by its own clock: one line of JSON.
//!
//!     cargo run --release --example gpu_frame --features gpu -- avatar.glb [--frames N] [--iterations N] [--cold] [--plain]
//!
//! The avatar's own functions are timed, then, on hardware or with `--plain`, random perceptrons of the paper's size in their place.

use crease::animate::{Animator, Options};
use crease::avatar::Avatar;
use crease::body::Pose;
use crease::encoding::PositionalEncoding;
use crease::gpu::{GpuAnimator, Timestamps};
use crease::network::{Layer, Mlp, SurfaceFunction};
use crease::solver::Stop;
use glam::{Quat, Vec3A};
use serde_json::{Value, json};
use std::error::Error;
use std::sync::{Arc, mpsc};
use std::time::Instant;
use wgpu::*;

/// Frames a second of the movement that is timed.
const RATE: f32 = 60.0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path =
        arguments.first().ok_or("expected: gpu_frame avatar.glb [--frames N] [--iterations N] [--cold] [--plain]")?;
    let number = |name: &str| {
        let value = arguments.iter().position(|word| word == name).and_then(|at| arguments.get(at + 1));
        value.map(|text| text.parse::<u32>()).transpose()
    };
    let frame_count = number("--frames")?.unwrap_or(60) as usize;
    let options = Options {
        warm_start: !arguments.iter().any(|word| word == "--cold"),
        stop: number("--iterations")?.map_or(Stop::Tolerance(1e-5), Stop::Iterations),
        ..Options::default()
    };

    let instance = Instance::new(InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&RequestAdapterOptions {
        power_preference: PowerPreference::HighPerformance,
        ..Default::default()
    }))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&DeviceDescriptor {
        required_features: adapter.features() & GpuAnimator::features(),
        ..Default::default()
    }))?;
    let info = adapter.get_info();
    let is_hardware = GpuAnimator::check_adapter(&info).is_ok();

    let avatar = Avatar::read(&std::fs::read(path)?, path)?;
    let mut report = json!({
        "adapter": info.name,
        "driver": info.driver_info,
        "backend": info.backend.to_string(),
        "is_hardware": is_hardware,
        "f16": device.features().contains(Features::SHADER_F16),
        "avatar": avatar.name,
        "own": time(&device, &queue, avatar.clone(), &options, frame_count)?,
    });
    if is_hardware || arguments.iter().any(|word| word == "--plain") {
        report["plain"] = time(&device, &queue, with_perceptrons(avatar), &options, frame_count)?;
    }
    println!("{report}");
    Ok(())
}

/// Medians over `frame_count` frames, each starting from the one before as a player's frames do, unless `options` say otherwise.
fn time(
    device: &Device,
    queue: &Queue,
    avatar: Avatar,
    options: &Options,
    frame_count: usize,
) -> Result<Value, Box<dyn Error>> {
    let mut cpu = Animator::new(Arc::new(avatar))?;
    let vertex_count = cpu.subdivision().vertex_count(cpu.subdivision().level_count());
    let vertices = device.create_buffer(&BufferDescriptor {
        label: Some("vertices"),
        size: 16 * vertex_count as u64,
        usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let started = Instant::now();
    let mut animator = GpuAnimator::new(device, queue, &cpu, &vertices)?;
    let setup_milliseconds = 1e3 * started.elapsed().as_secs_f64();
    let cost = animator.cost(options);
    let mut report = json!({
        "vertices": vertex_count,
        "setup_ms": setup_milliseconds,
        "dispatches": cost.dispatches,
        "memory_bytes": cost.memory_bytes,
        "upload_bytes": cost.upload_bytes,
        "buffer_bytes": cost.buffer_bytes,
        "operations": cost.operations,
    });

    let mut timestamps = Timestamps::new(device, queue);
    let mut stages: Vec<(&str, Vec<f64>)> = Vec::new();
    let mut frames = Vec::new();
    let mut error = 0.0f32;
    for frame in 0..=frame_count {
        let pose = pose_at(cpu.avatar().rig.parents.len(), frame as f32 / RATE);
        animator.animate(&pose, options, timestamps.as_mut());
        let Some(timestamps) = &timestamps else {
            device.poll(PollType::wait_indefinitely())?;
            continue;
        };
        let (sender, receiver) = mpsc::channel();
        timestamps.read(move |times| drop(sender.send(times)));
        device.poll(PollType::wait_indefinitely())?;
        // The first frame pays for what drivers put off.
        if frame > 0 {
            let times = receiver.recv()?;
            frames.push(times.iter().map(|time| time.milliseconds).sum());
            for time in times {
                match stages.iter_mut().find(|(stage, _)| *stage == time.stage) {
                    Some((_, values)) => values.push(time.milliseconds),
                    None => stages.push((time.stage, vec![time.milliseconds])),
                }
            }
        }
        if frame == frame_count {
            let exact = Options { stop: Stop::Tolerance(1e-6), warm_start: false, ..*options };
            let expected = cpu.animate(&pose, &exact);
            error = largest_distance(&read(device, queue, &vertices)?, expected);
        }
    }
    report["error_mm"] = json!(1e3 * error);
    if timestamps.is_some() {
        report["frame_ms"] = json!(median(&mut frames));
        report["stages_ms"] =
            stages.iter_mut().map(|(stage, values)| (stage.to_string(), json!(median(values)))).collect();
    }
    Ok(report)
}

/// A lively movement of all limbs.
fn pose_at(joint_count: usize, seconds: f32) -> Pose {
    let mut pose = Pose::rest(joint_count);
    for (joint, rotation) in pose.rotations.iter_mut().enumerate() {
        let phase = joint as f32;
        *rotation = Quat::from_euler(
            glam::EulerRot::XYZ,
            0.3 * (4.0 * seconds + phase).sin(),
            0.2 * (3.0 * seconds + 2.0 * phase).sin(),
            0.2 * (5.0 * seconds + 3.0 * phase).sin(),
        );
    }
    pose
}

fn read(device: &Device, queue: &Queue, vertices: &Buffer) -> Result<Vec<Vec3A>, Box<dyn Error>> {
    let readable = device.create_buffer(&BufferDescriptor {
        label: Some("readable"),
        size: vertices.size(),
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    encoder.copy_buffer_to_buffer(vertices, 0, &readable, 0, vertices.size());
    queue.submit([encoder.finish()]);
    readable.slice(..).map_async(MapMode::Read, drop);
    device.poll(PollType::wait_indefinitely())?;
    let view = readable.slice(..).get_mapped_range()?;
    let numbers: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&view);
    Ok(numbers.iter().map(|v| Vec3A::new(v[0], v[1], v[2])).collect())
}

fn largest_distance(a: &[Vec3A], b: &[Vec3A]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// `avatar` with f_d of five layers of 600 channels and f_l of three layers of 800 on the finest level, weights at random.
fn with_perceptrons(avatar: Avatar) -> Avatar {
    let joint_count = avatar.rig.parents.len();
    let perceptron = |level, layer_count, width, output_scale| {
        let encoding = PositionalEncoding { frequency_count: 10 };
        let mut widths = vec![width; layer_count + 1];
        (widths[0], widths[layer_count]) = (encoding.length() + 3 * joint_count, 3);
        let layers = widths.windows(2).map(|pair| layer(pair[0], pair[1])).collect();
        SurfaceFunction::Mlp(Mlp { level, encoding, layers, output_scale })
    };
    Avatar {
        deformation: perceptron(0, 5, 600, 0.01),
        laplacian: perceptron(avatar.level_count, 3, 800, 10.0),
        ..avatar
    }
}

/// Uniform weights that keep the size of what passes through.
fn layer(inputs: usize, outputs: usize) -> Layer {
    let mut state = (inputs * 31 + outputs) as u32;
    let mut number = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let bound = (6.0 / inputs as f32).sqrt();
    Layer {
        weight: (0..inputs * outputs).map(|_| bound * number()).collect(),
        bias: (0..outputs).map(|_| 0.1 * number()).collect(),
    }
}
