//! Motions from AIST++ `.pkl` and AMASS / SMPL-X-style `.npz`; either layout may be in either kind of file.

use super::{Motion, SMPL_JOINT_COUNT};
use crate::body::Pose;
use crate::memory::MemoryLimit;
use crate::numpy::{Archive, Field, ReadError};
use glam::Vec3;

/// Joints that SMPL, SMPL-H and SMPL-X share, in one order: all but hands and face.
const SHARED_JOINT_COUNT: usize = 22;
/// Names under which files keep the frame rate.
const RATE_NAMES: [&str; 5] = ["mocap_framerate", "mocap_frame_rate", "frame_rate", "framerate", "fps"];
/// Frame rates that make sense, per second.
const RATES: std::ops::RangeInclusive<f32> = 0.01..=100_000.0;
/// Largest axis-angle number, radians: beyond, 32 bits no longer tell angles apart.
const LARGEST_ANGLE: f32 = 1e4;

impl Motion {
    /// Reads a motion; `name` is the file's name for messages.
    ///
    /// Layouts, N frames:
    /// - AIST++: `smpl_poses (N, 72)`, `smpl_trans (N, 3)`, divided by `smpl_scaling` to give metres; no rate.
    /// - AMASS: `poses (N, 72 | 156 | 165)` (SMPL, SMPL-H, SMPL-X; also 66: no hands), `trans (N, 3)` in metres,
    ///   `mocap_framerate` or `mocap_frame_rate`.
    /// - SMPL-X: `global_orient (N, 3)`, `body_pose (N, 63 | 69)`, `transl (N, 3)`.
    ///
    /// Of wider skeletons the 22 joints that all share are taken; SMPL's two hand joints stay at rest.
    /// `frames_per_second` overrides the file's rate and must be given where the file has none.
    pub fn read(bytes: &[u8], name: &str, frames_per_second: Option<f32>) -> Result<Self, ReadError> {
        Self::read_within(bytes, name, frames_per_second, MemoryLimit::default())
    }

    /// [`Self::read`] with another limit of memory.
    pub fn read_within(
        bytes: &[u8],
        name: &str,
        frames_per_second: Option<f32>,
        limit: MemoryLimit,
    ) -> Result<Self, ReadError> {
        let mut archive = Archive::open_within(bytes, name, limit)?;
        let mut notes = Vec::new();
        let angles = read_angles(&mut archive, &mut notes)?;
        let translations = read_translations(&mut archive, angles.len(), &mut notes)?;
        let frames_per_second = read_rate(&mut archive, name, frames_per_second)?;
        let poses = angles.iter().zip(translations);
        let poses = poses.map(|(angles, translation)| Pose::from_axis_angle(angles, translation)).collect();
        Ok(Self { poses, frames_per_second, notes })
    }
}

/// Axis-angle numbers of SMPL's joints.
type Angles = [f32; 3 * SMPL_JOINT_COUNT];

/// One set of numbers a frame.
struct Rows {
    width: usize,
    numbers: Vec<f32>,
}

impl Rows {
    /// Angles of at least one frame; dimensions after the first count as one.
    fn angles(field: &Field, widths: &[usize]) -> Result<Self, ReadError> {
        let width = field.shape().get(1..).unwrap_or_default().iter().product();
        if !widths.contains(&width) {
            let widths = widths.iter().map(ToString::to_string).collect::<Vec<_>>().join(" or ");
            return Err(field.wrong_shape(format_args!("(N, {widths})")));
        }
        let numbers = field.finite_numbers()?;
        if numbers.is_empty() {
            return Err(field.error("at least one frame", "none"));
        }
        match numbers.iter().find(|x| x.abs() > LARGEST_ANGLE) {
            Some(large) => Err(field.error(format!("angles of at most {LARGEST_ANGLE} rad"), large.to_string())),
            None => Ok(Self { width, numbers }),
        }
    }

    fn frames(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.numbers.chunks_exact(self.width)
    }
}

