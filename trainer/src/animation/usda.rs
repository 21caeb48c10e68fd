//! USD in its text form (`.usda`): one mesh, whose points and normals have a sample for each frame.
//!
//! Frames go to the disk as they come, so a motion may be of any length.

use crate::files::PartFile;
use anyhow::Context;
use crease::avatar::Avatar;
use crease::mesh::{Triangle, vertex_normals};
use crease::render::{DrawnSurface, DrawnVertex};
use glam::Vec3A;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file as it grows.
pub struct UsdaFile {
    file: PartFile,
    /// Normals follow points in the file, so they wait in another.
    normals: PartFile,
    path: PathBuf,
    surface: DrawnSurface,
    triangles: Vec<Triangle>,
    bounds: Vec<[Vec3A; 2]>,
    vertex_normals: Vec<Vec3A>,
}

impl UsdaFile {
    /// Begins `path` for meshes of `triangles`, the finest of `avatar`. Its texture is written beside it.
    pub fn create(path: &Path, avatar: &Avatar, triangles: &[Triangle], length: Length) -> anyhow::Result<Self> {
        let surface = DrawnSurface::new(&avatar.appearance, triangles, &avatar.name)?;
        let texture = match &avatar.appearance.texture {
            None => None,
            Some(texture) => {
                let picture = path.with_extension(if texture.mime == "image/jpeg" { "jpg" } else { "png" });
                crate::files::write_whole(&picture, &texture.bytes)?;
                picture.file_name().map(|name| name.to_string_lossy().into_owned())
            }
        };
        let mut file = PartFile::create(path)?;
        let normals = PartFile::create(&path.with_extension("normals"))?;
        head(&mut file, &surface, avatar, texture.as_deref(), length).with_context(|| path.display().to_string())?;
        Ok(Self {
            file,
            normals,
            path: path.to_path_buf(),
            vertex_normals: Vec::new(),
            surface,
            triangles: triangles.to_vec(),
            bounds: Vec::new(),
        })
    }

    /// Adds a frame: positions of the finest level, metres.
    pub fn frame(&mut self, positions: &[Vec3A]) -> anyhow::Result<()> {
        self.vertex_normals.resize(positions.len(), Vec3A::ZERO);
        vertex_normals(positions, &self.triangles, &mut self.vertex_normals);
        let frame = self.bounds.len();
        let drawn = |values: &[Vec3A]| -> Vec<Vec3A> {
            self.surface.vertices.iter().map(|vertex| values[vertex.body_vertex as usize]).collect()
        };
        let (points, normals) = (drawn(positions), drawn(&self.vertex_normals));
        let written =
            sample(&mut self.file, frame, &points, 5).and_then(|()| sample(&mut self.normals, frame, &normals, 3));
        written.with_context(|| self.path.display().to_string())?;
        let bound = |start: Vec3A, pick: fn(Vec3A, Vec3A) -> Vec3A| points.iter().copied().fold(start, pick);
        self.bounds.push([bound(Vec3A::INFINITY, Vec3A::min), bound(Vec3A::NEG_INFINITY, Vec3A::max)]);
        Ok(())
    }

    /// Ends the file; until then there is none under its name.
    pub fn finish(mut self) -> anyhow::Result<()> {
        let written = self.tail();
        written.with_context(|| self.path.display().to_string())?;
        self.file.keep()
    }

    fn tail(&mut self) -> io::Result<()> {
        let out = &mut self.file;
        out.write_all(b"        }\n        normal3f[] normals (\n            interpolation = \"vertex\"\n        )\n")?;
        out.write_all(b"        normal3f[] normals.timeSamples = {\n")?;
        self.normals.append_to(out)?;
        out.write_all(b"        }\n        float3[] extent.timeSamples = {\n")?;
        for (frame, bounds) in self.bounds.iter().enumerate() {
            sample(out, frame, bounds, 5)?;
        }
        out.write_all(b"        }\n    }\n}\n")
    }
}

/// How long a motion is.
#[derive(Clone, Copy, Debug)]
pub struct Length {
    /// Frames; at least one.
    pub frame_count: usize,
    /// A second.
    pub frames_per_second: f32,
}

