//! Valid inputs of every target.

use crate::Part;
use crate::animation::small_avatar;
use crate::containers::{VIEW, png};
use crease::fixture::{bent_pose, voxel_person};
use crease::numpy::{Array, Compression, write_npz};
use crease::rotation::axis_angle_from_quat;
use crease_trainer::checkpoint::{Fingerprint, Keep, Record};
use crease_trainer::targets::Target;
use glam::Vec3A;

macro_rules! fixtures {
    ($($name:literal),* $(,)?) => {
        vec![$(include_bytes!(concat!("../../tests/fixtures/pickles/", $name)).to_vec()),*]
    };
}

pub fn avatars() -> Vec<Vec<u8>> {
    (0..8u8).map(|kind| small_avatar(&mut arbitrary::Unstructured::new(&[kind; 600])).write()).collect()
}

pub fn motion_pickles() -> Vec<Vec<u8>> {
    fixtures!["motion-python2.pkl", "motion-numpy1.pkl", "motion-numpy2.pkl"]
}

pub fn body_pickles() -> Vec<Vec<u8>> {
    fixtures!["body-python2.pkl"]
}

pub fn array_pickles() -> Vec<Vec<u8>> {
    fixtures![
        "arrays-python2-protocol0.pkl",
        "arrays-python2-protocol2.pkl",
        "arrays-numpy1-protocol0.pkl",
        "arrays-numpy1-protocol2.pkl",
        "arrays-numpy1-protocol4.pkl",
        "arrays-numpy2-protocol1.pkl",
        "arrays-numpy2-protocol3.pkl",
        "arrays-numpy2-protocol5.pkl",
    ]
}

fn npz(arrays: &[(&str, Array)]) -> Vec<u8> {
    let arrays: Vec<(&str, &Array)> = arrays.iter().map(|(name, array)| (*name, array)).collect();
    write_npz(&arrays, Compression::Deflated).expect("names differ")
}

pub fn motion_archives() -> Vec<Vec<u8>> {
    let pose: Vec<f32> =
        bent_pose().rotations.iter().flat_map(|&rotation| axis_angle_from_quat(rotation).to_array()).collect();
    let frames = |width: usize| -> Array {
        let frame: Vec<f32> = pose.iter().copied().chain(std::iter::repeat(0.0)).take(width).collect();
        Array::new(&[2, width], frame.repeat(2))
    };
    let points = |value: f64| Array::new(&[2, 3], vec![value; 6]);
    vec![
        npz(&[("poses", frames(72)), ("trans", points(0.5)), ("mocap_framerate", Array::new(&[], vec![60.0f64]))]),
        npz(&[("poses", frames(156)), ("trans", points(0.5)), ("mocap_frame_rate", Array::new(&[], vec![120i64]))]),
        npz(&[("global_orient", frames(3)), ("body_pose", frames(63)), ("transl", points(1.0))]),
        npz(&[
            ("smpl_poses", frames(72)),
            ("smpl_trans", points(93.0)),
            ("smpl_scaling", Array::new(&[1], vec![93.78f64])),
        ]),
    ]
}

pub fn body_archives() -> Vec<Vec<u8>> {
    let body = voxel_person();
    let joints = body.parents.len();
    // The small one: a vertex at each joint.
    let identity: Vec<f32> = (0..joints * joints).map(|at| if at % (joints + 1) == 0 { 1.0 } else { 0.0 }).collect();
    let parents = body.parents.iter().map(|parent| parent.map_or(u32::MAX as i64, |parent| parent as i64));
    let tree: Vec<i64> = parents.chain(0..joints as i64).collect();
    let template: Vec<f32> = (0..3 * joints).map(|n| n as f32 / 100.0).collect();
    let arrays = vec![
        ("v_template", Array::new(&[joints, 3], template)),
        ("f", Array::new(&[2, 3], vec![0i64, 1, 2, 21, 22, 23])),
        ("shapedirs", Array::new(&[joints, 3, 2], vec![0.01f64; 6 * joints])),
        ("posedirs", Array::new(&[joints, 3, 207], vec![0.01f32; 3 * 207 * joints])),
        ("J_regressor", Array::new(&[joints, joints], identity.clone())),
        ("weights", Array::new(&[joints, joints], identity)),
        ("kintree_table", Array::new(&[2, joints], tree)),
        ("vt", Array::new(&[3, 2], vec![0.0f32, 0.0, 1.0, 0.0, 0.0, 1.0])),
        ("ft", Array::new(&[2, 3], vec![0u64, 1, 2, 2, 1, 0])),
        ("joint_names", Array::new(&[joints], body.joint_names.clone())),
    ];
    vec![npz(&arrays), npz(&[&arrays[..3], &arrays[4..7]].concat())]
}

