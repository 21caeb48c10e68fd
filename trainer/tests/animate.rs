//! `crease animate` into one file, read by others: USD as text, GLB by the crate `gltf`.

#[allow(dead_code, reason = "other tests use the rest")]
mod common;

use common::{Directory, npz};
use crease::animate::{Options, animate};
use crease::avatar::Avatar;
use crease::body::posed_from_rest;
use crease::fixture::plain_avatar;
use crease::motion::Motion;
use crease::numpy::Array;
use glam::{Mat4, Quat, Vec3, Vec3A};
use gltf::animation::util::ReadOutputs;
use std::fs;
use std::path::Path;
use std::process::Command;

const FRAME_COUNT: usize = 4;

/// An avatar and a motion: it turns round, and an arm sinks.
fn prepare(name: &str) -> (Directory, Avatar, Motion) {
    let directory = Directory::new(name);
    let mut avatar = plain_avatar();
    // Viewers stop where a picture ends.
    avatar.appearance.texture.as_mut().unwrap().bytes.extend([0; 4]);
    let bytes = avatar.write();
    fs::write(directory.0.join("avatar.glb"), &bytes).unwrap();
    let mut poses = vec![0f32; 72 * FRAME_COUNT];
    for (frame, angles) in poses.chunks_exact_mut(72).enumerate() {
        angles[1] = 1.5 * frame as f32;
        angles[3 * 16 + 2] = -0.3 * frame as f32;
    }
    let path: Vec<f32> = (0..FRAME_COUNT).flat_map(|frame| [0.1 * frame as f32, 0.9, 0.0]).collect();
    let arrays = [
        ("poses", Array::new(&[FRAME_COUNT, 72], poses)),
        ("trans", Array::new(&[FRAME_COUNT, 3], path)),
        ("mocap_framerate", Array::new(&[], vec![30f64])),
    ];
    let motion = npz(&arrays);
    fs::write(directory.0.join("turn.npz"), &motion).unwrap();
    (directory, Avatar::read(&bytes, "avatar").unwrap(), Motion::read(&motion, "turn", None).unwrap())
}

