//! GLSL for WebGL2, translated from the WGSL of the passes: one source of every formula and constant of the picture.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, anyhow};
use naga::ShaderStage;
use naga::back::glsl;
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use serde::Serialize;

use crate::workspace;

#[path = "../../src/render/webgl2_shader_sources.rs"]
mod sources;

/// Name in JavaScript, WGSL, entry points. A pass of depth alone has no fragment shader.
const PROGRAMS: [(&str, &str, &str, Option<&str>); 5] = [
    ("depthMap", sources::DEPTH_MAP, "vertex", None),
    ("sky", sources::BACKDROP, "sky_vertex", Some("sky_fragment")),
    ("floor", sources::BACKDROP, "floor_vertex", Some("floor_fragment")),
    ("figure", sources::FIGURE, "vertex", Some("fragment")),
    ("lines", sources::FIGURE, "line_vertex", Some("line_fragment")),
];

const NO_FRAGMENT: &str = "#version 300 es\nvoid main() {}\n";

const TYPES: &str = "/** A program for WebGL2, and what its GLSL names stand for in WGSL. */
export interface ProgramSource {
  readonly vertex: string;
  readonly fragment: string;
  /** Uniform blocks: name in GLSL to variable in WGSL. */
  readonly blocks: Readonly<Record<string, string>>;
  /** Samplers: name in GLSL to texture variable in WGSL. */
  readonly textures: Readonly<Record<string, string>>;
}
";

#[derive(Default, Serialize)]
struct Program {
    vertex: String,
    fragment: String,
    blocks: BTreeMap<String, String>,
    textures: BTreeMap<String, String>,
}

/// Writes `webgl2_shaders.js` and its types into `folder`, unless they are there already.
pub fn write(folder: &Path) -> Result<()> {
    let mut code = String::new();
    let mut types = TYPES.to_owned();
    for (name, source, vertex, fragment) in PROGRAMS {
        let program = translate(source, vertex, fragment).with_context(|| format!("WebGL2 program {name}"))?;
        writeln!(code, "export const {name} = {};", serde_json::to_string(&program)?)?;
        writeln!(types, "export const {name}: ProgramSource;")?;
    }
    for (file, text) in [("webgl2_shaders.js", code), ("webgl2_shaders.d.ts", types)] {
        let path = folder.join(file);
        if fs::read_to_string(&path).is_ok_and(|found| found == text) {
            continue;
        }
        fs::write(&path, text).with_context(|| format!("cannot write {}", workspace::relative(&path)))?;
    }
    Ok(())
}

fn translate(source: &str, vertex: &str, fragment: Option<&str>) -> Result<Program> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| anyhow!(error.emit_to_string(source)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| anyhow!(error.emit_to_string(source)))?;
    let mut program = Program::default();
    program.vertex = stage(&module, &info, ShaderStage::Vertex, vertex, &mut program)?;
    program.fragment = match fragment {
        Some(entry) => stage(&module, &info, ShaderStage::Fragment, entry, &mut program)?,
        None => NO_FRAGMENT.to_owned(),
    };
    Ok(program)
}

/// GLSL of one stage; notes its uniform blocks and textures in `program`. Pictures come out upside down, as OpenGL counts rows
/// from the bottom: y is flipped, so that every texel has the place that it has in WebGPU.
fn stage(
    module: &naga::Module,
    info: &ModuleInfo,
    shader_stage: ShaderStage,
    entry_point: &str,
    program: &mut Program,
) -> Result<String> {
    let options = glsl::Options {
        version: glsl::Version::Embedded { version: 300, is_webgl: true },
        writer_flags: glsl::WriterFlags::ADJUST_COORDINATE_SPACE | glsl::WriterFlags::TEXTURE_SHADOW_LOD,
        ..Default::default()
    };
    let pipeline = glsl::PipelineOptions { shader_stage, entry_point: entry_point.to_owned(), multiview: None };
    let mut text = String::new();
    let reflection =
        glsl::Writer::new(&mut text, module, info, &options, &pipeline, BoundsCheckPolicies::default())?.write()?;
    let variable = |handle: naga::Handle<naga::GlobalVariable>| {
        module.global_variables[handle].name.clone().context("a variable without a name")
    };
    for (&handle, name) in &reflection.uniforms {
        program.blocks.insert(name.clone(), variable(handle)?);
    }
    for (name, mapping) in &reflection.texture_mapping {
        program.textures.insert(name.clone(), variable(mapping.texture)?);
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_program_is_translated_and_its_names_are_in_it() {
        for (name, source, vertex, fragment) in PROGRAMS {
            let program = translate(source, vertex, fragment).unwrap();
            assert!(program.vertex.starts_with("#version 300 es"), "{name}");
            assert!(program.fragment.starts_with("#version 300 es"), "{name}");
            for glsl_name in program.blocks.keys().chain(program.textures.keys()) {
                assert!(
                    program.vertex.contains(glsl_name) || program.fragment.contains(glsl_name),
                    "{name}: {glsl_name}"
                );
            }
        }
    }

    #[test]
    fn the_figure_knows_all_that_it_reads() {
        let figure = translate(sources::FIGURE, "vertex", Some("fragment")).unwrap();
        let textures: Vec<&str> = figure.textures.values().map(String::as_str).collect();
        for name in ["figure_vertices", "albedo", "key_map", "key_depths"] {
            assert!(textures.contains(&name), "{name} of {textures:?}");
        }
        assert!(figure.blocks.values().all(|name| name == "globals"));
    }

    #[test]
    fn a_shader_with_storage_buffers_is_refused() {
        let source = "@group(0) @binding(0) var<storage, read> numbers: array<f32>;
            @vertex fn vertex() -> @builtin(position) vec4f { return vec4f(numbers[0]); }";
        assert!(translate(source, "vertex", None).is_err());
    }
}