fn read_angles(archive: &mut Archive, notes: &mut Vec<String>) -> Result<Vec<Angles>, ReadError> {
    if let Some(field) = archive.optional("smpl_poses")? {
        let rows = Rows::angles(&field, &[72])?;
        return Ok(rows.frames().map(|frame| joined(&[frame])).collect());
    }
    if let Some(field) = archive.optional("poses")? {
        let rows = Rows::angles(&field, &[66, 72, 156, 165])?;
        let skeleton = match rows.width {
            66 => "22 joints",
            156 => "SMPL-H's 52 joints",
            165 => "SMPL-X's 55 joints",
            _ => return Ok(rows.frames().map(|frame| joined(&[frame])).collect()),
        };
        notes.push(shared_joints_note(skeleton));
        return Ok(rows.frames().map(|frame| joined(&[&frame[..3 * SHARED_JOINT_COUNT]])).collect());
    }
    let (Some(root), Some(body)) = (archive.optional("global_orient")?, archive.optional("body_pose")?) else {
        return Err(archive.missing("smpl_poses, poses, or global_orient and body_pose"));
    };
    let root_rows = Rows::angles(&root, &[3])?;
    let body_rows = Rows::angles(&body, &[63, 69])?;
    if root_rows.frames().len() != body_rows.frames().len() {
        let expected = format!("{} frames as in {}", body_rows.frames().len(), body.name());
        return Err(root.error(expected, root_rows.frames().len().to_string()));
    }
    if body_rows.width == 63 {
        notes.push(shared_joints_note("a root and 21 body joints"));
    }
    Ok(root_rows.frames().zip(body_rows.frames()).map(|(root, body)| joined(&[root, body])).collect())
}

fn shared_joints_note(skeleton: &str) -> String {
    format!("{skeleton} mapped to SMPL's 24: the first {SHARED_JOINT_COUNT} taken, the two hand joints at rest")
}

/// Parts one after the other, then zeros.
fn joined(parts: &[&[f32]]) -> Angles {
    let mut angles = [0.0; 3 * SMPL_JOINT_COUNT];
    for (to, &from) in angles.iter_mut().zip(parts.iter().copied().flatten()) {
        *to = from;
    }
    angles
}

/// Root translations in metres.
fn read_translations(
    archive: &mut Archive,
    frame_count: usize,
    notes: &mut Vec<String>,
) -> Result<Vec<Vec3>, ReadError> {
    let mut found = None;
    for name in ["smpl_trans", "trans", "transl"] {
        found = found.or(archive.optional(name)?);
    }
    let Some(field) = found else {
        notes.push("no translation in the file: the root stays at its rest position".to_owned());
        return Ok(vec![Vec3::ZERO; frame_count]);
    };
    if field.rows_of(3)? != frame_count {
        let expected = format!("{frame_count} frames as there are poses");
        return Err(field.error(expected, field.shape()[0].to_string()));
    }
    let units_per_metre = read_scaling(archive, field.name(), notes)?;
    let numbers = field.finite_numbers()?;
    let points: Vec<Vec3> = numbers.chunks_exact(3).map(|p| Vec3::from_slice(p) / units_per_metre).collect();
    match points.iter().find(|point| !point.is_finite()) {
        Some(_) => Err(field.error("finite 32-bit numbers", "an overflow after scaling")),
        None => Ok(points),
    }
}

/// AIST++ keeps translations in units of its own: this many to a metre.
fn read_scaling(archive: &mut Archive, translation_name: &str, notes: &mut Vec<String>) -> Result<f32, ReadError> {
    if translation_name != "smpl_trans" {
        return Ok(1.0);
    }
    let Some(field) = archive.optional("smpl_scaling")? else {
        notes.push("no smpl_scaling in the file: smpl_trans taken as metres".to_owned());
        return Ok(1.0);
    };
    let scaling = field.single_number()?;
    if scaling > 0.0 { Ok(scaling) } else { Err(field.error("a positive number", scaling.to_string())) }
}

fn read_rate(archive: &mut Archive, file: &str, given: Option<f32>) -> Result<f32, ReadError> {
    let wrong = |field: &str, found: String| ReadError {
        file: file.to_owned(),
        field: field.to_owned(),
        expected: format!("frames a second from {} to {}", RATES.start(), RATES.end()),
        found,
    };
    if let Some(rate) = given {
        return if RATES.contains(&rate) { Ok(rate) } else { Err(wrong("frames_per_second", rate.to_string())) };
    }
    for name in RATE_NAMES {
        if let Some(field) = archive.optional(name)? {
            let rate = field.single_number()?;
            return if RATES.contains(&rate) { Ok(rate) } else { Err(wrong(name, rate.to_string())) };
        }
    }
    Err(wrong("frames_per_second", "none in the file: the rate must be given".to_owned()))
}