fn crease(directory: &Path, arguments: &[&str]) -> Result<(), String> {
    let output = Command::new(env!("CARGO_BIN_EXE_crease"))
        .args(["animate", "avatar.glb", "turn.npz"])
        .args(arguments)
        .current_dir(directory)
        .output()
        .unwrap();
    output.status.success().then_some(()).ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The vectors of the sample `frame` of an attribute.
fn sample(text: &str, attribute: &str, frame: usize) -> Vec<Vec3A> {
    let samples = text.split(&format!("{attribute}.timeSamples = {{")).nth(1).unwrap().split('}').next().unwrap();
    let line = samples.lines().find(|line| line.trim_start().starts_with(&format!("{frame}: "))).unwrap();
    let list = line.split('[').nth(1).unwrap().split(']').next().unwrap();
    let vector = |text: &str| {
        let numbers: Vec<f32> = text.trim_matches(['(', ')']).split(", ").map(|n| n.parse().unwrap()).collect();
        Vec3A::from_slice(&numbers)
    };
    list.split("), ").map(vector).collect()
}

#[test]
fn usd_has_the_mesh_of_every_frame() {
    let (directory, avatar, motion) = prepare("usda");
    crease(&directory.0, &["-o", "turn.usda", "--format", "usda"]).unwrap();
    let text = fs::read_to_string(directory.0.join("turn.usda")).unwrap();
    for expected in
        ["#usda 1.0\n", "metersPerUnit = 1\n", "upAxis = \"Y\"", "endTimeCode = 3\n", "timeCodesPerSecond = 30\n"]
    {
        assert!(text.contains(expected), "{expected}");
    }
    assert!(text.contains("asset inputs:file = @./turn.png@"));
    assert_eq!(fs::read(directory.0.join("turn.png")).unwrap(), avatar.appearance.texture.as_ref().unwrap().bytes);
    let corners = text.split("faceVertexIndices = [").nth(1).unwrap().split(']').next().unwrap();
    let corners: Vec<usize> = corners.split(", ").map(|corner| corner.parse().unwrap()).collect();
    let mut frame = FRAME_COUNT - 1;
    let points = sample(&text, "points", frame);
    assert_eq!(
        text.split("primvars:st = [").nth(1).unwrap().split(']').next().unwrap().matches('(').count(),
        points.len()
    );
    let mesh = animate(&avatar, &motion.poses[frame], &Options::default()).unwrap();
    assert_eq!(corners.len(), 3 * mesh.triangles.len());
    for (&corner, &vertex) in corners.iter().zip(mesh.triangles.iter().flatten()) {
        assert!(points[corner].distance(mesh.positions[vertex as usize]) < 1e-4);
    }
    let [low, high] = sample(&text, "extent", frame)[..] else { panic!("two corners of a box") };
    assert!(points.iter().all(|point| point.cmpge(low).all() && point.cmple(high).all()));
    frame = 0;
    let normals = sample(&text, "normals", frame);
    assert_eq!(normals.len(), points.len());
    assert!(normals.iter().all(|normal| (normal.length() - 1.0).abs() < 2e-3));
    let left: Vec<_> = fs::read_dir(&directory.0).unwrap().flatten().map(|entry| entry.file_name()).collect();
    assert_eq!(left.len(), 4, "nothing else is left: {left:?}");
}

#[test]
fn an_animated_glb_moves_its_bones_as_the_motion_does() {
    let (directory, avatar, motion) = prepare("moving");
    crease(&directory.0, &["-o", "turn.glb"]).unwrap();
    let bytes = fs::read(directory.0.join("turn.glb")).unwrap();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let blob = file.blob.as_deref();
    let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
    let material = primitive.material();
    assert!(material.normal_texture().is_some() && material.pbr_metallic_roughness().base_color_texture().is_some());
    let reader = primitive.reader(|_| blob);
    let tangents: Vec<[f32; 4]> = reader.read_tangents().unwrap().collect();
    for ([x, y, z, sign], normal) in tangents.iter().zip(reader.read_normals().unwrap()) {
        let tangent = Vec3::new(*x, *y, *z);
        assert!(tangent.is_normalized() && tangent.dot(normal.into()).abs() < 1e-3 && sign.abs() == 1.0);
    }

    let joint_count = avatar.rig.parents.len();
    let mut rotations = vec![Vec::new(); joint_count];
    let mut path = Vec::new();
    for channel in file.animations().next().unwrap().channels() {
        let channel_reader = channel.reader(|_| blob);
        let times: Vec<f32> = channel_reader.read_inputs().unwrap().collect();
        assert_eq!(times.len(), FRAME_COUNT);
        assert!((times[3] - 0.1).abs() < 1e-6);
        match channel_reader.read_outputs().unwrap() {
            ReadOutputs::Rotations(all) => {
                let all: Vec<Quat> = all.into_f32().map(Quat::from_array).collect();
                assert!(all.windows(2).all(|pair| pair[0].dot(pair[1]) >= 0.0), "the short way round");
                rotations[channel.target().node().index()] = all;
            }
            ReadOutputs::Translations(all) => path = all.map(Vec3::from).collect(),
            _ => panic!("neither rotation nor translation"),
        }
    }
    // Skinned as glTF says it goes where the body's own skinning takes it, near the mesh of that frame.
    let frame = 2;
    let mut world: Vec<Mat4> = Vec::new();
    for (joint, node) in file.nodes().take(joint_count).enumerate() {
        let rest = Vec3::from(node.transform().decomposed().0);
        let place = if joint == 0 { path[frame] } else { rest };
        let own = Mat4::from_rotation_translation(rotations[joint][frame], place);
        world.push(avatar.rig.parents[joint].map_or(own, |parent| world[parent] * own));
    }
    let skin = file.skins().next().unwrap();
    let inverse: Vec<Mat4> =
        skin.reader(|_| blob).read_inverse_bind_matrices().unwrap().map(|m| Mat4::from_cols_array_2d(&m)).collect();
    let joints = reader.read_joints(0).unwrap().into_u16();
    let weights = reader.read_weights(0).unwrap().into_f32();
    let mesh = animate(&avatar, &motion.poses[frame], &Options::default()).unwrap();
    let transforms = posed_from_rest(&avatar.rig, &motion.poses[frame]);
    let mut distances = Vec::new();
    let vertices = reader.read_positions().unwrap().zip(joints).zip(weights).zip(&avatar.appearance.drawn_vertices);
    for (((position, joints), weights), &vertex) in vertices {
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let posed: Vec3 = (0..4)
            .map(|i| {
                weights[i] * (world[joints[i] as usize] * inverse[joints[i] as usize]).transform_point3(position.into())
            })
            .sum();
        let own = avatar.rig.skin.blend(vertex as usize, &transforms).transform_point3(position.into());
        assert!(posed.distance(own) < 1e-4, "{posed} for {own}");
        distances.push(posed.distance(mesh.positions[vertex as usize].into()));
    }
    let mean = distances.iter().sum::<f32>() / distances.len() as f32;
    assert!(mean < 0.04, "{mean} m");

    // What readers outside are shown: tests/fixtures/tiny_moving.glb is such a file.
    let fixture = fs::read("../tests/fixtures/tiny_moving.glb").unwrap();
    let fixture = gltf::Gltf::from_slice(&fixture).unwrap();
    let shape = |file: &gltf::Gltf| (file.nodes().count(), file.accessors().count(), file.animations().count());
    assert_eq!(shape(&fixture), shape(&file));
}

#[test]
fn names_and_formats_that_contradict_are_refused() {
    let (directory, ..) = prepare("contradiction");
    assert!(crease(&directory.0, &["-o", "meshes", "--format", "usda"]).unwrap_err().contains("ends in .usda"));
    assert!(crease(&directory.0, &["-o", "a.glb", "--format", "ply"]).unwrap_err().contains("name of a directory"));
    assert!(crease(&directory.0, &["-o", "a.glb", "--detail", "2"]).unwrap_err().contains("--detail"));
    crease(&directory.0, &["-o", "meshes", "--format", "glb"]).unwrap();
    assert_eq!(fs::read_dir(directory.0.join("meshes")).unwrap().count(), FRAME_COUNT);
}
