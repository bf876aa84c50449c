// The viewport: surfaces in all shading modes, lines, points, background and overlay.
//
// Positions are relative to the object's origin and are transformed directly to clip space, so that
// scenes far from the world origin do not jitter. Depth is reversed: near / distance. Output
// colours are sRGB, because egui displays the texture as it is.

struct Frame {
    size: vec2f,
    near: f32,
    // 0 linear, 1 Reinhard, 2 filmic.
    tone: f32,
    // Up in view space.
    up: vec3f,
    exposure: f32,
    // Lower and upper background colours, sRGB.
    lower: vec3f,
    // 0 gradient, 1 image with borders, 2 single image, 3 tiled image.
    backdrop: f32,
    upper: vec3f,
    // The luminance that Reinhard's curve maps to white.
    white: f32,
    // Pixels to texture coordinates of the background image: factor, offset.
    picture: vec4f,
    fog: vec3f,
    // 0 none, 1 exponential, 2 linear.
    fog_kind: f32,
    visibility: f32,
    // Ends of the colour scale; their logarithms if it is logarithmic.
    low: f32,
    high: f32,
    // Distance of isolines, or 1 or 0.3 on a logarithmic scale; 0 for none.
    interval: f32,
    line: vec4f,
    // World from view for directions, columns.
    world_x: vec4f,
    world_y: vec4f,
    world_z: vec4f,
    is_logarithmic: f32,
    // 1 for the luminance, 0 for the mean of the channels.
    is_luminance: f32,
    // Largest channel of the fog's colour: without exposure, fog is a normalized colour.
    fog_scale: f32,
    // Irradiance that the stored value 1 of the lightmap stands for.
    lightmap_scale: f32,
    // Factor from stored to displayed values.
    display: f32,
    // Factor of the linear colours of the background image.
    picture_gain: f32,
    // Plane in view space beyond which everything is cut away: normal and distance.
    section: vec4f,
}

struct Object {
    clip_from_object: mat4x4f,
    view_from_object: mat4x4f,
    // The inverse transpose, for normals.
    view_from_normal: mat4x4f,
    // sRGB colour and weight of the selection, for edges and points.
    tint: vec4f,
    light_scale: f32,
    is_solved: f32,
    has_normals: f32,
    is_mirrored: f32,
}

