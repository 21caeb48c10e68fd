//! The JSON of the `CREASE_avatar` extension, version 2 (docs/format.md).

use super::json::{FromJson, Json};
use super::{AvatarError, Form};
use crate::mesh::Scheme;
use crate::pose_feature::{PoseMask, association};
use serde::Serialize;

/// The extension's name.
pub const NAME: &str = "CREASE_avatar";
/// Readers refuse any other.
pub const MAJOR_VERSION: u32 = 2;
/// Readers accept any.
pub const MINOR_VERSION: u32 = 2;

#[derive(Serialize)]
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
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_directions: Option<Table>,
    pub provenance: serde_json::Map<String, serde_json::Value>,
}

#[derive(Serialize)]
pub struct Version {
    pub major: u32,
    pub minor: u32,
}

#[derive(Serialize, PartialEq, Debug)]
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
#[derive(Serialize, Clone)]
#[serde(rename_all = "camelCase")]
pub struct Table {
    pub buffer_view: usize,
    #[serde(rename = "type")]
    pub number: Number,
    pub shape: Vec<usize>,
    /// Of `f16` tables: value = number × scale.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<f32>,
    /// The view holds what `deflate::pack` makes of the array.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub packed: bool,
}

#[derive(Serialize, Clone, Copy, PartialEq, Eq, Debug)]
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
#[derive(Serialize)]
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
        /// Of the regions that recall, one after the other.
        #[serde(skip_serializing_if = "Option::is_none")]
        recalled: Option<Table>,
        row_vertices: Table,
        mean: Table,
        basis: Table,
        basis_step: Table,
    },
}

#[derive(Serialize)]
pub struct LayerTables {
    pub weight: Table,
    pub bias: Table,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RegionFacts {
    pub mask: PoseMask,
    pub rows: (u32, u32),
    pub basis_count: u32,
    pub kernel_length: f32,
    pub recalled_count: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fade: Option<[f32; 2]>,
}

#[derive(Serialize)]
pub struct Factor {
    pub permutation: Table,
    pub diagonal: Table,
    pub values: Table,
}

impl FromJson for Extension {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        // Another version may hold anything.
        let version: Version = json.get("version")?;
        let units: Units = json.get("units")?;
        if units != Units::default() {
            return Err(json.member("units")?.error("metre, radian, y", format_args!("{units:?}")));
        }
        let found: Vec<PoseMask> = json.get("association")?;
        if found != association() {
            return Err(json.member("association")?.error("the table of version 2", format_args!("{found:?}")));
        }
        Ok(Self {
            version,
            name: json.get("name")?,
            units,
            mesh: json.get("mesh")?,
            skin: json.get("skin")?,
            drawn_vertices: json.get("drawnVertices")?,
            canonical: json.get("canonical")?,
            rest: json.get("rest")?,
            scheme: json.get("scheme")?,
            level_count: json.get("levelCount")?,
            form: json.get("form")?,
            association: found,
            deformation: json.get("deformation")?,
            laplacian: json.get("laplacian")?,
            anchors: json.get("anchors")?,
            anchor_weight: json.get("anchorWeight")?,
            factor: json.get("factor")?,
            pose_directions: json.get("poseDirections")?,
            provenance: json.get("provenance")?,
        })
    }
}

impl FromJson for Version {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        let major = json.member("major")?;
        if u32::from_json(&major).ok() != Some(MAJOR_VERSION) {
            let expected = format_args!("{MAJOR_VERSION}, the only major version that this reader knows");
            return Err(major.expected(expected));
        }
        Ok(Self { major: MAJOR_VERSION, minor: json.get("minor")? })
    }
}

impl FromJson for Units {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { length: json.get("length")?, angle: json.get("angle")?, up: json.get("up")? })
    }
}

impl FromJson for Table {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self {
            buffer_view: json.get("bufferView")?,
            number: json.get("type")?,
            shape: json.get("shape")?,
            scale: json.get("scale")?,
            packed: json.get_or_default("packed")?,
        })
    }
}

impl FromJson for Number {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        match json.text()? {
            "i8" => Ok(Self::I8),
            "u16" => Ok(Self::U16),
            "u32" => Ok(Self::U32),
            "f16" => Ok(Self::F16),
            "f32" => Ok(Self::F32),
            _ => Err(json.expected("i8, u16, u32, f16 or f32")),
        }
    }
}

impl FromJson for Scheme {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        match json.text()? {
            "midpoint" => Ok(Self::Midpoint),
            "loop" => Ok(Self::Loop),
            _ => Err(json.expected("midpoint or loop")),
        }
    }
}

impl FromJson for Form {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        match json.text()? {
            "absolute" => Ok(Self::Absolute),
            "relative" => Ok(Self::Relative),
            _ => Err(json.expected("absolute or relative")),
        }
    }
}

impl FromJson for PoseMask {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        u32::from_json(json).map(Self)
    }
}

impl FromJson for Function {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        let kind = json.member("kind")?;
        match kind.text()? {
            "mlp" => Ok(Self::Mlp {
                level: json.get("level")?,
                frequency_count: json.get("frequencyCount")?,
                output_scale: json.get("outputScale")?,
                layers: json.get("layers")?,
            }),
            "compact" => Ok(Self::Compact {
                level: json.get("level")?,
                regions: json.get("regions")?,
                centres: json.get("centres")?,
                coefficient_from_kernel: json.get("coefficientFromKernel")?,
                recalled: json.get("recalled")?,
                row_vertices: json.get("rowVertices")?,
                mean: json.get("mean")?,
                basis: json.get("basis")?,
                basis_step: json.get("basisStep")?,
            }),
            _ => Err(kind.expected("mlp or compact")),
        }
    }
}

impl FromJson for LayerTables {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { weight: json.get("weight")?, bias: json.get("bias")? })
    }
}

impl FromJson for RegionFacts {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        let [first, end] = json.get("rows")?;
        Ok(Self {
            mask: json.get("mask")?,
            rows: (first, end),
            basis_count: json.get("basisCount")?,
            kernel_length: json.get("kernelLength")?,
            recalled_count: json.get_or_default("recalledCount")?,
            fade: json.get("fade")?,
        })
    }
}

impl FromJson for Factor {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { permutation: json.get("permutation")?, diagonal: json.get("diagonal")?, values: json.get("values")? })
    }
}
