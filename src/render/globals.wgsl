// What every pass of the picture shares. Colours are linear RGB. Host twin: `Globals` in globals.rs.
struct Globals {
    clip_from_world: mat4x4f,
    key_from_world: mat4x4f,
    below_from_world: mat4x4f,
    eye: vec3f,
    // Metres across a texel of the key light's map.
    key_texel: f32,
    // Unit vector towards the key light.
    key_direction: vec3f,
    // Metres from the near to the far plane of the key light's map.
    key_depth: f32,
    key_colour: vec3f,
    // Metres across the map from beneath.
    below_width: f32,
    sky_colour: vec3f,
    floor_radius: f32,
    bounce_colour: vec3f,
    // How dark the floor gets where no key light falls.
    shadow_strength: f32,
    rim_colour: vec3f,
    // The floor's centre, metres.
    floor_x: f32,
    floor_colour: vec3f,
    floor_z: f32,
    backdrop_low: vec3f,
    backdrop_opacity: f32,
    backdrop_high: vec3f,
    // What the figure's colours tell: one of the numbers in figure.wgsl.
    view: u32,
}

@group(0) @binding(0) var<uniform> globals: Globals;
@group(0) @binding(1) var key_map: texture_depth_2d;
// The same map for reading single texels: WebGL2 has one kind of access for each texture.
@group(0) @binding(2) var key_depths: texture_2d<f32>;
@group(0) @binding(3) var below_depths: texture_2d<f32>;
@group(0) @binding(4) var nearer: sampler_comparison;

const GOLDEN_ANGLE = 2.39996323;

// Point `i` of `count` spread evenly over the unit disc (Vogel's spiral), turned by `turn` radians.
fn vogel_disc(i: u32, count: u32, turn: f32) -> vec2f {
    let radius = sqrt((f32(i) + 0.5) / f32(count));
    let angle = f32(i) * GOLDEN_ANGLE + turn;
    return radius * vec2f(cos(angle), sin(angle));
}

// A different angle for neighbouring pixels: interleaved gradient noise (Jimenez 2014).
fn pixel_turn(pixel: vec2f) -> f32 {
    return 6.2831853 * fract(52.9829189 * fract(dot(pixel, vec2f(0.06711056, 0.00583715))));
}

fn texture_space(clip: vec2f) -> vec2f {
    return clip * vec2f(0.5, -0.5) + 0.5;
}

fn load_depth(map: texture_2d<f32>, place: vec2f) -> f32 {
    let size = vec2f(textureDimensions(map));
    return textureLoad(map, vec2u(clamp(place * size, vec2f(0.0), size - 1.0)), 0).x;
}

// Share of the key light that reaches `position` (metres): the further the blocker, the softer the shadow (Fernando 2005, PCSS).
fn key_visibility(position: vec3f, pixel: vec2f, softest: f32) -> f32 {
    let clip = (globals.key_from_world * vec4f(position, 1.0)).xyz;
    if any(abs(clip.xy) > vec2f(1.0)) {
        return 1.0;
    }
    let place = texture_space(clip.xy);
    let depth = min(clip.z, 1.0);
    let texel = 1.0 / f32(textureDimensions(key_map).x);
    let turn = pixel_turn(pixel);
    let share_of_metre = texel / globals.key_texel;
    let search = 0.5 * softest * share_of_metre;
    var gap = 0.0;
    var blockers = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let blocker = load_depth(key_depths, place + search * vogel_disc(i, 8u, turn));
        if blocker < depth {
            gap += depth - blocker;
            blockers += 1.0;
        }
    }
    if blockers == 0.0 {
        return 1.0;
    }
    let penumbra = clamp(0.07 * gap / blockers * globals.key_depth, 3.0 * globals.key_texel, softest);
    var visible = 0.0;
    for (var i = 0u; i < 16u; i++) {
        let tap = place + penumbra * share_of_metre * vogel_disc(i, 16u, turn);
        visible += textureSampleCompareLevel(key_map, nearer, tap, depth);
    }
    return visible / 16.0;
}

// Share of the sky that the figure's lowest parts leave to a point on the floor.
fn floor_openness(position: vec3f, pixel: vec2f) -> f32 {
    let clip = (globals.below_from_world * vec4f(position, 1.0)).xy;
    if any(abs(clip) > vec2f(1.0)) {
        return 1.0;
    }
    let place = texture_space(clip);
    let reach = 0.16 / globals.below_width;
    let turn = pixel_turn(pixel);
    var closed = 0.0;
    for (var i = 0u; i < 16u; i++) {
        let offset = vogel_disc(i, 16u, turn);
        let height = load_depth(below_depths, place + reach * offset);
        let near = 1.0 - height;
        closed += near * near * near * (1.0 - 0.7 * length(offset));
    }
    return 1.0 - min(closed / 7.0, 1.0);
}

// sRGB's transfer function. Shaders encode by themselves: resolving samples into an sRGB view of another format is not reliable.
fn encode_srgb(linear: vec3f) -> vec3f {
    let colour = saturate(linear);
    return select(1.055 * pow(colour, vec3f(1.0 / 2.4)) - 0.055, 12.92 * colour, colour <= vec3f(0.0031308));
}

// Khronos' PBR Neutral tone mapping: keeps hues and mid-tones, compresses highlights only.
fn tone_map(linear: vec3f) -> vec3f {
    let darkest = min(linear.r, min(linear.g, linear.b));
    let lift = select(0.04, darkest - 6.25 * darkest * darkest, darkest < 0.08);
    let colour = linear - lift;
    let peak = max(colour.r, max(colour.g, colour.b));
    let start = 0.76;
    if peak < start {
        return colour;
    }
    let room = 1.0 - start;
    let compressed = 1.0 - room * room / (peak + room - start);
    let whiteness = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0);
    return mix(colour * compressed / peak, vec3f(compressed), whiteness);
}
