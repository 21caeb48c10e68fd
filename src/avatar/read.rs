//! Reading an avatar.

use super::document::{self, Document};
use super::extension::{Extension, Factor, Function, LayerTables, Number, RegionFacts};
use super::glb::Glb;
use super::json::{self, FromJson};
use super::quantise::weight_from_step;
use super::source::{Reader, floats, halves, shorts, words};
use super::{Appearance, Avatar, AvatarError, Texture};
use crate::body::{Rig, Skin};
use crate::encoding::PositionalEncoding;
use crate::memory::{Allowance, MemoryLimit};
use crate::mesh::Triangle;
use crate::network::{Compact, Layer, Mlp, Region, SurfaceFunction};
use crate::solver::CoarseFactor;
use glam::Vec3A;

impl Avatar {
    /// Reads a GLB; every count, offset and index is checked; every number is finite. `name` is the file's name for messages.
    ///
    /// Fails where that would take more memory than the default [`MemoryLimit`].
    pub fn read(bytes: &[u8], name: &str) -> Result<Self, AvatarError> {
        Self::read_within(bytes, name, MemoryLimit::default())
    }

    /// [`Self::read`] with another limit of memory.
    pub fn read_within(bytes: &[u8], name: &str, limit: MemoryLimit) -> Result<Self, AvatarError> {
        let glb = Glb::parse(bytes, name)?;
        let allowance = Allowance::new(limit, bytes.len());
        let taken = allowance.hold(json::PARSED_TIMES.saturating_mul(glb.json.len()));
        taken.map_err(|shortage| AvatarError::new(name, "JSON chunk", shortage.expected, shortage.found))?;
        let json = json::Document::parse(glb.json, name)?;
        let document = Document::from_json(&json.root())?;
        let reader = Reader { file: name, binary: glb.binary, document: &document, allowance };
        let avatar = reader.avatar(&document.extensions.avatar)?;
        avatar.validate(name)?;
        Ok(avatar)
    }
}

