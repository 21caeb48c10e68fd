//! Every shader is valid WGSL at WebGPU's baseline, and host structures lie where the shaders expect them.

use super::globals::Globals;
use super::{shader_sources, webgl2_shader_sources};
use crate::shader_check::{member_offsets, validate_all};
use std::mem::offset_of;

#[test]
fn every_shader_is_valid_at_the_baseline() {
    validate_all(&[
        ("figure", shader_sources::FIGURE),
        ("figure, WebGL2", webgl2_shader_sources::FIGURE),
        ("backdrop", shader_sources::BACKDROP),
        ("backdrop, WebGL2", webgl2_shader_sources::BACKDROP),
        ("depth map", shader_sources::DEPTH_MAP),
        ("depth map, WebGL2", webgl2_shader_sources::DEPTH_MAP),
        ("mipmap", shader_sources::MIPMAP),
    ]);
}

#[test]
fn globals_lie_where_the_shaders_expect_them() {
    macro_rules! host_offsets {
        ($($member:ident)*) => { vec![$((stringify!($member).to_string(), offset_of!(Globals, $member))),*] };
    }
    let host = host_offsets!(
        clip_from_world key_from_world below_from_world eye key_texel key_direction key_depth key_colour below_width
        sky_colour floor_radius bounce_colour shadow_strength rim_colour floor_x floor_colour floor_z backdrop_low
        backdrop_opacity backdrop_high view
    );
    let (shader, size) = member_offsets(shader_sources::FIGURE, "Globals");
    assert_eq!(shader, host);
    assert_eq!(size, size_of::<Globals>());
}

#[test]
fn a_surface_vertex_is_one_element_of_its_array() {
    assert_eq!(size_of::<super::SurfaceVertex>(), size_of::<[u32; 4]>());
    assert_eq!(offset_of!(super::SurfaceVertex, normal), 12);
}
