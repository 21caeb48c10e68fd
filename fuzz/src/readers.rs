//! Readers: whatever the bytes, a sound value or an error that says what is wrong, in memory that the file's size bounds.

use crate::allocation::{allowance, peak};
use crate::containers;
use crease::animate::Animator;
use crease::avatar::{Avatar, AvatarError};
use crease::body::Body;
use crease::memory::MemoryLimit;
use crease::mesh::Subdivision;
use crease::motion::Motion;
use crease::numpy::{Archive, ReadError};
use crease_trainer::checkpoint::{Keep, Record};
use crease_trainer::config::RunConfig;
use crease_trainer::ply::PointCloud;
use crease_trainer::scan_file::{decode_scan, sampled};
use crease_trainer::sequence::{Camera, Description, ImageFile, decode_frame};
use crease_trainer::targets::Target;
use glam::Vec3A;
use std::sync::Arc;

const FILE: &str = "stranger";

/// Points drawn from meshes.
const SAMPLED: usize = 16;

/// Vertices of the finest level up to which an avatar is animated too.
const ANIMATED: usize = 4096;

/// Runs `read` and checks its memory.
fn bounded<T>(bytes: &[u8], read: impl FnOnce() -> T) -> T {
    let (result, peak) = peak(read);
    assert!(peak <= allowance(bytes.len()), "{peak} bytes held for a file of {}", bytes.len());
    result
}

fn says_what_is_wrong(file: &str, field: &str, expected: &str) {
    assert!(file == FILE && !field.is_empty() && !expected.is_empty(), "{file}: {field}: expected {expected}");
}

fn sound<T>(result: Result<T, ReadError>) -> Option<T> {
    result.inspect_err(|error| says_what_is_wrong(&error.file, &error.field, &error.expected)).ok()
}

pub fn avatar(bytes: &[u8]) {
    let sound = |error: &AvatarError| says_what_is_wrong(&error.file, &error.field, &error.expected);
    let Ok(avatar) = bounded(bytes, || Avatar::read(bytes, FILE).inspect_err(sound)) else { return };
    let written = avatar.write();
    let again = Avatar::read(&written, "written").expect("what was read can be written and read again");
    assert_eq!(again.triangles, avatar.triangles);
    assert_eq!(again.write(), written, "writing settles after one time");
    let finest = Subdivision::new(avatar.rig.rest.len(), &avatar.triangles, avatar.level_count as usize);
    if finest.vertex_count(finest.level_count()) <= ANIMATED
        && let Ok(mut animator) = Animator::new(Arc::new(avatar))
    {
        animator.animate(&crease::body::Pose::rest(24), &crease::animate::Options::default());
    }
}

pub fn motion(bytes: &[u8]) {
    for rate in [None, Some(30.0)] {
        let Some(motion) = bounded(bytes, || sound(Motion::read(bytes, FILE, rate))) else { continue };
        let duration = motion.duration();
        assert!(!motion.poses.is_empty() && duration.is_finite() && duration >= 0.0);
        for seconds in [0.0, 0.3 * duration, duration, 1.7 * duration, -1.0, f32::NAN] {
            for pose in [motion.sample(seconds), motion.sample_looped(seconds)] {
                assert_eq!(pose.rotations.len(), 24);
                assert!(pose.translation.is_finite() && pose.rotations.iter().all(|q| q.is_normalized()), "{pose:?}");
            }
        }
    }
}

pub fn body(bytes: &[u8]) {
    let Some(body) = bounded(bytes, || sound(Body::read(bytes, FILE))) else { return };
    let count = body.template.len();
    assert!(body.triangles.iter().flatten().all(|&vertex| (vertex as usize) < count));
    assert_eq!((body.skin.joints.len(), body.skin.weights.len()), (count, count));
    let rig = body.shaped(&[1.0, -1.0]);
    assert_eq!((rig.rest.len(), rig.rest_joints.len()), (count, body.parents.len()));
}

pub fn arrays(bytes: &[u8]) {
    bounded(bytes, || {
        let Some(mut archive) = sound(Archive::open(bytes, FILE)) else { return };
        for name in archive.names().into_iter().take(64) {
            let Some(Some(field)) = sound(archive.optional(&name)) else { continue };
            let count = field.shape().iter().product::<usize>();
            assert_eq!(field.array().elements.len(), count);
            sound(field.finite_numbers());
            sound(field.indices(10, "ten"));
            sound(field.single_number());
            sound(field.texts().map(|texts| texts.len()));
        }
    });
}

pub fn ply(bytes: &[u8]) {
    scan(bytes, "ply");
}

pub fn obj(bytes: &[u8]) {
    scan(bytes, "obj");
}

pub fn scan_npz(bytes: &[u8]) {
    scan(bytes, "npz");
}

fn scan(bytes: &[u8], ending: &str) {
    let Some(cloud) = bounded(bytes, || sound(decode_scan(bytes, ending, FILE))) else { return };
    is_sound(&cloud);
    assert!(cloud.triangles.iter().flatten().all(|&vertex| (vertex as usize) < cloud.points.len()));
    is_sound(&sampled(&cloud, SAMPLED));
}

fn is_sound(cloud: &PointCloud) {
    let count = cloud.points.len();
    assert!(count > 0 && cloud.points.iter().all(|point| point.is_finite()));
    assert!(cloud.normals.as_ref().is_none_or(|normals| normals.len() == count));
    assert!(cloud.colours.as_ref().is_none_or(|colours| colours.len() == count));
}

pub fn depth(bytes: &[u8]) {
    let Some((camera, depth, colour)) = containers::split_view(bytes) else { return };
    let image = |bytes| ImageFile { name: FILE, bytes };
    let Some(camera) = bounded(bytes, || sound(Camera::decode(camera, FILE))) else { return };
    let colour = Some(colour).filter(|colour| !colour.is_empty()).map(image);
    let Some(frame) = bounded(bytes, || sound(decode_frame(&camera, 0, image(depth), colour, MemoryLimit::default())))
    else {
        return;
    };
    let count = frame.points.len();
    assert!(count > 0 && frame.points.iter().all(|point| point.is_finite()));
    assert!(frame.normals.is_some_and(|normals| normals.len() == count && normals.iter().all(|n| n.is_finite())));
    assert!(frame.weights.len() == count && frame.weights.iter().all(|weight| (0.0..).contains(weight)));
    assert!(frame.colours.is_none_or(|colours| colours.len() == count));
}

pub fn sequence(bytes: &[u8]) {
    let Some(description) = bounded(bytes, || sound(Description::read(bytes, FILE))) else { return };
    assert!(description.frame_count > 0 && description.fps > 0.0 && description.fps.is_finite());
}

pub fn run(bytes: &[u8]) {
    let Ok(config) = bounded(bytes, || RunConfig::parse(bytes, FILE)) else { return };
    let text = config.to_text().expect("what was read can be written");
    let again = RunConfig::parse(text.as_bytes(), FILE).expect("and read again");
    // Numbers that are none differ from themselves.
    assert_eq!(format!("{again:?}"), format!("{config:?}"));
    config.command();
}

pub fn checkpoint(bytes: &[u8]) {
    let Some(record) = bounded(bytes, || sound(Record::read(bytes, FILE))) else { return };
    assert_eq!(record.write(), bytes, "every byte counts");
    bounded(bytes, || {
        Vec::<Vec3A>::from_bytes(record.result);
        Vec::<Target>::from_bytes(record.result);
    });
}
