//! An animated GLB: a skinned figure, its bones' motion, its texture, and the normal map of its wrinkles.

use super::baked::BakedFigure;
use crease::avatar::{Avatar, Glb};
use crease::motion::Motion;
use glam::{Mat4, Quat, Vec3, Vec3A};
use serde_json::{Value, json};

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The file's bytes: `figure`, baked of `avatar`, moving as `motion` does. Rotations between frames are spherical, the root's path straight.
pub fn skinned_glb(avatar: &Avatar, figure: &BakedFigure, motion: &Motion) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let (rig, appearance) = (&avatar.rig, &avatar.appearance);
    let joint_count = rig.parents.len();

    let vectors = |values: &[Vec3A]| values.iter().flat_map(|value| value.to_array()).collect::<Vec<f32>>();
    let corners: Vec<u8> =
        appearance.drawn_triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()).collect();
    let count = 3 * appearance.drawn_triangles.len();
    let indices = buffer.accessor(&corners, Some(ELEMENT_ARRAY_BUFFER), UNSIGNED_INT, "SCALAR", count);
    let position = buffer.floats(&vectors(&figure.positions), Some(ARRAY_BUFFER), "VEC3");
    let bound = |start: Vec3A, pick: fn(Vec3A, Vec3A) -> Vec3A| figure.positions.iter().copied().fold(start, pick);
    buffer.accessors[position]["min"] = json!(bound(Vec3A::INFINITY, Vec3A::min).to_array());
    buffer.accessors[position]["max"] = json!(bound(Vec3A::NEG_INFINITY, Vec3A::max).to_array());
    let vertices = &appearance.drawn_vertices;
    let joints: Vec<u8> = vertices
        .iter()
        .flat_map(|&vertex| {
            let (joints, weights) = (rig.skin.joints[vertex as usize], rig.skin.weights[vertex as usize]);
            std::array::from_fn::<u8, 4, _>(|i| if weights[i] > 0.0 { joints[i] } else { 0 })
        })
        .collect();
    let weights: Vec<f32> = vertices.iter().flat_map(|&vertex| rig.skin.weights[vertex as usize]).collect();
    let mut attributes = json!({
        "POSITION": position,
        "NORMAL": buffer.floats(&vectors(&figure.normals), Some(ARRAY_BUFFER), "VEC3"),
        "JOINTS_0": buffer.accessor(&joints, Some(ARRAY_BUFFER), UNSIGNED_BYTE, "VEC4", vertices.len()),
        "WEIGHTS_0": buffer.floats(&weights, Some(ARRAY_BUFFER), "VEC4"),
    });
    let mut material = json!({ "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.9 } });
    let (mut textures, mut images) = (Vec::new(), Vec::new());
    let mut picture = |buffer: &mut Buffer, bytes: &[u8], mime: &str| {
        images.push(json!({ "bufferView": buffer.view(bytes, None), "mimeType": mime }));
        textures.push(json!({ "source": images.len() - 1 }));
        json!({ "index": textures.len() - 1 })
    };
    if !appearance.texture_coordinates.is_empty() {
        let coordinates = appearance.texture_coordinates.as_flattened();
        attributes["TEXCOORD_0"] = json!(buffer.floats(coordinates, Some(ARRAY_BUFFER), "VEC2"));
    } else if !appearance.vertex_colours.is_empty() {
        let colours: Vec<u8> = appearance.vertex_colours.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        let accessor = buffer.accessor(&colours, Some(ARRAY_BUFFER), UNSIGNED_BYTE, "VEC4", vertices.len());
        buffer.accessors[accessor]["normalized"] = json!(true);
        attributes["COLOR_0"] = json!(accessor);
    }
    if let Some(texture) = &appearance.texture {
        material["pbrMetallicRoughness"]["baseColorTexture"] = picture(&mut buffer, &texture.bytes, &texture.mime);
    }
    if let Some(map) = &figure.normal_map {
        attributes["TANGENT"] = json!(buffer.floats(figure.tangents.as_flattened(), Some(ARRAY_BUFFER), "VEC4"));
        material["normalTexture"] = picture(&mut buffer, map, "image/png");
    }
    let inverse_bind: Vec<f32> =
        rig.rest_joints.iter().flat_map(|&joint| Mat4::from_translation(-Vec3::from(joint)).to_cols_array()).collect();
    let inverse_bind = buffer.floats(&inverse_bind, None, "MAT4");
    let mut nodes: Vec<Value> = (0..joint_count)
        .map(|joint| {
            let origin = rig.parents[joint].map_or(Vec3A::ZERO, |parent| rig.rest_joints[parent]);
            let children: Vec<usize> = (0..joint_count).filter(|&child| rig.parents[child] == Some(joint)).collect();
            let mut node =
                json!({ "name": rig.joint_names[joint], "translation": (rig.rest_joints[joint] - origin).to_array() });
            // glTF has no empty lists.
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            node
        })
        .collect();
    nodes.push(json!({ "name": avatar.name, "mesh": 0, "skin": 0 }));
    let animation = animation(rig.rest_joints[0].into(), motion, joint_count, &mut buffer);
    let mut document = json!({
        "asset": { "version": "2.0", "generator": format!("crease {}", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0, joint_count] }],
        "nodes": nodes,
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }],
        "skins": [{ "inverseBindMatrices": inverse_bind, "joints": (0..joint_count).collect::<Vec<_>>(), "skeleton": 0 }],
        "materials": [material],
        "animations": [animation],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    if !images.is_empty() {
        document["images"] = json!(images);
        document["textures"] = json!(textures);
    }
    Glb::assemble(document.to_string().into_bytes(), buffer.bytes)
}

/// A rotation for each joint in each frame, and the root's place.
fn animation(root: Vec3, motion: &Motion, joint_count: usize, buffer: &mut Buffer) -> Value {
    let times: Vec<f32> = (0..motion.poses.len()).map(|frame| frame as f32 / motion.frames_per_second).collect();
    let input = buffer.floats(&times, None, "SCALAR");
    buffer.accessors[input]["min"] = json!([times[0]]);
    buffer.accessors[input]["max"] = json!([times[times.len() - 1]]);
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    let mut channel = |node: usize, path: &str, output: usize| {
        channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
        samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
    };
    let path: Vec<f32> = motion.poses.iter().flat_map(|pose| (root + pose.translation).to_array()).collect();
    channel(0, "translation", buffer.floats(&path, None, "VEC3"));
    for joint in 0..joint_count {
        let mut last = Quat::IDENTITY;
        let rotations: Vec<f32> = motion
            .poses
            .iter()
            .flat_map(|pose| {
                // Of the two quaternions of a rotation the one nearer to the last, or viewers go the long way round.
                let rotation = pose.rotations[joint].normalize();
                last = if rotation.dot(last) < 0.0 { -rotation } else { rotation };
                last.to_array()
            })
            .collect();
        channel(joint, "rotation", buffer.floats(&rotations, None, "VEC4"));
    }
    json!({ "name": "motion", "samplers": samplers, "channels": channels })
}

/// The binary chunk as it grows, and the JSON of what lies in it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// A new buffer view, on a multiple of four.
    fn view(&mut self, data: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": data.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.bytes.extend(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, data: &[u8], target: Option<u32>, component: u32, shape: &str, count: usize) -> usize {
        let view = self.view(data, target);
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "type": shape, "count": count }));
        self.accessors.len() - 1
    }

    fn floats(&mut self, numbers: &[f32], target: Option<u32>, shape: &str) -> usize {
        let width = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(bytemuck::cast_slice(numbers), target, FLOAT, shape, numbers.len() / width)
    }
}
