//! Bodies from `.npz` and from SMPL's own kind of pickle.

use crate::fixtures::{BODY, PARENTS, body};
use crease::body::Body;
use crease::numpy::{Array, ReadError};
use glam::Vec3A;

#[test]
fn reads_npz() {
    let body = Body::read(&body().npz(), "body.npz").unwrap();
    assert_eq!(body.template.len(), 24);
    assert_eq!(body.template[2], Vec3A::new(0.06, 0.07, 0.08));
    assert_eq!(body.triangles, [[0, 1, 2], [21, 22, 23]]);
    assert_eq!(body.shape_directions.len(), 2);
    // shapedirs[v][axis][component] is 6 v + 2 axis + component.
    assert_eq!(body.shape_directions[1][3], Vec3A::new(19.0, 21.0, 23.0));
    assert_eq!(body.parents[0], None);
    assert!(body.parents[1..].iter().zip(&PARENTS[1..]).all(|(&ours, &parent)| ours == Some(parent as usize)));
    assert_eq!(body.joint_regressor[5], [(5, 1.0)]);
    assert_eq!((body.skin.joints[7], body.skin.weights[7]), ([7, 0, 0, 0], [1.0, 0.0, 0.0, 0.0]));
    assert_eq!(body.joint_names[15], "head");
    assert!(body.pose_directions.is_none() && body.texture_coordinates.is_none());
    assert_eq!(body.shaped(&[]).rest_joints, body.template);
}

#[test]
fn reads_smpl_pickle() {
    let (name, bytes) = BODY;
    let body = Body::read(bytes, name).unwrap();
    assert_eq!(body.template.len(), 30);
    assert_eq!(body.template[4], Vec3A::new(0.04, 0.08, 0.12));
    assert_eq!(body.triangles[27], [27, 28, 29]);
    assert_eq!(body.shape_directions.len(), 2);
    // Of four components the first two are selected: (12 v + 4 axis + component) / 1000.
    assert_eq!(body.shape_directions[1][2], Vec3A::new(0.025, 0.029, 0.033));
    assert_eq!(body.joint_regressor[23], [(23, 1.0)]);
    assert_eq!(body.parents[4], Some(1));
    // Five influences in the file: the four largest stay, of sum 0.95.
    assert_eq!(body.skin.joints[22], [22, 23, 0, 1]);
    for (weight, expected) in body.skin.weights[22].iter().zip([0.5, 0.2, 0.15, 0.1]) {
        assert!((weight - expected / 0.95).abs() < 1e-6);
    }
}

#[test]
fn reads_optional_arrays() {
    let arrays = body()
        .with("posedirs", Array::new(&[24, 3, 207], (0..24 * 3 * 207).map(f64::from).collect::<Vec<_>>()))
        .with("vt", Array::new(&[4, 2], vec![0.0f32, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]))
        .with("ft", Array::new(&[2, 3], vec![0i64, 1, 2, 1, 3, 2]))
        .with("joint_names", Array::new(&[24], (0..24).map(|n| format!("bone {n}")).collect::<Vec<_>>()));
    let body = Body::read(&arrays.npz(), "body.npz").unwrap();
    let pose_directions = body.pose_directions.unwrap();
    assert_eq!(pose_directions.len(), 207);
    assert_eq!(pose_directions[206][1], Vec3A::new(827.0, 1034.0, 1241.0));
    let texture = body.texture_coordinates.unwrap();
    assert_eq!((texture.coordinates[3], texture.triangles[1]), ([1.0, 1.0], [1, 3, 2]));
    assert_eq!(body.joint_names[23], "bone 23");
}

#[test]
fn reads_wider_skeletons_and_a_signed_root() {
    let parents: Vec<i64> = std::iter::once(-1).chain(0..54).chain(0..55).collect();
    let ones = Array::new(&[24, 55], (0..24 * 55).map(|at| f64::from(at % 55 == 54)).collect::<Vec<_>>());
    let regressor = Array::new(&[55, 24], (0..55 * 24).map(|at| f64::from(at % 24 == 0)).collect::<Vec<_>>());
    let arrays = body()
        .with("kintree_table", Array::new(&[2, 55], parents))
        .with("weights", ones)
        .with("J_regressor", regressor);
    let body = Body::read(&arrays.npz(), "body.npz").unwrap();
    assert_eq!((body.parents.len(), body.parents[54]), (55, Some(53)));
    assert_eq!(body.skin.joints[0], [54, 0, 0, 0]);
    assert_eq!(body.joint_names[22], "jaw");
}

