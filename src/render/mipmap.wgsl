// Halves a texture: one triangle over the target, one bilinear tap between four texels of the source.
@group(0) @binding(0) var source: texture_2d<f32>;
@group(0) @binding(1) var source_sampler: sampler;

struct Pixel {
    @builtin(position) pixel: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Pixel {
    let corner = vec2f(vec2u((index << 1u) & 2u, index & 2u));
    return Pixel(vec4f(corner * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0), corner);
}

@fragment
fn fragment(in: Pixel) -> @location(0) vec4f {
    return textureSampleLevel(source, source_sampler, in.place, 0.0);
}
