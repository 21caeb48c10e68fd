//! Bad sequences are refused, by file, field, expected and found.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, FRAME_COUNT, npz, open, ply, write_body, write_body_model, write_sequence};
use crease::numpy::{Array, ReadError};
use glam::Vec3A;
use std::fs;
use std::path::Path;
use std::process::Command;

fn sequence(name: &str) -> Directory {
    let directory = Directory::new(name);
    write_sequence(&directory.0);
    directory
}

fn describe(directory: &Path, from: &str, to: &str) -> ReadError {
    let path = directory.join("sequence.json");
    let good = fs::read_to_string(&path).unwrap();
    assert!(good.contains(from));
    fs::write(&path, good.replace(from, to)).unwrap();
    let error = open(directory).unwrap_err();
    fs::write(&path, good).unwrap();
    error
}

#[test]
fn a_good_sequence_opens() {
    let directory = sequence("good");
    let sequence = open(&directory.0).unwrap();
    assert_eq!(
        (sequence.capture.name.as_str(), sequence.capture.frame_count, sequence.poses.len()),
        ("bumpy", FRAME_COUNT, FRAME_COUNT)
    );
    let scan = sequence.capture.scan(2).unwrap();
    assert_eq!((scan.index, scan.points.len()), (2, 4_000));
    assert_eq!(scan.colours.unwrap().len(), 4_000);
    let truth = sequence.capture.ground_truth(2).unwrap();
    assert_eq!(truth.points.len(), truth.normals.len());
    assert!(truth.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-3));
}

#[test]
fn descriptions_are_checked() {
    let directory = sequence("description");
    let check = |from, to, field: &str| {
        let error = describe(&directory.0, from, to);
        assert!(error.file.ends_with("sequence.json"), "{error}");
        assert_eq!(error.field, field, "{error}");
    };
    check("\"frame_count\": 6", "\"frame_count\": 0", "frame_count");
    check("\"fps\": 15", "\"fps\": -1", "fps");
    check("metre", "inch", "units");
    check("\"up\": \"y\"", "\"up\": \"w\"", "up");
    check("\"up\": \"y\"", "\"poses_up\": \"+y\"", "poses_up");
    check("\"up\": \"y\"", "\"mirrored\": \"-x\"", "mirrored");
    check("\"up\": \"y\"", "\"normals\": \"away\"", "normals");
    check("\"name\": \"bumpy\",", "", "JSON");
    assert!(open(&directory.0.join("nowhere")).unwrap_err().file.ends_with("sequence.json"));
}

#[test]
fn bodies_are_checked() {
    let directory = sequence("body");
    write_body(&directory.0, FRAME_COUNT - 1);
    let error = open(&directory.0).unwrap_err();
    assert!(error.file.ends_with("body.npz") && error.field == "poses", "{error}");
    let arrays = [
        ("betas", Array::new(&[1], vec![f32::NAN])),
        ("poses", Array::new(&[FRAME_COUNT, 72], vec![0f32; 72 * FRAME_COUNT])),
        ("trans", Array::new(&[FRAME_COUNT, 3], vec![0f32; 3 * FRAME_COUNT])),
    ];
    fs::write(directory.0.join("body.npz"), npz(&arrays)).unwrap();
    assert_eq!(open(&directory.0).unwrap_err().field, "betas");
    fs::write(directory.0.join("body.npz"), npz(&arrays[1..])).unwrap();
    assert_eq!(open(&directory.0).unwrap_err().field, "betas");
}

#[test]
fn frames_are_checked() {
    let directory = sequence("frames");
    let sequence = open(&directory.0).unwrap();
    assert_eq!(sequence.capture.scan(FRAME_COUNT).unwrap_err().field, "frame");
    fs::write(directory.0.join("frames/0001.ply"), b"ply\nformat ascii 1.0\n").unwrap();
    assert!(sequence.capture.scan(1).unwrap_err().file.ends_with("0001.ply"));
    fs::remove_file(directory.0.join("frames/0003.ply")).unwrap();
    assert!(sequence.capture.scan(3).unwrap_err().file.ends_with("0003.ply"));

    let truth = directory.0.join("ground_truth/0000.npz");
    let points = |count: usize| Array::new(&[count, 3], vec![0f32; 3 * count]);
    fs::write(&truth, npz(&[("points", points(3)), ("normals", points(2))])).unwrap();
    let error = sequence.capture.ground_truth(0).unwrap_err();
    assert!(error.file.ends_with("0000.npz") && error.field == "normals", "{error}");
    fs::write(&truth, npz(&[("points", points(0)), ("normals", points(0))])).unwrap();
    assert_eq!(sequence.capture.ground_truth(0).unwrap_err().field, "points");

    fs::write(
        directory.0.join("sequence.json"),
        r#"{"name": "bare", "fps": 15, "frame_count": 6, "capture": {"kind": "none"}}"#,
    )
    .unwrap();
    let bare = open(&directory.0).unwrap();
    assert_eq!(bare.capture.scan(0).unwrap_err().field, "capture.kind");
    assert!(bare.capture.ground_truth(2).is_ok(), "ground truth needs no scans");
}