fn error_with(name: &'static str, array: Array) -> ReadError {
    Body::read(&body().with(name, array).npz(), "body.npz").expect_err("should be refused")
}

/// The fixture's array with one number changed.
fn changed(name: &str, at: usize, value: f64) -> Array {
    let mut numbers = body().get(name).to_f64().unwrap();
    numbers[at] = value;
    Array::new(&body().get(name).shape.clone(), numbers)
}

fn zeros(shape: &[usize]) -> Array {
    Array::new(shape, vec![0.0; shape.iter().product()])
}

#[test]
fn missing_arrays_are_named() {
    for name in ["v_template", "f", "shapedirs", "J_regressor", "weights", "kintree_table"] {
        let error = Body::read(&body().without(name).npz(), "body.npz").unwrap_err();
        assert_eq!((error.file.as_str(), error.field.as_str()), ("body.npz", name));
    }
    let alone = body().with("vt", zeros(&[1, 2]));
    assert_eq!(Body::read(&alone.npz(), "body.npz").unwrap_err().field, "ft");
}

#[test]
fn shapes_must_agree() {
    for (name, shape) in [
        ("v_template", &[24, 2][..]),
        ("v_template", &[0, 3]),
        ("v_template", &[24]),
        ("f", &[2, 4]),
        ("f", &[0, 3]),
        ("shapedirs", &[23, 3, 2]),
        ("shapedirs", &[24, 3]),
        ("J_regressor", &[24, 23]),
        ("J_regressor", &[52, 24]),
        ("weights", &[24, 52]),
        ("weights", &[23, 24]),
        ("kintree_table", &[24, 2]),
        ("posedirs", &[24, 3, 216]),
        ("joint_names", &[23]),
    ] {
        let error = error_with(name, zeros(shape));
        assert_eq!(error.field, name, "{error}");
        assert!(error.found.contains("shape") || error.found == "none", "{error}");
    }
    assert_eq!(error_with("kintree_table", zeros(&[2, 23])).found, "23");
    assert_eq!(error_with("kintree_table", zeros(&[2, 300])).found, "300");
}

#[test]
fn values_must_make_sense() {
    for (name, at, value, found) in [
        ("v_template", 4, f64::NAN, "NaN at [1, 1]"),
        ("v_template", 4, 1e300, "inf at [1, 1]"),
        ("shapedirs", 7, f64::INFINITY, "inf at [1, 0, 1]"),
        ("f", 5, 24.0, "24 at [1, 2]"),
        ("f", 5, -1.0, "-1 at [1, 2]"),
        ("f", 5, 0.5, "others"),
        ("weights", 0, 0.9, "a sum of 0.9"),
        ("weights", 1, f64::NAN, "NaN at [0, 1]"),
        ("J_regressor", 1, 0.5, "a sum of 1.5"),
        ("kintree_table", 0, 0.0, "0"),
        ("kintree_table", 3, 3.0, "3"),
        ("kintree_table", 3, -1.0, "-1"),
        ("kintree_table", 25, 0.0, "0"),
    ] {
        let error = error_with(name, changed(name, at, value));
        assert_eq!((error.field.as_str(), error.found.as_str()), (name, found));
    }
    let mut weights = body().get("weights").to_f64().unwrap();
    (weights[0], weights[1]) = (1.5, -0.5);
    assert_eq!(error_with("weights", Array::new(&[24, 24], weights)).found, "-0.5");
    let text = Array::new(&[24, 3], vec!["x".to_owned(); 72]);
    assert_eq!(error_with("v_template", text).found, "text");
    assert_eq!(error_with("joint_names", zeros(&[24])).found, "numbers");
}
