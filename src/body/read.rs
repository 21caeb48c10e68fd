//! Bodies from `.npz` and from SMPL's own `.pkl`, validated in full.

use super::{Body, Skin, TextureCoordinates};
use crate::memory::MemoryLimit;
use crate::mesh::Triangle;
use crate::numpy::{Archive, Field, ReadError};
use crease_posing::joint_names::joint_names;
use glam::Vec3A;

/// Skinning weights and regressor rows may sum to 1 up to this: files hold float16 at worst.
const SUM_TOLERANCE: f32 = 0.01;
/// Fewest joints: motions have SMPL's.
const FEWEST_JOINTS: usize = 24;
/// Most joints: [`Skin`] keeps them in a byte.
const MOST_JOINTS: usize = 256;

impl Body {
    /// Reads a `.npz` or `.pkl` body, told apart by its first bytes; `name` is the file's name for messages.
    ///
    /// Arrays, for V vertices, F triangles, J joints (24, or more as SMPL-H and SMPL-X have) and B shape components:
    /// `v_template (V, 3)`, `f (F, 3)`, `shapedirs (V, 3, B)`, `J_regressor (J, V)` dense or scipy sparse,
    /// `weights (V, J)`, `kintree_table (2, J)` (parents, then joints; the root's parent is -1 or 2^32 - 1);
    /// optional `posedirs (V, 3, 9 (J - 1))`, `vt (T, 2)` with `ft (F, 3)`, `joint_names (J,)`.
    /// Of each vertex's weights the four largest are kept and scaled to sum to 1.
    pub fn read(bytes: &[u8], name: &str) -> Result<Self, ReadError> {
        Self::read_within(bytes, name, MemoryLimit::default())
    }

    /// [`Self::read`] with another limit of memory.
    pub fn read_within(bytes: &[u8], name: &str, limit: MemoryLimit) -> Result<Self, ReadError> {
        let mut archive = Archive::open_within(bytes, name, limit)?;
        let template = archive.required("v_template")?;
        let vertex_count = template.rows_of(3)?;
        if vertex_count == 0 {
            return Err(template.error("at least one vertex", "none"));
        }
        let template = template.finite_numbers()?.chunks_exact(3).map(Vec3A::from_slice).collect();
        let triangles = read_triangles(&archive.required("f")?, vertex_count, "vertices")?;
        if triangles.is_empty() {
            return Err(archive.required("f")?.error("at least one triangle", "none"));
        }
        let shape_directions = read_directions(&archive.required("shapedirs")?, vertex_count)?;
        let parents = read_parents(&archive.required("kintree_table")?)?;
        let joint_count = parents.len();
        let skin = read_skin(&archive.required("weights")?, vertex_count, joint_count)?;
        let joint_regressor = read_regressor(&archive.required("J_regressor")?, vertex_count, joint_count)?;
        let pose_directions = match archive.optional("posedirs")? {
            None => None,
            Some(field) => {
                field.expect_shape(&[vertex_count, 3, 9 * (joint_count - 1)])?;
                Some(read_directions(&field, vertex_count)?)
            }
        };
        let joint_names = match archive.optional("joint_names")? {
            None => joint_names(joint_count),
            Some(field) => {
                field.expect_shape(&[joint_count])?;
                field.texts()?.to_vec()
            }
        };
        let texture_coordinates = read_texture_coordinates(&mut archive, triangles.len())?;
        Ok(Self {
            template,
            shape_directions,
            pose_directions,
            joint_regressor,
            skin,
            parents,
            joint_names,
            triangles,
            texture_coordinates,
        })
    }
}

fn read_triangles(field: &Field, limit: usize, limited_by: &str) -> Result<Vec<Triangle>, ReadError> {
    field.rows_of(3)?;
    let indices = field.indices(limit, limited_by)?;
    Ok(indices.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect())
}

/// From (V, 3, components) to one field of displacements per component.
fn read_directions(field: &Field, vertex_count: usize) -> Result<Vec<Vec<Vec3A>>, ReadError> {
    let component_count = match *field.shape() {
        [vertices, 3, components] if vertices == vertex_count => components,
        _ => return Err(field.wrong_shape(format_args!("({vertex_count}, 3, any)"))),
    };
    let numbers = field.finite_numbers()?;
    let at = |vertex: usize, axis: usize, component: usize| numbers[(3 * vertex + axis) * component_count + component];
    let field_of = |component| {
        let vertex_offset = |v| Vec3A::new(at(v, 0, component), at(v, 1, component), at(v, 2, component));
        (0..vertex_count).map(vertex_offset).collect()
    };
    Ok((0..component_count).map(field_of).collect())
}