/// Runs the trainer; gives what it said on standard error if it failed.
fn crease(directory: &Path, arguments: &[&str]) -> Result<(), String> {
    let output = Command::new(env!("CARGO_BIN_EXE_crease")).args(arguments).current_dir(directory).output().unwrap();
    output.status.success().then_some(()).ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn scans_that_lie_otherwise_are_refused_before_any_work_is_done() {
    let directory = Directory::new("misplaced");
    let body = write_sequence(&directory.0.join("bumpy"));
    write_body_model(&directory.0.join("model.npz"), &body);
    let scans: Vec<Vec<Vec3A>> = {
        let sequence = open(&directory.0.join("bumpy")).unwrap();
        (0..FRAME_COUNT).map(|frame| sequence.capture.scan(frame).unwrap().points).collect()
    };
    let train = [
        &["train", "bumpy", "-o", "a.glb", "--body", "model.npz", "--frames", "0::5", "--quiet"][..],
        &["--set", "texture_size=16", "--set", "anchor_count=50", "--set", "compact.coarse_fit.smoothness=[60]"],
        &["--set", "compact.base_fit.smoothness=[3]", "--set", "compact.detail_fit.smoothness=[1]"],
    ]
    .concat();
    let register = ["register", "bumpy", "-o", "b.npz", "--body", "model.npz"];
    type Change = fn(Vec3A) -> Vec3A;
    let cases: [(Change, &str, bool); 3] = [
        (|p| 1000.0 * p, "\"units\": \"millimetre\"", true),
        (|p| Vec3A::new(p.x, -p.z, p.y), "\"up\": \"z\"", true),
        // Without poses nothing tells mirror images.
        (|p| Vec3A::new(-p.x, p.y, p.z), "\"mirrored\": \"x\"", false),
    ];
    for (change, way_out, register_tells) in cases {
        for (frame, points) in scans.iter().enumerate() {
            let changed: Vec<Vec3A> = points.iter().map(|&point| change(point)).collect();
            fs::write(directory.0.join(format!("bumpy/frames/{frame:04}.ply")), ply(&changed)).unwrap();
        }
        let message = crease(&directory.0, &train).unwrap_err();
        assert!(message.contains(way_out) && message.contains("--unchecked"), "{message}");
        if register_tells {
            let message = crease(&directory.0, &register).unwrap_err();
            assert!(message.contains(way_out), "{message}");
        }
        assert_eq!(fs::read_dir(&directory.0).unwrap().count(), 2, "nothing is left behind");
    }
    crease(&directory.0, &[&train[..], &["--unchecked"]].concat()).unwrap();
    assert!(directory.0.join("a.glb").exists());
}

#[test]
fn a_frame_that_cannot_be_read_has_a_way_out() {
    let directory = Directory::new("unreadable");
    let body = write_sequence(&directory.0.join("bumpy"));
    write_body_model(&directory.0.join("model.npz"), &body);
    fs::write(directory.0.join("bumpy/frames/0003.ply"), ply(&[])).unwrap();
    let train = ["train", "bumpy", "-o", "a.glb", "--body", "model.npz", "--quiet"];
    let message = crease(&directory.0, &train).unwrap_err();
    assert!(message.contains("0003.ply") && message.contains("--resume") && message.contains("--frames"), "{message}");
    assert!(!directory.0.join("a.glb").exists());
    let message = crease(&directory.0, &["register", "bumpy", "--force", "--body", "model.npz"]).unwrap_err();
    assert!(message.contains("0003.ply") && message.contains("take it out"), "{message}");
}

#[test]
fn depth_images_without_a_camera_are_refused() {
    let directory = sequence("no-camera");
    let error = describe(&directory.0, "\"pointcloud\"", "\"depth\"");
    assert!(error.file.ends_with("camera.json") && error.expected.contains("fx, fy, cx, cy"), "{error}");
}
