//! What tests of shaders share: validation by naga, and where a structure's members lie.

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

/// Parses and validates `source` at WebGPU's baseline; the error is naga's message.
pub(crate) fn validate(source: &str) -> Result<(naga::Module, ModuleInfo), String> {
    // `unpack2x16float` is in WGSL itself; naga counts it apart because old OpenGL lacks it.
    validate_with(source, Capabilities::SHADER_FLOAT16_IN_FLOAT32)
}

/// Panics with the name and naga's message of the first of `sources` that is not valid at WebGPU's baseline.
pub(crate) fn validate_all(sources: &[(&str, &str)]) {
    for (name, source) in sources {
        if let Err(message) = validate(source) {
            panic!("{name}: {message}");
        }
    }
}

/// The same with `capabilities` beyond the baseline.
pub(crate) fn validate_with(source: &str, capabilities: Capabilities) -> Result<(naga::Module, ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let info = Validator::new(ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|error| error.emit_to_string(source))?;
    Ok((module, info))
}

/// Byte offset of each member of the structure `name` in `source`, and its size.
pub(crate) fn member_offsets(source: &str, name: &str) -> (Vec<(String, usize)>, usize) {
    let (module, _) = validate(source).unwrap();
    let (_, structure) = module.types.iter().find(|(_, item)| item.name.as_deref() == Some(name)).unwrap();
    let naga::TypeInner::Struct { members, span } = &structure.inner else { panic!("{name} is no structure") };
    let offsets = members.iter().map(|member| (member.name.clone().unwrap(), member.offset as usize)).collect();
    (offsets, *span as usize)
}

#[test]
fn a_broken_shader_is_refused() {
    assert!(validate("@fragment fn fragment() -> @location(0) vec4f { return vec3f(1.0); }").is_err());
}

#[test]
#[should_panic(expected = "of two")]
fn the_broken_one_is_named() {
    validate_all(&[("a whole one", ""), ("the second of two", "broken")]);
}

#[test]
fn a_shader_beyond_the_baseline_is_refused() {
    assert!(
        validate("var<immediate> x: f32; @fragment fn fragment() -> @location(0) vec4f { return vec4f(x); }").is_err()
    );
}
