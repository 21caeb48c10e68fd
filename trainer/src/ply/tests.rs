use super::*;

fn header(format: &str, vertex_count: usize) -> String {
    format!(
        "ply\nformat {format} 1.0\ncomment made by a test\nelement vertex {vertex_count}\nproperty float x\nproperty float y\n\
         property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty short quality\nend_header\n"
    )
}

const ROWS: [([f64; 3], [u8; 3]); 2] = [([0.5, -1.25, 2.0], [1, 2, 255]), ([3.0, 4.0, -5.5], [9, 8, 7])];

fn binary(big_endian: bool) -> Vec<u8> {
    let mut bytes = header(if big_endian { "binary_big_endian" } else { "binary_little_endian" }, 2).into_bytes();
    for ([x, y, z], colour) in ROWS {
        for value in [x as f32, y as f32] {
            bytes.extend(if big_endian { value.to_be_bytes() } else { value.to_le_bytes() });
        }
        bytes.extend(if big_endian { z.to_be_bytes() } else { z.to_le_bytes() });
        bytes.extend(colour);
        bytes.extend([0, 1]);
    }
    bytes
}

fn check(bytes: &[u8]) {
    let cloud = PointCloud::read(bytes, "scan.ply").unwrap();
    assert_eq!(cloud.points, [Vec3A::new(0.5, -1.25, 2.0), Vec3A::new(3.0, 4.0, -5.5)]);
    assert_eq!(cloud.colours, Some(vec![[1, 2, 255], [9, 8, 7]]));
    assert_eq!(cloud.normals, None);
}

#[test]
fn the_three_encodings_say_the_same() {
    check(&binary(false));
    check(&binary(true));
    let mut text = header("ascii", 2);
    for ([x, y, z], [r, g, b]) in ROWS {
        text += &format!("{x} {y} {z} {r} {g} {b} 12\n");
    }
    check(text.as_bytes());
}

#[test]
fn lists_and_elements_before_the_vertices_are_skipped() {
    let text = "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_indices\nelement vertex 1\nproperty float x\n\
                property list uchar float extra\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n\
                property float nz\nend_header\n3 0 0 0\n4 0 0 0 0\n1 2 7 7 2 3 0 0 1\n";
    let cloud = PointCloud::read(text.as_bytes(), "mesh.ply").unwrap();
    assert_eq!(cloud.points, [Vec3A::new(1.0, 2.0, 3.0)]);
    assert_eq!(cloud.normals, Some(vec![Vec3A::Z]));
    assert_eq!(cloud.triangles.len(), 3, "a quadrangle is two triangles");
}

#[test]
fn faces_of_missing_vertices_are_refused() {
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
                property list uchar int vertex_indices\nend_header\n0 0 0\n";
    for face in ["3 0 0 1\n", "3 0 0 -1\n"] {
        let error = PointCloud::read((text.to_owned() + face).as_bytes(), "mesh.ply").unwrap_err();
        assert!(error.field.contains("face"), "{error}");
    }
}

#[test]
fn float_colours_are_fractions() {
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nproperty float red\n\
                property float green\nproperty float blue\nend_header\n0 0 0 0 0.5 1\n";
    let cloud = PointCloud::read(text.as_bytes(), "cloud.ply").unwrap();
    assert_eq!(cloud.colours, Some(vec![[0, 128, 255]]));
}

fn refusal(bytes: &[u8]) -> ReadError {
    let error = PointCloud::read(bytes, "bad.ply").unwrap_err();
    assert_eq!(error.file, "bad.ply");
    error
}

#[test]
fn bad_files_are_named() {
    assert_eq!(refusal(header("ascii", 0).as_bytes()).found, "0");
    assert_eq!(refusal(b"").expected, "a line end_header");
    assert_eq!(refusal(b"png\n").found, "png");
    assert!(refusal(b"ply\nformat ascii 1.0\nelement face 0\nend_header\n").expected.contains("vertex"));
    assert!(
        refusal(b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n")
            .expected
            .contains("x, y, z")
    );
    assert!(refusal(b"ply\nelement vertex 1\nend_header\n").expected.contains("format"));
    assert!(refusal(b"ply\nformat ascii 1.0\nproperty float x\n").expected.contains("element"));
    assert!(refusal(b"ply\nformat ascii 1.0\nelement vertex 1\nproperty text x\n").expected.contains("known type"));
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = binary(false);
    for length in 0..bytes.len() {
        refusal(&bytes[..length]);
    }
}

#[test]
fn a_huge_count_allocates_nothing() {
    let error = refusal(header("binary_little_endian", usize::MAX / 2).as_bytes());
    assert!(error.expected.contains("for each of"), "{error}");
    let text = format!("ply\nformat ascii 1.0\nelement nothing {}\nend_header\n", u64::MAX);
    assert!(refusal(text.as_bytes()).expected.contains("for each of"));
}

#[test]
fn a_coordinate_that_is_not_finite_is_named() {
    let text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n0 nan 0\n";
    let error = refusal(text.as_bytes());
    assert_eq!((error.field.as_str(), error.expected.as_str()), ("vertex 1", "finite coordinates"));
}
