//! Every shader is valid WGSL at WebGPU's baseline, and host structures lie where the shaders expect them.

use super::globals::Globals;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use std::mem::offset_of;

fn validate(source: &str) -> Result<(naga::Module, ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| error.emit_to_string(source))?;
    Ok((module, info))
}

#[test]
fn every_shader_is_valid_at_the_baseline() {
    let sources = [
        ("figure", super::figure::SOURCE),
        ("backdrop", super::backdrop::SOURCE),
        ("depth map", super::depth_map::SOURCE),
        ("mipmap", super::albedo::SOURCE),
    ];
    for (name, source) in sources {
        if let Err(message) = validate(source) {
            panic!("{name}: {message}");
        }
    }
}

#[test]
fn a_broken_shader_is_refused() {
    assert!(validate("@fragment fn fragment() -> @location(0) vec4f { return vec3f(1.0); }").is_err());
}

#[test]
fn a_shader_beyond_the_baseline_is_refused() {
    assert!(
        validate("var<immediate> x: f32; @fragment fn fragment() -> @location(0) vec4f { return vec4f(x); }").is_err()
    );
}

/// Byte offset of each member of the structure `name` in `source`.
fn member_offsets(source: &str, name: &str) -> (Vec<(String, usize)>, usize) {
    let (module, _) = validate(source).unwrap();
    let (_, structure) = module.types.iter().find(|(_, item)| item.name.as_deref() == Some(name)).unwrap();
    let naga::TypeInner::Struct { members, span } = &structure.inner else { panic!("{name} is no structure") };
    let offsets = members.iter().map(|member| (member.name.clone().unwrap(), member.offset as usize)).collect();
    (offsets, *span as usize)
}

#[test]
fn globals_lie_where_the_shaders_expect_them() {
    macro_rules! host_offsets {
        ($($member:ident)*) => { vec![$((stringify!($member).to_string(), offset_of!(Globals, $member))),*] };
    }
    let host = host_offsets!(
        clip_from_world key_from_world below_from_world eye key_texel key_direction key_depth key_colour below_width
        sky_colour floor_radius bounce_colour shadow_strength rim_colour floor_x floor_colour floor_z backdrop_low
        backdrop_high
    );
    let (shader, size) = member_offsets(super::figure::SOURCE, "Globals");
    assert_eq!(shader, host);
    assert_eq!(size, size_of::<Globals>());
}

#[test]
fn a_surface_vertex_is_one_element_of_its_array() {
    assert_eq!(size_of::<super::surface_vertex::SurfaceVertex>(), size_of::<[u32; 4]>());
    assert_eq!(offset_of!(super::surface_vertex::SurfaceVertex, normal), 12);
}