fn read_parents(field: &Field) -> Result<Vec<Option<usize>>, ReadError> {
    let [2, joint_count] = *field.shape() else {
        return Err(field.wrong_shape("(2, J)"));
    };
    if !(FEWEST_JOINTS..=MOST_JOINTS).contains(&joint_count) {
        let expected = format!("{FEWEST_JOINTS} to {MOST_JOINTS} joints");
        return Err(field.error(expected, joint_count.to_string()));
    }
    let numbers = field.integers()?;
    let (parents, joints) = numbers.split_at(joint_count);
    if let Some(at) = (0..joint_count).find(|&joint| joints[joint] != joint as i64) {
        return Err(field.error(format!("joint {at} at [1, {at}]"), joints[at].to_string()));
    }
    let no_parent = [-1, i64::from(u32::MAX)];
    if !no_parent.contains(&parents[0]) {
        return Err(field.error("-1 or 4294967295 as the root's parent at [0, 0]", parents[0].to_string()));
    }
    let checked =
        parents.iter().enumerate().skip(1).map(|(joint, &parent)| {
            usize::try_from(parent).ok().filter(|&parent| parent < joint).map(Some).ok_or_else(|| {
                field.error(format!("a parent from 0 to {} at [0, {joint}]", joint - 1), parent.to_string())
            })
        });
    std::iter::once(Ok(None)).chain(checked).collect()
}

fn read_skin(field: &Field, vertex_count: usize, joint_count: usize) -> Result<Skin, ReadError> {
    field.expect_shape(&[vertex_count, joint_count])?;
    let numbers = field.finite_numbers()?;
    let mut skin = Skin { joints: Vec::with_capacity(vertex_count), weights: Vec::with_capacity(vertex_count) };
    for (vertex, row) in numbers.chunks_exact(joint_count).enumerate() {
        check_sum(field, "weights", vertex, row)?;
        if let Some(negative) = row.iter().find(|&&weight| weight < -SUM_TOLERANCE) {
            return Err(field.error(format!("no negative weight at vertex {vertex}"), negative.to_string()));
        }
        let (joints, weights) = four_largest(row);
        skin.joints.push(joints);
        skin.weights.push(weights);
    }
    Ok(skin)
}

fn check_sum(field: &Field, what: &str, row_index: usize, row: &[f32]) -> Result<(), ReadError> {
    let sum: f32 = row.iter().sum();
    if (sum - 1.0).abs() <= SUM_TOLERANCE {
        return Ok(());
    }
    Err(field.error(format!("{what} that sum to 1 in row {row_index}"), format!("a sum of {sum}")))
}

/// The four largest weights, largest first, scaled to sum to 1, and their joints; joint 0 where a weight is 0.
fn four_largest(row: &[f32]) -> ([u8; 4], [f32; 4]) {
    let mut order: Vec<usize> = (0..row.len()).filter(|&joint| row[joint] > 0.0).collect();
    order.sort_by(|&a, &b| row[b].total_cmp(&row[a]));
    order.truncate(4);
    let sum: f32 = order.iter().map(|&joint| row[joint]).sum();
    let (mut joints, mut weights) = ([0; 4], [0.0; 4]);
    for (slot, &joint) in order.iter().enumerate() {
        joints[slot] = joint as u8;
        weights[slot] = row[joint] / sum;
    }
    (joints, weights)
}

fn read_regressor(field: &Field, vertex_count: usize, joint_count: usize) -> Result<Vec<Vec<(u32, f32)>>, ReadError> {
    field.expect_shape(&[joint_count, vertex_count])?;
    let numbers = field.finite_numbers()?;
    let mut rows = Vec::with_capacity(joint_count);
    for (joint, row) in numbers.chunks_exact(vertex_count).enumerate() {
        check_sum(field, "vertex weights", joint, row)?;
        let pairs = row.iter().enumerate().filter(|&(_, &weight)| weight != 0.0);
        rows.push(pairs.map(|(vertex, &weight)| (vertex as u32, weight)).collect());
    }
    Ok(rows)
}

fn read_texture_coordinates(
    archive: &mut Archive,
    triangle_count: usize,
) -> Result<Option<TextureCoordinates>, ReadError> {
    let (coordinates, corners) = match (archive.optional("vt")?, archive.optional("ft")?) {
        (None, None) => return Ok(None),
        (Some(coordinates), Some(corners)) => (coordinates, corners),
        (Some(_), None) => return Err(archive.missing("ft")),
        (None, Some(_)) => return Err(archive.missing("vt")),
    };
    let coordinate_count = coordinates.rows_of(2)?;
    corners.expect_shape(&[triangle_count, 3])?;
    Ok(Some(TextureCoordinates {
        triangles: read_triangles(&corners, coordinate_count, "rows of vt")?,
        coordinates: coordinates.finite_numbers()?.chunks_exact(2).map(|uv| [uv[0], uv[1]]).collect(),
    }))
}
