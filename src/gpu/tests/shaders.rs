//! Every shader is valid WGSL at WebGPU's baseline, and host structures lie where the shaders expect them.

use super::super::frame::{Frame, Joint};
use super::super::{
    coarse_solve, compact, conjugate_gradients, history, normal_operator, perceptron, residual, rotation, skinning,
    sparse, surface,
};
use crate::shader_check::{member_offsets, validate, validate_all, validate_with};
use naga::valid::Capabilities;
use std::mem::offset_of;

#[test]
fn every_shader_is_valid_at_the_baseline() {
    validate_all(&[
        ("coarse solve", coarse_solve::SOURCE),
        ("compact", compact::SOURCE),
        ("conjugate gradients", conjugate_gradients::SOURCE),
        ("history", history::SOURCE),
        ("normal operator", normal_operator::SOURCE),
        ("perceptron", perceptron::SINGLE_SOURCE),
        ("residual", residual::SOURCE),
        ("rotation", rotation::SOURCE),
        ("skinning", skinning::SOURCE),
        ("sparse", sparse::SOURCE),
        ("surface", surface::SOURCE),
    ]);
}

#[test]
fn half_precision_asks_for_nothing_but_half_precision() {
    validate_with(perceptron::HALF_SOURCE, Capabilities::SHADER_FLOAT16).unwrap();
    assert!(validate(perceptron::HALF_SOURCE).is_err());
}

#[test]
fn frames_lie_where_the_shaders_expect_them() {
    let named = |list: &[(&str, usize)]| list.iter().map(|&(name, at)| (name.to_string(), at)).collect::<Vec<_>>();
    let (joint, size) = member_offsets(skinning::SOURCE, "Joint");
    let host = [
        ("posed_from_rest", offset_of!(Joint, posed_from_rest)),
        ("rotation", offset_of!(Joint, rotation)),
        ("angles", offset_of!(Joint, angles)),
    ];
    assert_eq!((joint, size), (named(&host), size_of::<Joint>()));
    let (frame, size) = member_offsets(skinning::SOURCE, "Frame");
    let host = [
        ("joints", offset_of!(Frame, joints)),
        ("detail", offset_of!(Frame, detail)),
        ("offset_share", offset_of!(Frame, offset_share)),
        ("base_share", offset_of!(Frame, base_share)),
        ("displacement_share", offset_of!(Frame, displacement_share)),
        ("liveliness", offset_of!(Frame, liveliness)),
    ];
    assert_eq!((frame, size), (named(&host), size_of::<Frame>()));
}
