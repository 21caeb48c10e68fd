//! glTF 2.0 in one binary file: one mesh, one material, the texture inside.
//!
//! The JSON is written as text: a page would have to download whatever builds it otherwise.

use super::ExportedMesh;
use crate::avatar::Glb;
use crate::colour::linear_byte_from_srgb;
use glam::Vec3A;

const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

pub(super) fn encode(mesh: &ExportedMesh) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let count = mesh.positions.len();
    let floats = |vectors: &[Vec3A]| -> Vec<u8> {
        vectors.iter().flat_map(|vector| vector.to_array()).flat_map(f32::to_le_bytes).collect()
    };
    let corners: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|corner| corner.to_le_bytes()).collect();
    let corner_count = 3 * mesh.triangles.len();
    let indices = buffer.accessor(&corners, ELEMENT_ARRAY_BUFFER, UNSIGNED_INT, "SCALAR", corner_count, "");
    let bound = |start: Vec3A, pick: fn(Vec3A, Vec3A) -> Vec3A| {
        mesh.positions.iter().fold(start, |bound, &position| pick(bound, position)).to_array()
    };
    let [low, high] = [bound(Vec3A::INFINITY, Vec3A::min), bound(Vec3A::NEG_INFINITY, Vec3A::max)];
    let bounds = format!(r#","min":{low:?},"max":{high:?}"#);
    let position = buffer.accessor(&floats(&mesh.positions), ARRAY_BUFFER, FLOAT, "VEC3", count, &bounds);
    // A vertex without an area around it has no normal; glTF wants unit vectors.
    let normals: Vec<Vec3A> = mesh.normals.iter().map(|normal| normal.normalize_or(Vec3A::Y)).collect();
    let normal = buffer.accessor(&floats(&normals), ARRAY_BUFFER, FLOAT, "VEC3", count, "");
    let mut attributes = format!(r#""POSITION":{position},"NORMAL":{normal}"#);
    let (mut picture, mut base_colour) = (String::new(), "");
    if let (Some(texture), false) = (&mesh.texture, mesh.texture_coordinates.is_empty()) {
        let data: Vec<u8> = mesh.texture_coordinates.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
        let coordinates = buffer.accessor(&data, ARRAY_BUFFER, FLOAT, "VEC2", count, "");
        attributes += &format!(r#","TEXCOORD_0":{coordinates}"#);
        base_colour = r#""baseColorTexture":{"index":0},"#;
        let view = buffer.view(&texture.bytes, "");
        // Of the two kinds that glTF knows.
        let mime = if texture.mime == "image/jpeg" { "image/jpeg" } else { "image/png" };
        picture = format!(r#""textures":[{{"source":0}}],"images":[{{"bufferView":{view},"mimeType":"{mime}"}}],"#);
    } else if !mesh.colours.is_empty() {
        // glTF's colours are linear.
        let data: Vec<u8> = mesh
            .colours
            .iter()
            .map(|colour| colour.map(linear_byte_from_srgb))
            .flat_map(|[r, g, b]| [r, g, b, 255])
            .collect();
        let normalized = r#","normalized":true"#;
        let colours = buffer.accessor(&data, ARRAY_BUFFER, UNSIGNED_BYTE, "VEC4", count, normalized);
        attributes += &format!(r#","COLOR_0":{colours}"#);
    }
    let json = format!(
        r#"{{"asset":{{"version":"2.0","generator":"crease {version}"}},
"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],{picture}
"meshes":[{{"primitives":[{{"attributes":{{{attributes}}},"indices":{indices},"material":0}}]}}],
"materials":[{{"pbrMetallicRoughness":{{{base_colour}"metallicFactor":0,"roughnessFactor":0.9}}}}],
"accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{{"byteLength":{length}}}]}}"#,
        version = env!("CARGO_PKG_VERSION"),
        accessors = buffer.accessors.join(","),
        views = buffer.views.join(","),
        length = buffer.bytes.len(),
    );
    Glb::assemble(json.into_bytes(), buffer.bytes)
}

/// The binary chunk as it grows, and the JSON of what lies in it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Buffer {
    /// A new buffer view, on a multiple of four; `members` are further ones of its object, each after a comma.
    fn view(&mut self, data: &[u8], members: &str) -> usize {
        let (offset, length) = (self.bytes.len(), data.len());
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}{members}}}"#));
        self.bytes.extend(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(
        &mut self,
        data: &[u8],
        target: u32,
        component_type: u32,
        shape: &str,
        count: usize,
        members: &str,
    ) -> usize {
        let view = self.view(data, &format!(r#","target":{target}"#));
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component_type},"type":"{shape}","count":{count}{members}}}"#
        ));
        self.accessors.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::square;
    use super::*;
    use crate::avatar::Texture;

    fn import(mesh: &ExportedMesh) -> gltf::Gltf {
        gltf::Gltf::from_slice(&encode(mesh)).unwrap()
    }

    #[test]
    fn another_reader_finds_the_mesh_and_its_texture() {
        let mut mesh = square();
        mesh.texture_coordinates = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        mesh.texture = Some(Texture { mime: "image/png".into(), bytes: vec![1, 2, 3] });
        let found = import(&mesh);
        let primitive = found.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| found.blob.as_deref());
        let positions: Vec<Vec3A> = reader.read_positions().unwrap().map(Vec3A::from_array).collect();
        assert_eq!(positions, mesh.positions);
        assert_eq!(reader.read_indices().unwrap().into_u32().collect::<Vec<_>>(), mesh.triangles.concat());
        let coordinates: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
        assert_eq!(coordinates, mesh.texture_coordinates);
        let image = found.images().next().unwrap();
        let gltf::image::Source::View { mime_type, .. } = image.source() else { panic!("the picture is outside") };
        assert_eq!(mime_type, "image/png");
        assert!(primitive.material().pbr_metallic_roughness().base_color_texture().is_some());
    }

    #[test]
    fn without_a_texture_colours_are_kept() {
        let mut mesh = square();
        mesh.colours = vec![[255, 0, 188]; 4];
        let found = import(&mesh);
        let primitive = found.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| found.blob.as_deref());
        let colours: Vec<[u8; 4]> = reader.read_colors(0).unwrap().into_rgba_u8().collect();
        assert_eq!(colours, [[255, 0, 128, 255]; 4], "sRGB 188 is half of the light");
    }
}
