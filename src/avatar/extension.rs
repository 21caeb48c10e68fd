//! The JSON of the `CREASE_avatar` extension, version 2 (docs/format.md).

use super::Form;
use crate::mesh::Scheme;
use crate::pose_feature::PoseMask;
use serde::{Deserialize, Serialize};

/// The extension's name.
pub const NAME: &str = "CREASE_avatar";
/// Readers refuse any other.
pub const MAJOR_VERSION: u64 = 2;
/// Readers accept any.
pub const MINOR_VERSION: u64 = 0;

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Extension {
    pub version: Version,
    pub name: String,
    pub units: Units,
    pub mesh: usize,
    pub skin: usize,
    pub drawn_vertices: Table,
    pub canonical: Table,
    pub rest: Table,
    pub scheme: Scheme,
    pub level_count: u32,
    pub form: Form,
    pub association: Vec<PoseMask>,
    pub deformation: Function,
    pub laplacian: Function,
    pub anchors: Table,
    pub anchor_weight: f32,
    pub factor: Factor,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose_directions: Option<Table>,
    pub provenance: serde_json::Map<String, serde_json::Value>,
}

#[derive(Serialize, Deserialize)]
pub struct Version {
    pub major: u64,
    pub minor: u64,
}

#[derive(Serialize, Deserialize, PartialEq, Debug)]
pub struct Units {
    pub length: String,
    pub angle: String,
    pub up: String,
}

impl Default for Units {
    fn default() -> Self {
        Self { length: "metre".into(), angle: "radian".into(), up: "y".into() }
    }
}

/// A whole buffer view as a row-major array of little-endian numbers, packed or as it is.
#[derive(Serialize, Deserialize, Clone)]
#[serde(rename_all = "camelCase")]
pub struct Table {
    pub buffer_view: usize,
    #[serde(rename = "type")]
    pub number: Number,
    pub shape: Vec<usize>,
    /// Of `f16` tables: value = number × scale.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f32>,
    /// The view holds what `deflate::pack` makes of the array.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub packed: bool,
}

#[derive(Serialize, Deserialize, Clone, Copy, PartialEq, Eq, Debug)]
#[serde(rename_all = "lowercase")]
pub enum Number {
    I8,
    U16,
    U32,
    F16,
    F32,
}

impl Number {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 => 1,
            Self::U16 | Self::F16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// A surface function.
#[derive(Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", rename_all_fields = "camelCase")]
#[cfg_attr(target_pointer_width = "64", expect(clippy::large_enum_variant, reason = "a file has two of them"))]
pub enum Function {
    Mlp {
        level: u32,
        frequency_count: u32,
        output_scale: f32,
        layers: Vec<LayerTables>,
    },
    Compact {
        level: u32,
        regions: Vec<RegionFacts>,
        centres: Table,
        coefficient_from_kernel: Table,
        row_vertices: Table,
        mean: Table,
        basis: Table,
        basis_step: Table,
    },
}

#[derive(Serialize, Deserialize)]
pub struct LayerTables {
    pub weight: Table,
    pub bias: Table,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct RegionFacts {
    pub mask: PoseMask,
    pub rows: (u32, u32),
    pub basis_count: u32,
    pub kernel_length: f32,
}

#[derive(Serialize, Deserialize)]
pub struct Factor {
    pub permutation: Table,
    pub diagonal: Table,
    pub values: Table,
}
