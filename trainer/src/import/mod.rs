//! Published layouts made into sequences: frames with names of one kind, `sequence.json`, and the poses that came with them.

mod cape;
mod packed;

use crate::files::write_whole;
use crate::sequence::{BodyParameters, Orientation, Up, read, read_error, write_body};
use anyhow::{Context, ensure};
use crease::body::Pose;
use crease::numpy::{Archive, ReadError};
use glam::Vec3;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};

/// A published layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Layout {
    /// CAPE: a folder of raw scans as PLY, and one of `.npz` with `pose` and `transl`
    Cape,
    /// ReSynth and PoP: a folder of `.npz` with `scan_pc`, `scan_n`, `pose` and `transl`
    Packed,
}

/// Where an import comes from and what its files do not say.
#[derive(Clone, Debug)]
pub struct Source {
    /// Folder of the `.npz` files.
    pub frames: PathBuf,
    /// Folder of the scans, where they lie apart.
    pub scans: Option<PathBuf>,
    /// Name of the sequence.
    pub name: String,
    /// Frames a second.
    pub frames_per_second: f32,
    /// `metre`, `centimetre` or `millimetre`: the unit of the scans.
    pub units: String,
    /// How the scans lie.
    pub orientation: Orientation,
    /// What is up in the poses.
    pub poses_up: Up,
}

/// What a layout holds, frame by frame.
struct Found {
    scans: Vec<PathBuf>,
    poses: Vec<Pose>,
    betas: Option<Vec<f32>>,
}

/// What was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// How many frames.
    pub frame_count: usize,
    /// The file of poses: `body.npz` where the files have a shape, else `poses.npz`, from which registration can start.
    pub body: PathBuf,
}

/// Makes a sequence at `directory`, which must not hold one.
pub fn import(layout: Layout, source: &Source, directory: &Path) -> anyhow::Result<Imported> {
    ensure!(!directory.join("sequence.json").exists(), "{}: expected no sequence, found one", directory.display());
    let found = match layout {
        Layout::Cape => cape::find(source)?,
        Layout::Packed => packed::find(source)?,
    };
    let frames = directory.join("frames");
    fs::create_dir_all(&frames).with_context(|| format!("{}: cannot make the directory", frames.display()))?;
    for (index, scan) in found.scans.iter().enumerate() {
        let ending = scan.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let to = frames.join(format!("{index:04}.{ending}"));
        // A link costs no room; other file systems need a copy.
        if fs::hard_link(scan, &to).is_err() {
            fs::copy(scan, &to).with_context(|| format!("{}: cannot be written", to.display()))?;
        }
    }
    let frame_count = found.scans.len();
    let name = if found.betas.is_some() { "body.npz" } else { "poses.npz" };
    let body = directory.join(name);
    let parameters = BodyParameters { betas: found.betas.unwrap_or_default(), poses: found.poses };
    write_body(&body, &parameters, source.poses_up, source.frames_per_second)?;
    let mut description = json!({
        "name": source.name,
        "fps": source.frames_per_second,
        "frame_count": frame_count,
        "units": source.units,
        "up": source.orientation.up,
        "capture": { "kind": "pointcloud" },
    });
    if let Some(axis) = source.orientation.mirrored {
        description["mirrored"] = json!(axis);
    }
    // Last: a folder with a description is whole.
    let text = serde_json::to_string_pretty(&description)? + "\n";
    write_whole(&directory.join("sequence.json"), text.as_bytes())?;
    Ok(Imported { frame_count, body })
}

/// Files of a folder with one ending, in the order of their names.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>, ReadError> {
    let entries =
        fs::read_dir(folder).map_err(|error| read_error(folder, "folder", "a readable folder", error.to_string()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.retain(|path| path.extension().is_some_and(|end| end.eq_ignore_ascii_case(ending)));
    files.sort();
    if files.is_empty() {
        return Err(read_error(folder, "folder", &format!("files with the ending {ending}"), "none".into()));
    }
    Ok(files)
}

/// `pose` (72 numbers), `transl` (3) and, if it is there, `betas` of one frame's file.
fn read_pose(path: &Path) -> Result<(Pose, Option<Vec<f32>>), ReadError> {
    let bytes = read(path)?;
    let mut archive = Archive::open(&bytes, &path.display().to_string())?;
    let mut numbers = |name: &str, count: usize| -> Result<Vec<f32>, ReadError> {
        let field = archive.required(name)?;
        let numbers = field.finite_numbers()?;
        if numbers.len() == count { Ok(numbers) } else { Err(field.wrong_shape(format_args!("({count},)"))) }
    };
    let (pose, translation) = (numbers("pose", 72)?, numbers("transl", 3)?);
    let betas = archive.optional("betas")?.map(|field| field.finite_numbers()).transpose()?;
    Ok((Pose::from_axis_angle(&pose, Vec3::from_slice(&translation)), betas))
}

/// Poses of all files, and the shape of the first.
fn read_poses(files: &[PathBuf]) -> Result<(Vec<Pose>, Option<Vec<f32>>), ReadError> {
    let mut poses = Vec::with_capacity(files.len());
    let mut shape = None;
    for file in files {
        let (pose, betas) = read_pose(file)?;
        shape = shape.or(betas);
        poses.push(pose);
    }
    Ok((poses, shape))
}

#[cfg(test)]
mod tests;