/// All that no frame changes, up to the points' first sample.
fn head(
    out: &mut impl Write,
    surface: &DrawnSurface,
    avatar: &Avatar,
    texture: Option<&str>,
    length: Length,
) -> io::Result<()> {
    let Length { frame_count, frames_per_second } = length;
    let name = avatar.name.escape_default();
    write!(
        out,
        r#"#usda 1.0
(
    defaultPrim = "Avatar"
    doc = "{name}, written by crease {version}"
    metersPerUnit = 1
    upAxis = "Y"
    startTimeCode = 0
    endTimeCode = {last}
    timeCodesPerSecond = {frames_per_second}
    framesPerSecond = {frames_per_second}
)

def Xform "Avatar" (
    kind = "component"
)
{{
"#,
        version = env!("CARGO_PKG_VERSION"),
        last = frame_count.saturating_sub(1),
    )?;
    material(out, texture)?;
    let triangles = surface.levels.last().map_or(&[][..], Vec::as_slice);
    write!(
        out,
        r#"    def Mesh "Surface" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {{
        uniform token subdivisionScheme = "none"
        rel material:binding = </Avatar/Cloth>
        int[] faceVertexCounts = ["#
    )?;
    list(out, triangles.iter(), |out, _| write!(out, "3"))?;
    write!(out, "]\n        int[] faceVertexIndices = [")?;
    list(out, triangles.iter().flatten(), |out, corner| write!(out, "{corner}"))?;
    out.write_all(b"]\n")?;
    match texture {
        Some(_) => {
            write!(out, "        texCoord2f[] primvars:st = [")?;
            // v points up in USD.
            list(out, surface.vertices.iter().map(|vertex| vertex.texture_coordinates), |out, [u, v]| {
                write!(out, "({u:.5}, {:.5})", 1.0 - v)
            })?;
        }
        None => {
            write!(out, "        color3f[] primvars:displayColor = [")?;
            list(out, surface.vertices.iter(), |out, DrawnVertex { colour: [r, g, b, _], .. }| {
                let [r, g, b] = [r, g, b].map(|linear| f32::from(*linear) / 255.0);
                write!(out, "({r:.4}, {g:.4}, {b:.4})")
            })?;
        }
    }
    out.write_all(b"] (\n            interpolation = \"vertex\"\n        )\n        point3f[] points.timeSamples = {\n")
}

fn material(out: &mut impl Write, texture: Option<&str>) -> io::Result<()> {
    let colour = match texture {
        Some(_) => "color3f inputs:diffuseColor.connect = </Avatar/Cloth/Picture.outputs:rgb>",
        None => "color3f inputs:diffuseColor.connect = </Avatar/Cloth/Coordinates.outputs:result>",
    };
    let (reader, kind, primvar) = match texture {
        Some(_) => ("UsdPrimvarReader_float2", "float2", "st"),
        None => ("UsdPrimvarReader_float3", "float3", "displayColor"),
    };
    write!(
        out,
        r#"    def Material "Cloth"
    {{
        token outputs:surface.connect = </Avatar/Cloth/Shader.outputs:surface>

        def Shader "Shader"
        {{
            uniform token info:id = "UsdPreviewSurface"
            {colour}
            float inputs:roughness = 0.9
            float inputs:metallic = 0
            token outputs:surface
        }}

        def Shader "Coordinates"
        {{
            uniform token info:id = "{reader}"
            string inputs:varname = "{primvar}"
            {kind} outputs:result
        }}
"#
    )?;
    if let Some(file) = texture {
        write!(
            out,
            r#"
        def Shader "Picture"
        {{
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./{file}@
            float2 inputs:st.connect = </Avatar/Cloth/Coordinates.outputs:result>
            token inputs:sourceColorSpace = "sRGB"
            float3 outputs:rgb
        }}
"#
        )?;
    }
    out.write_all(b"    }\n\n")
}

/// One time sample: vectors with so many digits after the point.
fn sample(out: &mut impl Write, frame: usize, vectors: &[Vec3A], digits: usize) -> io::Result<()> {
    write!(out, "            {frame}: [")?;
    list(out, vectors.iter(), |out, v| write!(out, "({:.digits$}, {:.digits$}, {:.digits$})", v.x, v.y, v.z))?;
    out.write_all(b"],\n")
}

fn list<W: Write, T>(
    out: &mut W,
    values: impl Iterator<Item = T>,
    mut value: impl FnMut(&mut W, T) -> io::Result<()>,
) -> io::Result<()> {
    for (index, item) in values.enumerate() {
        if index > 0 {
            out.write_all(b", ")?;
        }
        value(out, item)?;
    }
    Ok(())
}
