// What a frame is asked for, uploaded once. Host twin: `Frame` in frame.rs.
struct Joint {
    // Columns are the rows of the transform from the rest pose.
    posed_from_rest: mat3x4f,
    // Relative to the parent.
    rotation: mat3x3f,
    // The same as axis-angle numbers, radians.
    angles: vec3f,
}

struct Frame {
    joints: array<Joint, 32>,
    // 0 is the base, 1 as trained.
    detail: f32,
    // 1 with the offsets of f_d, 0 for the bare body.
    offset_share: f32,
    // 1 where f_l is the surface's Laplacian, 0 where it is added to the base's.
    base_share: f32,
    // 1 for the detailed mesh, 0 for the base.
    displacement_share: f32,
    // What poses far from training wear: 0 the likeliest, 1 what the nearest training poses do.
    liveliness: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
