// The picture behind the figure: a gradient, and a disc of floor that fades into it and takes the shadows. Colours are premultiplied by
// their opacity.

struct Sky {
    @builtin(position) pixel: vec4f,
    // -1 at the bottom of the picture, 1 at the top.
    @location(0) height: f32,
}

fn backdrop(height: f32) -> vec3f {
    return mix(globals.backdrop_low, globals.backdrop_high, smoothstep(-0.9, 1.0, height));
}

// Half a step of an 8-bit channel either way, so that the gradient shows no bands.
fn dither(pixel: vec2f) -> f32 {
    return (pixel_turn(pixel) / 6.2831853 - 0.5) / 255.0;
}

@vertex
fn sky_vertex(@builtin(vertex_index) index: u32) -> Sky {
    let corner = vec2f(vec2u((index << 1u) & 2u, index & 2u)) * 2.0 - 1.0;
    return Sky(vec4f(corner, 1.0, 1.0), corner.y);
}

@fragment
fn sky_fragment(in: Sky) -> @location(0) vec4f {
    let colour = backdrop(in.height);
    return vec4f(encode_srgb(colour) + dither(in.pixel.xy), 1.0) * globals.backdrop_opacity;
}

struct Floor {
    @builtin(position) pixel: vec4f,
    @location(0) position: vec3f,
}

@vertex
fn floor_vertex(@builtin(vertex_index) index: u32) -> Floor {
    let corner = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0 - 1.0;
    let centre = vec2f(globals.floor_x, globals.floor_z);
    let place = centre + globals.floor_radius * corner;
    let position = vec3f(place.x, 0.0, place.y);
    return Floor(globals.clip_from_world * vec4f(position, 1.0), position);
}

@fragment
fn floor_fragment(in: Floor) -> @location(0) vec4f {
    let away = in.position.xz - vec2f(globals.floor_x, globals.floor_z);
    let share = length(away) / globals.floor_radius;
    // A pool of light that has faded into the backdrop well before the floor ends.
    let fade = exp(-7.0 * share * share) * (1.0 - smoothstep(0.7, 1.0, share));
    let visible = key_visibility(in.position, in.pixel.xy, 0.12);
    let open = floor_openness(in.position, in.pixel.xy);
    let light = mix(1.0, visible, globals.shadow_strength) * mix(1.0, open, globals.shadow_strength);
    let colour = globals.floor_colour * light;
    // Where the backdrop lets the page through, the floor does, too, and only its shadow stays.
    let opacity = mix((1.0 - light) * fade, fade, globals.backdrop_opacity);
    return vec4f((encode_srgb(colour) + dither(in.pixel.xy)) * fade * globals.backdrop_opacity, opacity);
}