impl Reader<'_> {
    fn avatar(&self, extension: &Extension) -> Result<Avatar, AvatarError> {
        let rest = self.points(&extension.rest, "rest", None)?;
        let count = rest.len();
        let drawn_vertices = self.indices(&extension.drawn_vertices, "drawnVertices", None)?;
        if let Some(vertex) = drawn_vertices.iter().find(|&&vertex| vertex as usize >= count) {
            return Err(self.error("drawnVertices", format!("vertices below {count}"), vertex));
        }
        let drawn = self.drawn(extension.mesh, drawn_vertices, count)?;
        let (rest_joints, parents, joint_names) = self.skeleton(extension.skin)?;
        let joint_count = rest_joints.len();
        let pose_directions = match &extension.pose_directions {
            None => None,
            Some(table) => {
                let shape = [Some(9 * joint_count.saturating_sub(1)), Some(count), Some(3)];
                let numbers = self.floats(table, "poseDirections", &shape)?;
                let points: Vec<Vec3A> = numbers.chunks_exact(3).map(Vec3A::from_slice).collect();
                Some(points.chunks_exact(count.max(1)).map(<[Vec3A]>::to_vec).collect())
            }
        };
        Ok(Avatar {
            name: extension.name.clone(),
            rig: Rig { rest, rest_joints, parents, joint_names, skin: drawn.skin, pose_directions },
            canonical: self.points(&extension.canonical, "canonical", Some(count))?,
            triangles: drawn.triangles,
            appearance: drawn.appearance,
            scheme: extension.scheme,
            level_count: extension.level_count,
            deformation: self.function(&extension.deformation, "deformation", joint_count)?,
            laplacian: self.function(&extension.laplacian, "laplacian", joint_count)?,
            form: extension.form,
            anchors: self.indices(&extension.anchors, "anchors", None)?,
            anchor_weight: extension.anchor_weight,
            factor: self.factor(&extension.factor, count)?,
            provenance: extension.provenance.clone(),
        })
    }

    fn drawn(&self, mesh: usize, drawn_vertices: Vec<u32>, vertex_count: usize) -> Result<Drawn, AvatarError> {
        let mesh = self.entry(&self.document.meshes, mesh, "mesh")?;
        let primitive = self.entry(&mesh.primitives, 0, "mesh.primitives")?;
        let attributes = &primitive.attributes;
        let count = drawn_vertices.len();
        let attribute = |index, field: &str, component_type, shape, normalized| {
            let (bytes, accessor) = self.accessor(index, field, &[component_type], shape, normalized)?;
            if accessor.count == count {
                Ok(bytes)
            } else {
                Err(self.error(&format!("{field}.count"), count, accessor.count))
            }
        };
        for (index, field) in [(attributes.position, "POSITION"), (attributes.normal, "NORMAL")] {
            let bytes = attribute(index, field, document::FLOAT, ("VEC3", 3), false)?;
            if let Some(number) = floats(bytes).find(|number| !number.is_finite()) {
                return Err(self.error(field, "finite numbers", number));
            }
        }
        let joints = attribute(attributes.joints, "JOINTS_0", document::UNSIGNED_BYTE, ("VEC4", 4), false)?;
        let weights = attribute(attributes.weights, "WEIGHTS_0", document::UNSIGNED_SHORT, ("VEC4", 4), true)?;
        let skin = self.skin(joints, weights, &drawn_vertices, vertex_count)?;
        let texture_coordinates = match attributes.texture_coordinates {
            None => vec![],
            Some(index) => {
                let numbers: Vec<f32> =
                    floats(attribute(index, "TEXCOORD_0", document::FLOAT, ("VEC2", 2), false)?).collect();
                numbers.as_chunks::<2>().0.to_vec()
            }
        };
        let vertex_colours = match attributes.colours {
            None => vec![],
            Some(index) => {
                let bytes = attribute(index, "COLOR_0", document::UNSIGNED_BYTE, ("VEC4", 4), true)?;
                bytes.as_chunks::<4>().0.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
            }
        };
        let (bytes, accessor) = self.accessor(
            primitive.indices,
            "indices",
            &[document::UNSIGNED_SHORT, document::UNSIGNED_INT],
            ("SCALAR", 1),
            false,
        )?;
        let corners: Vec<u32> = if accessor.component_type == document::UNSIGNED_SHORT {
            shorts(bytes).map(u32::from).collect()
        } else {
            words(bytes).collect()
        };
        if !corners.len().is_multiple_of(3) {
            return Err(self.error("indices.count", "a multiple of 3", corners.len()));
        }
        if let Some(corner) = corners.iter().find(|&&corner| corner as usize >= count) {
            return Err(self.error("indices", format!("drawn vertices below {count}"), corner));
        }
        let drawn_triangles: Vec<Triangle> = corners.as_chunks::<3>().0.to_vec();
        let triangles =
            drawn_triangles.iter().map(|corners| corners.map(|corner| drawn_vertices[corner as usize])).collect();
        let texture = self.texture(primitive.material)?;
        Ok(Drawn {
            skin,
            triangles,
            appearance: Appearance { drawn_vertices, drawn_triangles, texture_coordinates, texture, vertex_colours },
        })
    }

    /// The body's skin from that of the drawn vertices, which must agree where several stand for one.
    fn skin(&self, joints: &[u8], weights: &[u8], drawn_vertices: &[u32], count: usize) -> Result<Skin, AvatarError> {
        let steps: Vec<u16> = shorts(weights).collect();
        let influences = joints.as_chunks::<4>().0.iter().zip(steps.as_chunks::<4>().0);
        let mut found: Vec<Option<([u8; 4], [u16; 4])>> = vec![None; count];
        for (&vertex, (&joints, &steps)) in drawn_vertices.iter().zip(influences) {
            let sum: u32 = steps.iter().map(|&step| u32::from(step)).sum();
            if sum != 65535 {
                return Err(self.error("WEIGHTS_0", "steps that sum to 65535", sum));
            }
            let influence = found[vertex as usize].get_or_insert((joints, steps));
            if *influence != (joints, steps) {
                let found = format!("{influence:?} and {:?}", (joints, steps));
                return Err(self.error("JOINTS_0, WEIGHTS_0", format!("one influence for vertex {vertex}"), found));
            }
        }
        let mut skin = Skin { joints: Vec::with_capacity(count), weights: Vec::with_capacity(count) };
        for (vertex, influence) in found.into_iter().enumerate() {
            let (joints, steps) =
                influence.ok_or_else(|| self.error("drawnVertices", format!("vertex {vertex}"), "no such entry"))?;
            skin.joints.push(joints);
            skin.weights.push(steps.map(weight_from_step));
        }
        Ok(skin)
    }

    fn texture(&self, material: Option<usize>) -> Result<Option<Texture>, AvatarError> {
        let Some(material) = material else {
            return Ok(None);
        };
        let material = self.entry(&self.document.materials, material, "material")?;
        let Some(reference) = &material.pbr_metallic_roughness.base_color_texture else {
            return Ok(None);
        };
        let texture = self.entry(&self.document.textures, reference.index, "baseColorTexture.index")?;
        let image = self.entry(&self.document.images, texture.source, "texture.source")?;
        let bytes = self.view(image.buffer_view, "image")?.to_vec();
        Ok(Some(Texture { mime: image.mime_type.clone(), bytes }))
    }

    #[expect(clippy::type_complexity, reason = "three parallel lists, taken apart at once")]
    fn skeleton(&self, skin: usize) -> Result<(Vec<Vec3A>, Vec<Option<usize>>, Vec<String>), AvatarError> {
        let skin = self.entry(&self.document.skins, skin, "skin")?;
        let (bytes, accessor) =
            self.accessor(skin.inverse_bind_matrices, "inverseBindMatrices", &[document::FLOAT], ("MAT4", 16), false)?;
        if accessor.count != skin.joints.len() {
            return Err(self.error("inverseBindMatrices.count", skin.joints.len(), accessor.count));
        }
        let numbers: Vec<f32> = floats(bytes).collect();
        let rest_joints = numbers.chunks_exact(16).map(|matrix| -Vec3A::from_slice(&matrix[12..15])).collect();
        let mut parents = vec![None; skin.joints.len()];
        let mut names = Vec::with_capacity(skin.joints.len());
        for (joint, &node) in skin.joints.iter().enumerate() {
            let node = self.entry(&self.document.nodes, node, "skin.joints")?;
            names.push(node.name.clone());
            for child in &node.children {
                if let Some(child) = skin.joints.iter().position(|node| node == child)
                    && let Some(parent) = parents[child].replace(joint)
                {
                    let found = format!("joints {parent} and {joint}");
                    return Err(self.error("skin.joints", format!("one parent of joint {child}"), found));
                }
            }
        }
        Ok((rest_joints, parents, names))
    }

    fn factor(&self, factor: &Factor, count: usize) -> Result<CoarseFactor, AvatarError> {
        let shape = [Some(count)];
        let values = self.table(&factor.values, "factor.values", &[Number::F16], &[None])?;
        Ok(CoarseFactor {
            permutation: self.indices(&factor.permutation, "factor.permutation", Some(count))?,
            diagonal: self.floats(&factor.diagonal, "factor.diagonal", &shape)?,
            values: halves(&values).collect(),
        })
    }

    fn function(&self, function: &Function, field: &str, joint_count: usize) -> Result<SurfaceFunction, AvatarError> {
        match function {
            Function::Mlp { level, frequency_count, output_scale, layers } => {
                let layers = layers
                    .iter()
                    .enumerate()
                    .map(|(i, layer)| self.layer(layer, &format!("{field}.layers[{i}]")))
                    .collect::<Result<_, _>>()?;
                let encoding = PositionalEncoding { frequency_count: *frequency_count };
                Ok(SurfaceFunction::Mlp(Mlp { level: *level, encoding, layers, output_scale: *output_scale }))
            }
            Function::Compact {
                level,
                regions,
                centres,
                coefficient_from_kernel,
                recalled,
                row_vertices,
                mean,
                basis,
                basis_step,
            } => {
                let name = |part: &str| format!("{field}.{part}");
                let row_vertices = self.indices(row_vertices, &name("rowVertices"), None)?;
                let basis_bytes = self.table(basis, &name("basis"), &[Number::I8], &[None, Some(3)])?;
                let basis_step = self.floats(basis_step, &name("basisStep"), &[None])?;
                let centre_numbers = self.floats(centres, &name("centres"), &[None, Some(joint_count), Some(6)])?;
                let centre_count = centres.shape[0];
                let coefficients = self.floats(
                    coefficient_from_kernel,
                    &name("coefficientFromKernel"),
                    &[Some(basis_step.len()), Some(centre_count)],
                )?;
                let recalled = match recalled {
                    Some(recalled) => self.floats(recalled, &name("recalled"), &[None])?,
                    None => Vec::new(),
                };
                Ok(SurfaceFunction::Compact(Compact {
                    level: *level,
                    centres: centre_numbers,
                    centre_count: centre_count as u32,
                    regions: self.regions(regions, &coefficients, &recalled, centre_count, field)?,
                    mean: self.floats(mean, &name("mean"), &[Some(row_vertices.len()), Some(3)])?,
                    row_vertices,
                    basis: basis_bytes.into_owned().into_iter().map(|byte| byte as i8).collect(),
                    basis_step,
                }))
            }
        }
    }

    fn layer(&self, layer: &LayerTables, field: &str) -> Result<Layer, AvatarError> {
        let weight = self.floats(&layer.weight, &format!("{field}.weight"), &[None, None])?;
        let bias = self.floats(&layer.bias, &format!("{field}.bias"), &[Some(layer.weight.shape[0])])?;
        Ok(Layer { weight, bias })
    }

    /// The regions, each with its rows of `coefficients` and of `recalled`, which the regions share out in their order.
    fn regions(
        &self,
        facts: &[RegionFacts],
        mut coefficients: &[f32],
        mut recalled: &[f32],
        centre_count: usize,
        field: &str,
    ) -> Result<Vec<Region>, AvatarError> {
        let mut regions = Vec::with_capacity(facts.len());
        for facts in facts {
            let share = |numbers: &mut &[f32], width: usize| {
                let available = numbers.len();
                let own =
                    (facts.basis_count as usize).checked_mul(width).and_then(|length| numbers.split_off(..length));
                own.map(<[f32]>::to_vec).ok_or_else(|| {
                    let found = format!("{} × {width} in mask {}", facts.basis_count, facts.mask.0);
                    self.error(&format!("{field}.regions"), format!("{available} coefficients more"), found)
                })
            };
            regions.push(Region {
                mask: facts.mask,
                rows: facts.rows,
                basis_count: facts.basis_count,
                kernel_length: facts.kernel_length,
                coefficient_from_kernel: share(&mut coefficients, centre_count)?,
                recalled: share(&mut recalled, facts.recalled_count as usize)?,
                fade: facts.fade,
            });
        }
        Ok(regions)
    }
}

/// What the standard part of the file gives.
struct Drawn {
    skin: Skin,
    triangles: Vec<Triangle>,
    appearance: Appearance,
}
