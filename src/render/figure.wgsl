// The figure: cloth under a key light, sky, bounce and rim.
@group(1) @binding(1) var albedo: texture_2d<f32>;
@group(1) @binding(2) var albedo_sampler: sampler;

// What the surface's colours tell. Host twin: `View`.
const VIEW_WIREFRAME = 1u;
const VIEW_NORMALS = 2u;
const VIEW_VALUES = 3u;

// Values from minus this to this, 1/m, take the whole scale of colours.
const VALUE_RANGE = 10.0;
// The mesh's edges lie nearer to the eye by this share of the way, so that they are seen.
const LINE_LIFT = 2e-3;

struct Fragment {
    @builtin(position) pixel: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) texture_coordinates: vec2f,
    @location(3) colour: vec3f,
    @location(4) value: f32,
}

@vertex
fn vertex(
    @location(0) body_vertex: u32,
    @location(1) texture_coordinates: vec2f,
    @location(2) colour: vec4f,
) -> Fragment {
    return figure_fragment(body_vertex, texture_coordinates, colour);
}

fn figure_fragment(body_vertex: u32, texture_coordinates: vec2f, colour: vec4f) -> Fragment {
    let packed = figure_vertex(body_vertex);
    let position = unpack_position(packed);
    return Fragment(
        globals.clip_from_world * vec4f(position, 1.0),
        position,
        unpack_normal(packed),
        texture_coordinates,
        colour.rgb,
        bitcast<f32>(packed.w),
    );
}

@vertex
fn line_vertex(
    @location(0) body_vertex: u32,
    @location(1) texture_coordinates: vec2f,
    @location(2) colour: vec4f,
) -> Fragment {
    var out = figure_fragment(body_vertex, texture_coordinates, colour);
    out.pixel = globals.clip_from_world * vec4f(mix(out.position, globals.eye, LINE_LIFT), 1.0);
    return out;
}

@fragment
fn line_fragment(in: Fragment) -> @location(0) vec4f {
    return vec4f(0.10, 0.14, 0.24, 1.0);
}

// White at nothing, red above, blue below.
fn value_colour(value: f32) -> vec3f {
    let share = clamp(value / VALUE_RANGE, -1.0, 1.0);
    let extreme = select(vec3f(0.05, 0.16, 0.62), vec3f(0.62, 0.04, 0.08), share > 0.0);
    return mix(vec3f(0.82), extreme, sqrt(abs(share)));
}

// What has no light of its own is shaded a little by how it faces the eye.
fn value_view(in: Fragment) -> vec4f {
    let across = cross(dpdx(in.position), dpdy(in.position));
    let facing = abs(dot(normalize(across), normalize(globals.eye - in.position)));
    return vec4f(encode_srgb(value_colour(in.value) * mix(0.45, 1.0, facing)), 1.0);
}

// Light wraps this far round, as it does through threads and fuzz.
const WRAP = 0.18;

@fragment
fn fragment(in: Fragment) -> @location(0) vec4f {
    let cloth = in.colour * textureSample(albedo, albedo_sampler, in.texture_coordinates).rgb;
    let values = value_view(in);
    if globals.view == VIEW_VALUES {
        return values;
    }
    let normal = normalize(in.normal);
    if globals.view == VIEW_NORMALS {
        return vec4f(0.5 + 0.5 * normal, 1.0);
    }
    let base = select(cloth, vec3f(0.62), globals.view == VIEW_WIREFRAME);
    let to_eye = normalize(globals.eye - in.position);
    let facing = saturate(dot(normal, to_eye));
    let towards_key = dot(normal, globals.key_direction);

    // Off the surface by more where the light grazes, so that a texel does not shade itself.
    let bias = globals.key_texel * (1.5 + 2.5 * (1.0 - saturate(towards_key)));
    let lifted = in.position + bias * (normal + 0.5 * globals.key_direction);
    let visible = key_visibility(lifted, in.pixel.xy, 0.03);
    let key = saturate((towards_key + WRAP) / (1.0 + WRAP)) * mix(1.0, visible, saturate(8.0 * (towards_key + WRAP)));

    let sky = 0.5 + 0.5 * normal.y;
    // The nearer the floor, the less sky.
    let height = saturate(in.position.y / 0.9);
    let ambient = mix(globals.bounce_colour, globals.sky_colour, sky) * mix(0.72, 1.0, height);

    let edge = 1.0 - facing;
    let edge_squared = edge * edge;
    let back = saturate(0.55 - 0.8 * dot(normal, globals.key_direction));
    let rim = edge_squared * edge * back * (0.35 + 0.65 * sky);
    let sheen = 0.16 * edge_squared * edge_squared;

    // A broad, faint highlight (Blinn-Phong): cloth is never quite matt.
    let half_way = normalize(globals.key_direction + to_eye);
    let gloss = 0.035 * pow(saturate(dot(normal, half_way)), 18.0) * key;

    let light = globals.key_colour * key + ambient;
    let colour = base * light * 0.78 + (sheen * light + gloss * globals.key_colour) * (0.25 + 0.75 * base)
        + rim * globals.rim_colour * (0.2 + 0.8 * base);
    return vec4f(encode_srgb(tone_map(colour)), 1.0);
}
