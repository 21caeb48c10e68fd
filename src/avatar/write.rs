//! Writing an avatar.

use super::deflate::pack;
use super::document::{self, Accessor, Attributes, BufferView, Document, Node};
use super::extension::{
    Extension, Factor, Function, LayerTables, MAJOR_VERSION, MINOR_VERSION, NAME, Number, RegionFacts, Table, Units,
    Version,
};
use super::glb::Glb;
use super::quantise::{half_table, quantised_weights};
use super::{Appearance, Avatar};
use crate::body::Pose;
use crate::mesh::vertex_normals;
use crate::network::{Domain, Scratch, SurfaceFunction};
use crate::pose_feature::association;
use glam::Vec3A;

impl Avatar {
    /// The avatar as a GLB. [`Avatar::read`] gives back [`Avatar::quantised`]; writing that again gives the same bytes.
    ///
    /// The avatar must pass [`Avatar::validate`].
    pub fn write(&self) -> Vec<u8> {
        let avatar = self.quantised();
        let mut buffer = BufferWriter::default();
        let (mesh, skin, material) =
            (drawn_mesh(&avatar, &mut buffer), skeleton(&avatar, &mut buffer), material(&avatar.appearance));
        let (textures, images) = texture(&avatar.appearance, &mut buffer);
        let extension = extension(&avatar, &mut buffer);
        let joint_count = avatar.rig.rest_joints.len();
        let document = Document {
            asset: document::Asset {
                version: "2.0".into(),
                generator: Some(concat!("crease ", env!("CARGO_PKG_VERSION")).into()),
            },
            extensions_used: vec![NAME.into()],
            scene: 0,
            scenes: vec![document::Scene { nodes: vec![0, joint_count] }],
            nodes: nodes(&avatar),
            meshes: vec![mesh],
            skins: vec![skin],
            materials: vec![material],
            textures,
            images,
            accessors: buffer.accessors,
            buffer_views: buffer.views,
            buffers: vec![document::Buffer { byte_length: buffer.bytes.len(), uri: None }],
            extensions: document::Extensions { avatar: extension },
        };
        let json = serde_json::to_vec(&document).expect("plain data has a JSON form");
        Glb::assemble(json, buffer.bytes)
    }
}

/// The binary chunk as it grows.
#[derive(Default)]
struct BufferWriter {
    bytes: Vec<u8>,
    views: Vec<BufferView>,
    accessors: Vec<Accessor>,
    /// Views that hold tables.
    tables: Vec<usize>,
}