struct Material {
    diffuse: vec3f,
    gloss: f32,
    emission: vec3f,
    emits_back: f32,
    mirror: vec3f,
    opacity: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var backdrop: texture_2d<f32>;
@group(0) @binding(2) var backdrop_sampler: sampler;
@group(0) @binding(3) var color_map: texture_2d<f32>;
@group(0) @binding(4) var color_map_sampler: sampler;
@group(0) @binding(5) var lightmap: texture_2d_array<f32>;
@group(1) @binding(0) var<uniform> object: Object;
@group(2) @binding(0) var<uniform> material: Material;
@group(3) @binding(0) var surface_texture: texture_2d<f32>;
@group(3) @binding(1) var surface_sampler: sampler;

struct Varying {
    @builtin(position) @invariant clip: vec4f,
    // In view space.
    @location(0) place: vec3f,
    @location(1) normal: vec3f,
    @location(2) light: vec4f,
    @location(3) color: vec3f,
    @location(4) uv: vec2f,
    // Place in the lightmap, and 1 more than the page; 0 for none.
    @location(5) spot: vec3f,
}

// ---------------------------------------------------------------- vertex shaders

fn unfolded(e: vec2f) -> vec3f {
    let z = 1.0 - abs(e.x) - abs(e.y);
    let side = select(vec2f(-1.0), vec2f(1.0), e >= vec2f(0.0));
    let xy = select(e, (1.0 - abs(e.yx)) * side, z < 0.0);
    return vec3f(xy, z);
}

@vertex
fn surface(
    @location(0) position: vec3f,
    @location(1) normal: vec2f,
    @location(2) light: vec4f,
    @location(3) color: vec4f,
    @location(4) uv: vec2f,
    @location(5) spot: vec3f,
) -> Varying {
    var out: Varying;
    out.clip = object.clip_from_object * vec4f(position, 1.0);
    out.place = (object.view_from_object * vec4f(position, 1.0)).xyz;
    out.normal = (object.view_from_normal * vec4f(unfolded(normal), 0.0)).xyz;
    out.light = vec4f(light.rgb * object.light_scale, light.a);
    out.color = color.rgb;
    out.uv = vec2f(uv.x, 1.0 - uv.y);
    out.spot = spot;
    return out;
}

struct Placed {
    @builtin(position) @invariant clip: vec4f,
    // In view space.
    @location(0) place: vec3f,
}

fn placed(position: vec3f) -> Placed {
    var out: Placed;
    out.clip = object.clip_from_object * vec4f(position, 1.0);
    out.place = (object.view_from_object * vec4f(position, 1.0)).xyz;
    return out;
}

@vertex
fn edge(@location(0) position: vec3f) -> Placed {
    var out = placed(position);
    // A little nearer than the faces that share the edge.
    out.clip.z *= 1.0002;
    return out;
}

@vertex
fn same_place(@location(0) position: vec3f) -> Placed {
    return placed(position);
}

@vertex
fn dot_corner(
    @builtin(vertex_index) corner: u32,
    @location(0) position: vec3f,
) -> Placed {
    var out = placed(position);
    let side = vec2f(f32(corner & 1u), f32(corner >> 1u)) - 0.5;
    let clip = out.clip;
    out.clip = vec4f(clip.xy + side * 6.0 / frame.size * clip.w, clip.z, clip.w);
    return out;
}

@vertex
fn whole_picture(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    let x = f32(corner & 1u) * 4.0 - 1.0;
    let y = f32(corner >> 1u) * 4.0 - 1.0;
    return vec4f(x, y, 0.0, 1.0);
}

struct Inked {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
}

@vertex
fn inked(@location(0) clip: vec4f, @location(1) color: vec4f) -> Inked {
    return Inked(clip, color);
}

// ---------------------------------------------------------------- light and colours

fn srgb(linear: vec3f) -> vec3f {
    let x = clamp(linear, vec3f(0.0), vec3f(1.0));
    let curved = 1.055 * pow(max(x, vec3f(1e-6)), vec3f(1.0 / 2.4)) - 0.055;
    return select(curved, 12.92 * x, x <= vec3f(0.0031308));
}

fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

fn tone_mapped(radiance: vec3f) -> vec3f {
    let c = clamp(radiance * frame.exposure, vec3f(0.0), vec3f(1e30));
    if frame.tone < 0.5 {
        return c;
    }
    if frame.tone < 1.5 {
        // This order avoids overflow.
        let l = luminance(c);
        return c / (1.0 + l) + c * ((l / (1.0 + l)) / (frame.white * frame.white));
    }
    let x = min(0.6 * c, vec3f(1e6));
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

fn facet_normal(place: vec3f) -> vec3f {
    let n = cross(dpdx(place), dpdy(place));
    let length2 = dot(n, n);
    let unit = n * inverseSqrt(max(length2, 1e-37));
    let seen = select(vec3f(0.0, 0.0, 1.0), unit, length2 > 1e-37);
    return select(seen, -seen, dot(seen, place) > 0.0);
}

fn is_front(front_facing: bool) -> bool {
    return front_facing != (object.is_mirrored > 0.5);
}

// The shading normal on the visible side.
fn smooth_normal(in: Varying, front: bool) -> vec3f {
    let flat_normal = facet_normal(in.place);
    let length2 = dot(in.normal, in.normal);
    if object.has_normals < 0.5 || length2 < 1e-20 {
        return flat_normal;
    }
    let n = in.normal * inverseSqrt(length2);
    return select(-n, n, front);
}

fn transmittance(place: vec3f) -> f32 {
    if frame.fog_kind < 0.5 {
        return 1.0;
    }
    let distance = length(place);
    let left = frame.visibility - distance;
    if left <= 0.0 {
        return 0.0;
    }
    return select(left / frame.visibility, exp(-distance / left), frame.fog_kind < 1.5);
}

// Blends a colour with fog, in modes without exposure.
fn in_fog(color: vec3f, place: vec3f) -> vec3f {
    return mix(frame.fog / frame.fog_scale, color, transmittance(place));
}

fn emitted(front: bool) -> vec3f {
    return select(vec3f(0.0), material.emission, front || material.emits_back > 0.5);
}

// What a mirror or a highlight would reflect under a pale sky.
fn hint(n: vec3f, place: vec3f) -> vec3f {
    let v = normalize(-place);
    let away = reflect(-v, n);
    let sky = mix(0.12, 0.9, smoothstep(-0.4, 0.6, dot(away, frame.up)));
    let highlight = pow(max(dot(away, v), 0.0), 30.0);
    return material.mirror * sky + vec3f(material.gloss * highlight);
}

// Linear colour under a headlight and a soft sky. The headlight is a little above the left
// shoulder, so that faces which face the camera differ in brightness.
fn lamp_at_eye(base: vec3f, n: vec3f, place: vec3f, front: bool) -> vec3f {
    let lamp = normalize(normalize(-place) + vec3f(-0.35, 0.3, 0.0));
    let facing = max(dot(n, lamp), 0.0);
    let sky = 0.5 + 0.5 * dot(n, frame.up);
    let e = material.emission;
    let most = max(e.r, max(e.g, e.b));
    let hue = e / max(most, 1e-30);
    // The back of an emitter and black surfaces must remain visible.
    let matt = base + 0.1 * hue + 0.015;
    let c = matt * (0.12 + 0.28 * sky + 0.6 * facing) + hint(n, place);
    return select(c, hue, any(emitted(front) > vec3f(0.0)));
}

// Dims and hatches surfaces without a solution.
fn hatched(color: vec3f, clip: vec4f) -> vec3f {
    let pale = mix(vec3f(luminance(color)), color, 0.35) * 0.7;
    let stripe = fract((clip.x + clip.y) / 10.0);
    return pale * select(1.0, 0.6, stripe < 0.25);
}

// Discards what lies beyond the section. At the end of a shader, as derivatives need all pixels.
fn cut(place: vec3f) {
    if dot(frame.section.xyz, place) > frame.section.w {
        discard;
    }
}

fn seen(color: vec3f, place: vec3f) -> vec4f {
    cut(place);
    return vec4f(color, material.opacity);
}

// In modes that display values, glass is opaque.
fn opaque(color: vec3f, place: vec3f) -> vec4f {
    cut(place);
    return vec4f(color, 1.0);
}

fn number_of(light: vec3f) -> f32 {
    let mean = (light.r + light.g + light.b) / 3.0;
    return select(mean, luminance(light), frame.is_luminance > 0.5);
}

// Position on the colour scale, not clamped.
fn place_on_scale(x: f32) -> f32 {
    let y = select(x, log(max(x, 1e-37)), frame.is_logarithmic > 0.5);
    return (y - frame.low) / max(frame.high - frame.low, 1e-37);
}

fn mapped(t: f32) -> vec3f {
    let u = (clamp(t, 0.0, 1.0) * 255.0 + 0.5) / 256.0;
    return textureSample(color_map, color_map_sampler, vec2f(u, 0.5)).rgb;
}

// Isolines at round values: at multiples of the interval, or at powers of ten, or at 1, 2 and 5
// times powers of ten.
fn with_isolines(color: vec3f, value: f32, t: f32) -> vec3f {
    let is_log = frame.is_logarithmic > 0.5;
    let decades = log(max(value * frame.display, 1e-37)) * 0.4342944819;
    let x = select(value / max(frame.interval, 1e-37), decades, is_log);
    // Dividing by the screen-space derivative of x gives lines of constant width.
    let width = max(fwidth(x), 1e-12);
    let part = fract(x);
    let whole = min(part, 1.0 - part);
    let between = min(abs(part - 0.30103), abs(part - 0.69897));
    let has_between = is_log && frame.interval < 0.9;
    let distance = select(whole, min(whole, between), has_between) / width;
    let is_inside = frame.interval > 0.0 && t > 0.005 && t < 0.995;
    let weight = select(0.0, 1.0 - smoothstep(0.6, 1.4, distance), is_inside && width < 0.5);
    let contrast = select(vec3f(1.0), vec3f(0.0), luminance(color) > 0.35);
    return mix(color, contrast, 0.8 * weight);
}

// ---------------------------------------------------------------- fragment shaders

fn background_at(pixel: vec2f) -> vec3f {
    let uv = pixel * frame.picture.xy + frame.picture.zw;
    // Without tiling, opposite edges must not blend.
    let half_texel = 0.5 / vec2f(textureDimensions(backdrop));
    let once = clamp(uv, half_texel, 1.0 - half_texel);
    let place = select(once, uv, frame.backdrop > 2.5);
    let texel = textureSample(backdrop, backdrop_sampler, place).rgb;
    let picture = srgb(frame.picture_gain * texel);
    let plain = mix(frame.upper, frame.lower, pixel.y / frame.size.y);
    let inside = all(uv >= vec2f(0.0)) && all(uv <= vec2f(1.0));
    let shows = frame.backdrop > 1.5 || (frame.backdrop > 0.5 && inside);
    return select(plain, picture, shows);
}

@fragment
fn background(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    return vec4f(background_at(clip.xy), 1.0);
}

@fragment
fn flat_shade(in: Varying, @builtin(front_facing) facing: bool) -> @location(0) vec4f {
    let n = facet_normal(in.place);
    let c = lamp_at_eye(material.diffuse * in.color, n, in.place, is_front(facing));
    return seen(srgb(in_fog(c, in.place)), in.place);
}

@fragment
fn gouraud(in: Varying, @builtin(front_facing) facing: bool) -> @location(0) vec4f {
    let front = is_front(facing);
    let n = smooth_normal(in, front);
    let c = lamp_at_eye(material.diffuse * in.color, n, in.place, front);
    return seen(srgb(in_fog(c, in.place)), in.place);
}

@fragment
fn textured(in: Varying, @builtin(front_facing) facing: bool) -> @location(0) vec4f {
    let front = is_front(facing);
    let n = smooth_normal(in, front);
    let paint = textureSample(surface_texture, surface_sampler, in.uv).rgb;
    let c = lamp_at_eye(material.diffuse * in.color * paint, n, in.place, front);
    return seen(srgb(in_fog(c, in.place)), in.place);
}

struct Light {
    irradiance: vec3f,
    is_known: bool,
}

// Irradiance from the lightmap, which both sides show, or of the vertices, which is known on front sides.
fn light_of(in: Varying, front: bool) -> Light {
    if in.spot.z > 0.5 {
        let half_texel = 0.5 / vec2f(textureDimensions(lightmap));
        let place = clamp(in.spot.xy, half_texel, 1.0 - half_texel);
        let page = i32(round(in.spot.z)) - 1;
        let stored = textureSampleLevel(lightmap, color_map_sampler, place, page, 0.0);
        return Light(stored.rgb * frame.lightmap_scale, true);
    }
    return Light(in.light.rgb, object.is_solved > 0.5 && in.light.a > 0.5 && front);
}

// The display colour of the radiance leaving a matt surface.
fn lit(in: Varying, paint: vec3f, n: vec3f, front: bool) -> vec3f {
    let rho = material.diffuse * in.color * paint;
    // Glass has no irradiance to display on either side.
    let light = light_of(in, front || material.opacity < 1.0);
    let radiance = emitted(front) + rho * light.irradiance * 0.31830988618;
    let through = transmittance(in.place);
    let c = tone_mapped(mix(frame.fog, radiance, through));
    let shown = srgb(max(c, through * 0.25 * hint(n, in.place)));
    let lamp = in_fog(lamp_at_eye(rho, n, in.place, front), in.place);
    let shines = any(emitted(front) > vec3f(0.0));
    return select(hatched(srgb(lamp), in.clip), shown, light.is_known || shines);
}

@fragment
fn irradiance(in: Varying, @builtin(front_facing) facing: bool) -> @location(0) vec4f {
    let front = is_front(facing);
    let n = smooth_normal(in, front);
    let paint = textureSample(surface_texture, surface_sampler, in.uv).rgb;
    return seen(lit(in, paint, n, front), in.place);
}

// Faces with one value each: no normals, no textures.
@fragment
fn patches(in: Varying, @builtin(front_facing) facing: bool) -> @location(0) vec4f {
    let n = facet_normal(in.place);
    return opaque(lit(in, vec3f(1.0), n, is_front(facing)), in.place);
}

fn scaled(in: Varying, x: f32, known: bool, has_lines: bool) -> vec4f {
    let n = facet_normal(in.place);
    let t = place_on_scale(x);
    let plain = mapped(t);
    let lined = with_isolines(plain, x, t);
    let grey = hatched(srgb(lamp_at_eye(vec3f(0.6), n, in.place, false)), in.clip);
    return opaque(select(grey, select(plain, lined, has_lines), known), in.place);
}

@fragment
fn false_color(in: Varying, @builtin(front_facing) facing: bool) -> @location(0) vec4f {
    let light = light_of(in, is_front(facing));
    return scaled(in, number_of(light.irradiance), light.is_known, true);
}

// The position on the scale in 16 bits, red and green, and in blue whether there is light.
@fragment
fn packed(in: Varying, @builtin(front_facing) facing: bool) -> @location(0) vec4f {
    let light = light_of(in, is_front(facing));
    let t = round(clamp(place_on_scale(number_of(light.irradiance)), 0.0, 1.0) * 65535.0);
    let high = floor(t / 256.0);
    let color = vec3f(high, t - 256.0 * high, select(0.0, 255.0, light.is_known)) / 255.0;
    return opaque(color, in.place);
}

// Values of faces apply to both sides.
@fragment
fn face_number(in: Varying) -> @location(0) vec4f {
    return scaled(in, in.light.r, object.is_solved > 0.5 && in.light.a > 0.5, false);
}

@fragment
fn directions(in: Varying, @builtin(front_facing) facing: bool) -> @location(0) vec4f {
    let front = is_front(facing);
    let n = smooth_normal(in, front);
    let world = frame.world_x.xyz * n.x + frame.world_y.xyz * n.y + frame.world_z.xyz * n.z;
    let shade = 0.4 + 0.6 * max(dot(n, normalize(-in.place)), 0.0);
    let color = select(vec3f(0.85, 0.08, 0.08) * shade, 0.5 + 0.5 * world, front);
    return opaque(color, in.place);
}

@fragment
fn hidden(in: Placed) -> @location(0) vec4f {
    let color = background_at(in.clip.xy);
    cut(in.place);
    return vec4f(color, 1.0);
}

@fragment
fn line(in: Placed) -> @location(0) vec4f {
    cut(in.place);
    return vec4f(mix(frame.line.rgb, object.tint.rgb, object.tint.a), frame.line.a);
}

// The mask of the selection.
@fragment
fn marked(in: Placed) -> @location(0) vec4f {
    cut(in.place);
    return vec4f(1.0);
}

@fragment
fn ink(in: Inked) -> @location(0) vec4f {
    return in.color;
}