pub fn plys() -> Vec<Vec<u8>> {
    let header = |format: &str, more: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment made\nelement vertex 2\nproperty float x\nproperty float y\n\
             property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n{more}end_header\n"
        )
        .into_bytes()
    };
    let point = |big: bool| -> Vec<u8> {
        let numbers = [0.5f32, 1.5, -0.25].map(|x| if big { x.to_be_bytes() } else { x.to_le_bytes() });
        [numbers.concat(), vec![200, 100, 50]].concat()
    };
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    vec![
        [header("ascii", ""), b"0.5 1.5 -0.25 200 100 50\n1 2 3 4 5 6\n".to_vec()].concat(),
        [header("binary_little_endian", ""), point(false).repeat(2)].concat(),
        [header("binary_big_endian", faces), point(true).repeat(2), vec![3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1]].concat(),
        b"ply\nformat binary_little_endian 1.0\nelement camera 1\nproperty list uchar double d\nelement vertex 1\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty float ny\nproperty float nz\nend_header\n\x01\0\0\0\0\0\0\0\0"
            .iter()
            .copied()
            .chain([0; 36])
            .collect(),
    ]
}

pub fn objs() -> Vec<Vec<u8>> {
    [
        "# a comment\no one\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 0.5 0.5 0.5\nf 1 2 3 4\n",
        "v 0 0 0\r\nv 1e0 0 0 1\r\nv 0 -1.5 0\r\nvt 0 0\r\nvn 0 0 1\r\nf -3/1/1 -2//1 3/1\r\nl 1 2\r\n",
        "v 1 2 3\n",
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

pub fn scan_archives() -> Vec<Vec<u8>> {
    let points = || Array::new(&[2, 3], vec![0.0f32, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let normals = || Array::new(&[2, 3], vec![0.0f64, 0.0, 1.0, 0.0, 1.0, 0.0]);
    vec![
        npz(&[("points", points()), ("normals", normals()), ("colors", Array::new(&[2, 3], vec![9u64; 6]))]),
        npz(&[("scan_pc", points()), ("scan_n", normals()), ("colours", Array::new(&[2, 3], vec![0.5f32; 6]))]),
    ]
}

/// Eight pixels by eight of a slanted wall.
pub fn views() -> Vec<Vec<u8>> {
    const CAMERA: &str = r#"{"width": 8, "height": 8, "fx": 10, "fy": 10, "cx": 3.5, "cy": 3.5, "depth_scale": 0.001,
        "distortion": [0, 0], "world_from_camera": [[1,0,0,0.5],[0,-1,0,1],[0,0,-1,2],[0,0,0,1]]}"#;
    let header = |depth: u8, colour: u8| [0, 0, 0, 8, 0, 0, 0, 8, depth, colour, 0, 0, 0].to_vec();
    let rows = (0..8u16).flat_map(|y| {
        let row = (0..8u16).flat_map(move |x| (1000 + 3 * x + y).to_be_bytes());
        std::iter::once(0).chain(row)
    });
    let picture = png(&header(8, 2), &[0; 8 * 25]);
    let part = |name: &str, bytes: Vec<u8>| Part { name: name.into(), bytes };
    let mut view = vec![
        part("camera.json", CAMERA.into()),
        part("header", header(16, 0)),
        part("pixels", rows.collect()),
        part("picture", picture),
    ];
    let coloured = (VIEW.close)(&view);
    view[3].bytes.clear();
    vec![coloured, (VIEW.close)(&view)]
}

pub fn sequences() -> Vec<Vec<u8>> {
    let texts = [
        r#"{"name": "bumpy", "fps": 15, "frame_count": 6, "units": "metre", "up": "y", "licence": "none needed", "capture": {"kind": "pointcloud"}, "ground_truth": {"every": 1}}"#,
        r#"{"name": "turner", "fps": 29.97, "frame_count": 75, "capture": {"kind": "depth"}}"#,
        r#"{"name": "", "fps": 1e-3, "frame_count": 1}"#,
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

pub fn runs() -> Vec<Vec<u8>> {
    use crease_trainer::config::{ChosenFrames, RunConfig};
    use crease_trainer::options::TrainOptions;
    let run = |preset: &str| RunConfig {
        output: "avatar.glb".into(),
        body: None,
        name: Some("a".into()),
        preset: preset.into(),
        sequences: vec![ChosenFrames {
            directory: "capture".into(),
            poses: None,
            reading: Default::default(),
            frames: "1::2".parse().expect("a range"),
        }],
        options: TrainOptions::preset(preset).expect("a preset"),
    };
    ["compact", "paper"].map(|preset| run(preset).to_text().expect("plain data").into_bytes()).to_vec()
}

pub fn checkpoints() -> Vec<Vec<u8>> {
    let vectors = vec![Vec3A::new(0.1, 0.2, 0.3); 3].to_bytes();
    let target = Target { canonical: Vec3A::X, mask: Default::default(), value: Vec3A::Y, weight: 1.0 };
    let targets = vec![target; 2].to_bytes();
    [vectors, targets, vec![]].iter().map(|result| Record { inputs: Fingerprint([7; 32]), result }.write()).collect()
}

/// Targets that make of any bytes something valid start from anything.
pub fn noise() -> Vec<Vec<u8>> {
    let bytes = |seed: u32| (0..800u32).map(|i| ((i.wrapping_mul(seed) >> 7) ^ i) as u8).collect();
    [2_654_435_761, 1_664_525, 22_695_477, 69_069].map(bytes).to_vec()
}
