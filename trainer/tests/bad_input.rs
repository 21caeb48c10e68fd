//! Bad sequences are refused, by file, field, expected and found.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, FRAME_COUNT, npz, open, write_body, write_sequence};
use crease::numpy::{Array, ReadError};
use std::fs;
use std::path::Path;

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