impl BufferWriter {
    /// A new buffer view, on a multiple of four.
    fn view(&mut self, data: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(BufferView {
            buffer: 0,
            byte_offset: self.bytes.len(),
            byte_length: data.len(),
            byte_stride: None,
            target,
        });
        self.bytes.extend(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    /// A new accessor over a view of its own.
    fn accessor(&mut self, data: &[u8], component_type: u32, shape: &str, count: usize, target: Option<u32>) -> usize {
        let buffer_view = self.view(data, target);
        self.accessors.push(Accessor {
            buffer_view,
            byte_offset: 0,
            component_type,
            normalized: false,
            count,
            shape: shape.into(),
            min: None,
            max: None,
            is_sparse: false,
        });
        self.accessors.len() - 1
    }

    fn vertex_attribute(&mut self, data: &[u8], component_type: u32, shape: &str, count: usize) -> usize {
        self.accessor(data, component_type, shape, count, Some(document::ARRAY_BUFFER))
    }

    fn table(&mut self, data: &[u8], number: Number, shape: &[usize]) -> Table {
        debug_assert_eq!(data.len(), shape.iter().product::<usize>() * number.size());
        let packed = pack(data, number.size());
        let is_smaller = packed.len() < data.len();
        let data = if is_smaller { &packed } else { data };
        // f_d and f_l share their centres.
        let earlier = self.tables.iter().copied().find(|&view| self.bytes_of(view) == data);
        let buffer_view = earlier.unwrap_or_else(|| self.view(data, None));
        self.tables.push(buffer_view);
        Table { buffer_view, number, shape: shape.to_vec(), scale: None, packed: is_smaller }
    }

    fn bytes_of(&self, view: usize) -> &[u8] {
        let BufferView { byte_offset, byte_length, .. } = self.views[view];
        &self.bytes[byte_offset..byte_offset + byte_length]
    }

    fn floats(&mut self, values: &[f32], shape: &[usize]) -> Table {
        self.table(&float_bytes(values), Number::F32, shape)
    }

    fn halves(&mut self, values: &[f32], shape: &[usize]) -> Table {
        let (halves, scale) = half_table(values);
        let bytes: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        Table { scale: Some(scale), ..self.table(&bytes, Number::F16, shape) }
    }

    /// Indices, 16 bits each where that is enough.
    fn indices(&mut self, values: &[u32]) -> Table {
        let (bytes, wide) = index_bytes(values);
        self.table(&bytes, if wide { Number::U32 } else { Number::U16 }, &[values.len()])
    }
}

fn float_bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Little-endian indices, and whether they take 32 bits. 65535 itself does: glTF keeps it for restarting primitives.
fn index_bytes(values: &[u32]) -> (Vec<u8>, bool) {
    let wide = values.iter().any(|&value| value >= 65535);
    let bytes = if wide {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    } else {
        values.iter().flat_map(|&value| (value as u16).to_le_bytes()).collect()
    };
    (bytes, wide)
}

fn numbers(points: &[Vec3A]) -> Vec<f32> {
    points.iter().flat_map(|point| point.to_array()).collect()
}

/// The mesh that any viewer shows: the avatar's base in the rest pose.
fn drawn_mesh(avatar: &Avatar, buffer: &mut BufferWriter) -> document::Mesh {
    let Appearance { drawn_vertices, drawn_triangles, texture_coordinates, vertex_colours, .. } = &avatar.appearance;
    let (positions, normals) = resting_base(avatar);
    let drawn =
        |values: &[Vec3A]| -> Vec<f32> { drawn_vertices.iter().flat_map(|&v| values[v as usize].to_array()).collect() };
    let count = drawn_vertices.len();

    let corners: Vec<u32> = drawn_triangles.iter().flatten().copied().collect();
    let (index_data, wide) = index_bytes(&corners);
    let index_type = if wide { document::UNSIGNED_INT } else { document::UNSIGNED_SHORT };
    let indices =
        buffer.accessor(&index_data, index_type, "SCALAR", corners.len(), Some(document::ELEMENT_ARRAY_BUFFER));

    let position = buffer.vertex_attribute(&float_bytes(&drawn(&positions)), document::FLOAT, "VEC3", count);
    let smallest = positions.iter().fold(Vec3A::INFINITY, |bound, &p| bound.min(p));
    let largest = positions.iter().fold(Vec3A::NEG_INFINITY, |bound, &p| bound.max(p));
    buffer.accessors[position].min = Some(smallest.to_array());
    buffer.accessors[position].max = Some(largest.to_array());
    let normal = buffer.vertex_attribute(&float_bytes(&drawn(&normals)), document::FLOAT, "VEC3", count);

    let skin = &avatar.rig.skin;
    let joint_bytes: Vec<u8> = drawn_vertices.iter().flat_map(|&v| skin.joints[v as usize]).collect();
    let joints = buffer.vertex_attribute(&joint_bytes, document::UNSIGNED_BYTE, "VEC4", count);
    let weight_bytes: Vec<u8> = drawn_vertices
        .iter()
        .flat_map(|&v| quantised_weights(skin.weights[v as usize]))
        .flat_map(u16::to_le_bytes)
        .collect();
    let weights = buffer.vertex_attribute(&weight_bytes, document::UNSIGNED_SHORT, "VEC4", count);
    buffer.accessors[weights].normalized = true;

    let texture_coordinates = (!texture_coordinates.is_empty()).then(|| {
        let data: Vec<f32> = texture_coordinates.iter().flatten().copied().collect();
        buffer.vertex_attribute(&float_bytes(&data), document::FLOAT, "VEC2", count)
    });
    let colours = (!vertex_colours.is_empty()).then(|| {
        let data: Vec<u8> = vertex_colours.iter().flat_map(|&[r, g, b]| [r, g, b, 255]).collect();
        let accessor = buffer.vertex_attribute(&data, document::UNSIGNED_BYTE, "VEC4", count);
        buffer.accessors[accessor].normalized = true;
        accessor
    });
    let attributes = Attributes { position, normal, joints, weights, texture_coordinates, colours };
    document::Mesh { primitives: vec![document::Primitive { attributes, indices, mode: None, material: Some(0) }] }
}

/// Rest vertices plus f_d of the rest pose, and their normals.
fn resting_base(avatar: &Avatar) -> (Vec<Vec3A>, Vec<Vec3A>) {
    let rig = &avatar.rig;
    let domain = Domain::coarsest(&avatar.canonical, &rig.skin);
    let mut positions = vec![Vec3A::ZERO; rig.rest.len()];
    let rest_pose = Pose::rest(rig.rest_joints.len());
    avatar.deformation.evaluate(&domain, &rest_pose, &mut Scratch::default(), &mut positions);
    for (position, rest) in positions.iter_mut().zip(&rig.rest) {
        *position += *rest;
    }
    let mut normals = vec![Vec3A::ZERO; positions.len()];
    vertex_normals(&positions, &avatar.triangles, &mut normals);
    for normal in &mut normals {
        *normal = normal.normalize_or(Vec3A::Y);
    }
    (positions, normals)
}

/// Joint nodes under their numbers, then the mesh's node.
fn nodes(avatar: &Avatar) -> Vec<Node> {
    let rig = &avatar.rig;
    let joint_count = rig.rest_joints.len();
    let joint_nodes = (0..joint_count).map(|joint| {
        let origin = rig.parents[joint].map_or(Vec3A::ZERO, |parent| rig.rest_joints[parent]);
        Node {
            name: rig.joint_names[joint].clone(),
            children: (0..joint_count).filter(|&child| rig.parents[child] == Some(joint)).collect(),
            translation: Some((rig.rest_joints[joint] - origin).to_array()),
            ..Node::default()
        }
    });
    let mesh_node = Node { name: avatar.name.clone(), mesh: Some(0), skin: Some(0), ..Node::default() };
    joint_nodes.chain([mesh_node]).collect()
}

fn skeleton(avatar: &Avatar, buffer: &mut BufferWriter) -> document::Skin {
    let joints = &avatar.rig.rest_joints;
    let matrices: Vec<f32> = joints
        .iter()
        .flat_map(|&joint| glam::Mat4::from_translation(-glam::Vec3::from(joint)).to_cols_array())
        .collect();
    document::Skin {
        inverse_bind_matrices: buffer.accessor(&float_bytes(&matrices), document::FLOAT, "MAT4", joints.len(), None),
        joints: (0..joints.len()).collect(),
    }
}

fn material(appearance: &Appearance) -> document::Material {
    let base_color_texture = appearance.texture.as_ref().map(|_| document::TextureReference { index: 0 });
    document::Material {
        pbr_metallic_roughness: document::MetallicRoughness {
            base_color_texture,
            metallic_factor: 0.0,
            roughness_factor: 0.9,
        },
    }
}

fn texture(appearance: &Appearance, buffer: &mut BufferWriter) -> (Vec<document::TextureSource>, Vec<document::Image>) {
    match &appearance.texture {
        None => (vec![], vec![]),
        Some(texture) => {
            let buffer_view = buffer.view(&texture.bytes, None);
            (
                vec![document::TextureSource { source: 0 }],
                vec![document::Image { buffer_view, mime_type: texture.mime.clone() }],
            )
        }
    }
}

fn extension(avatar: &Avatar, buffer: &mut BufferWriter) -> Extension {
    let rig = &avatar.rig;
    let vertex_count = rig.rest.len();
    Extension {
        version: Version { major: MAJOR_VERSION, minor: MINOR_VERSION },
        name: avatar.name.clone(),
        units: Units::default(),
        mesh: 0,
        skin: 0,
        drawn_vertices: buffer.indices(&avatar.appearance.drawn_vertices),
        canonical: buffer.floats(&numbers(&avatar.canonical), &[vertex_count, 3]),
        rest: buffer.floats(&numbers(&rig.rest), &[vertex_count, 3]),
        scheme: avatar.scheme,
        level_count: avatar.level_count,
        form: avatar.form,
        association: association().to_vec(),
        deformation: function(&avatar.deformation, rig.rest_joints.len(), buffer),
        laplacian: function(&avatar.laplacian, rig.rest_joints.len(), buffer),
        anchors: buffer.indices(&avatar.anchors),
        anchor_weight: avatar.anchor_weight,
        factor: factor(avatar, buffer),
        pose_directions: rig.pose_directions.as_ref().map(|directions| {
            let values: Vec<f32> = directions.iter().flat_map(|direction| numbers(direction)).collect();
            buffer.halves(&values, &[directions.len(), vertex_count, 3])
        }),
        provenance: avatar.provenance.clone(),
    }
}

fn factor(avatar: &Avatar, buffer: &mut BufferWriter) -> Factor {
    let factor = &avatar.factor;
    let values: Vec<u8> = factor.values.iter().flat_map(|value| value.to_le_bytes()).collect();
    Factor {
        permutation: buffer.indices(&factor.permutation),
        diagonal: buffer.floats(&factor.diagonal, &[factor.diagonal.len()]),
        values: buffer.table(&values, Number::F16, &[factor.values.len()]),
    }
}

fn function(function: &SurfaceFunction, joint_count: usize, buffer: &mut BufferWriter) -> Function {
    match function {
        SurfaceFunction::Mlp(mlp) => Function::Mlp {
            level: mlp.level,
            frequency_count: mlp.encoding.frequency_count,
            output_scale: mlp.output_scale,
            layers: mlp
                .layers
                .iter()
                .map(|layer| LayerTables {
                    weight: buffer.halves(&layer.weight, &[layer.output_count(), layer.input_count()]),
                    bias: buffer.halves(&layer.bias, &[layer.output_count()]),
                })
                .collect(),
        },
        SurfaceFunction::Compact(compact) => {
            let rows = compact.row_vertices.len();
            let (steps, centres) = (compact.basis_step.len(), compact.centre_count as usize);
            let coefficients: Vec<f32> =
                compact.regions.iter().flat_map(|region| region.coefficient_from_kernel.iter().copied()).collect();
            let regions = compact.regions.iter().map(|region| RegionFacts {
                mask: region.mask,
                rows: region.rows,
                basis_count: region.basis_count,
                kernel_length: region.kernel_length,
                recalled_count: region.recalled_count() as u32,
                fade: region.fade,
            });
            let recalled: Vec<f32> =
                compact.regions.iter().flat_map(|region| region.recalled.iter().copied()).collect();
            let basis_bytes: &[u8] = bytemuck::cast_slice(&compact.basis);
            Function::Compact {
                level: compact.level,
                regions: regions.collect(),
                centres: buffer.halves(&compact.centres, &[centres, joint_count, 6]),
                coefficient_from_kernel: buffer.halves(&coefficients, &[steps, centres]),
                recalled: (!recalled.is_empty()).then(|| buffer.halves(&recalled, &[recalled.len()])),
                row_vertices: buffer.indices(&compact.row_vertices),
                mean: buffer.halves(&compact.mean, &[rows, 3]),
                basis: buffer.table(basis_bytes, Number::I8, &[basis_bytes.len() / 3, 3]),
                basis_step: buffer.floats(&compact.basis_step, &[steps]),
            }
        }
    }
}
