//! The part of glTF's JSON that an avatar uses, with glTF's own names.

use super::AvatarError;
use super::extension::NAME;
use super::json::{FromJson, Json};
use serde::Serialize;

pub const UNSIGNED_BYTE: u32 = 5121;
pub const UNSIGNED_SHORT: u32 = 5123;
pub const UNSIGNED_INT: u32 = 5125;
pub const FLOAT: u32 = 5126;
pub const ARRAY_BUFFER: u32 = 34962;
pub const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The document; `E` is the extension's object.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Document<E> {
    pub asset: Asset,
    pub extensions_used: Vec<String>,
    pub scene: usize,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub meshes: Vec<Mesh>,
    pub skins: Vec<Skin>,
    pub materials: Vec<Material>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub textures: Vec<TextureSource>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub images: Vec<Image>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    pub extensions: Extensions<E>,
}

#[derive(Serialize)]
pub struct Asset {
    pub version: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generator: Option<String>,
}

#[derive(Serialize)]
pub struct Scene {
    pub nodes: Vec<usize>,
}

#[derive(Serialize, Default)]
pub struct Node {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translation: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skin: Option<usize>,
}

#[derive(Serialize)]
pub struct Mesh {
    pub primitives: Vec<Primitive>,
}

#[derive(Serialize)]
pub struct Primitive {
    pub attributes: Attributes,
    pub indices: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<usize>,
}

#[derive(Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub struct Attributes {
    pub position: usize,
    pub normal: usize,
    #[serde(rename = "JOINTS_0")]
    pub joints: usize,
    #[serde(rename = "WEIGHTS_0")]
    pub weights: usize,
    #[serde(rename = "TEXCOORD_0", skip_serializing_if = "Option::is_none")]
    pub texture_coordinates: Option<usize>,
    #[serde(rename = "COLOR_0", skip_serializing_if = "Option::is_none")]
    pub colours: Option<usize>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Skin {
    pub inverse_bind_matrices: usize,
    pub joints: Vec<usize>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    pub pbr_metallic_roughness: MetallicRoughness,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MetallicRoughness {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_color_texture: Option<TextureReference>,
    pub metallic_factor: f32,
    pub roughness_factor: f32,
}

#[derive(Serialize)]
pub struct TextureReference {
    pub index: usize,
}

#[derive(Serialize)]
pub struct TextureSource {
    pub source: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Image {
    pub buffer_view: usize,
    pub mime_type: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: usize,
    #[serde(skip_serializing_if = "is_zero")]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(skip_serializing_if = "is_false")]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub shape: String,
    /// For viewers: readers of avatars leave it out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<[f32; 3]>,
    /// The same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<[f32; 3]>,
    /// Whether there is a member `sparse`, which writers never make.
    #[serde(skip)]
    pub is_sparse: bool,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: usize,
    #[serde(skip_serializing_if = "is_zero")]
    pub byte_offset: usize,
    pub byte_length: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub byte_stride: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<u32>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub byte_length: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
}

#[derive(Serialize)]
pub struct Extensions<E> {
    #[serde(rename = "CREASE_avatar")]
    pub avatar: E,
}

impl<E: FromJson> FromJson for Document<E> {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self {
            asset: json.get("asset")?,
            extensions_used: json.get("extensionsUsed")?,
            scene: json.get("scene")?,
            scenes: json.get("scenes")?,
            nodes: json.get("nodes")?,
            meshes: json.get("meshes")?,
            skins: json.get("skins")?,
            materials: json.get("materials")?,
            textures: json.get_or_default("textures")?,
            images: json.get_or_default("images")?,
            accessors: json.get("accessors")?,
            buffer_views: json.get("bufferViews")?,
            buffers: json.get("buffers")?,
            extensions: json.get("extensions")?,
        })
    }
}

impl FromJson for Asset {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { version: json.get("version")?, generator: json.get("generator")? })
    }
}

impl FromJson for Scene {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { nodes: json.get("nodes")? })
    }
}

impl FromJson for Node {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self {
            name: json.get_or_default("name")?,
            children: json.get_or_default("children")?,
            translation: json.get("translation")?,
            mesh: json.get("mesh")?,
            skin: json.get("skin")?,
        })
    }
}

impl FromJson for Mesh {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { primitives: json.get("primitives")? })
    }
}

impl FromJson for Primitive {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self {
            attributes: json.get("attributes")?,
            indices: json.get("indices")?,
            mode: json.get("mode")?,
            material: json.get("material")?,
        })
    }
}

impl FromJson for Attributes {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self {
            position: json.get("POSITION")?,
            normal: json.get("NORMAL")?,
            joints: json.get("JOINTS_0")?,
            weights: json.get("WEIGHTS_0")?,
            texture_coordinates: json.get("TEXCOORD_0")?,
            colours: json.get("COLOR_0")?,
        })
    }
}

impl FromJson for Skin {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { inverse_bind_matrices: json.get("inverseBindMatrices")?, joints: json.get("joints")? })
    }
}

impl FromJson for Material {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { pbr_metallic_roughness: json.get("pbrMetallicRoughness")? })
    }
}

impl FromJson for MetallicRoughness {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self {
            base_color_texture: json.get("baseColorTexture")?,
            metallic_factor: json.get_or_default("metallicFactor")?,
            roughness_factor: json.get_or_default("roughnessFactor")?,
        })
    }
}

impl FromJson for TextureReference {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { index: json.get("index")? })
    }
}

impl FromJson for TextureSource {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { source: json.get("source")? })
    }
}

impl FromJson for Image {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { buffer_view: json.get("bufferView")?, mime_type: json.get("mimeType")? })
    }
}

impl FromJson for Accessor {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self {
            buffer_view: json.get("bufferView")?,
            byte_offset: json.get_or_default("byteOffset")?,
            component_type: json.get("componentType")?,
            normalized: json.get_or_default("normalized")?,
            count: json.get("count")?,
            shape: json.get("type")?,
            min: None,
            max: None,
            is_sparse: json.member("sparse")?.is_some(),
        })
    }
}

impl FromJson for BufferView {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self {
            buffer: json.get("buffer")?,
            byte_offset: json.get_or_default("byteOffset")?,
            byte_length: json.get("byteLength")?,
            byte_stride: json.get("byteStride")?,
            target: json.get("target")?,
        })
    }
}

impl FromJson for Buffer {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { byte_length: json.get("byteLength")?, uri: json.get("uri")? })
    }
}

impl<E: FromJson> FromJson for Extensions<E> {
    fn from_json(json: &Json) -> Result<Self, AvatarError> {
        Ok(Self { avatar: E::from_json(&json.member(NAME)?.named(NAME))? })
    }
}

fn is_zero(value: &usize) -> bool {
    *value == 0
}

fn is_false(value: &bool) -> bool {
    !value
}
