// Draws the facets of a world into one face of a hemicube: each pixel gets the visible side and
// patch. A face is an image whose points (u, v) lie in the direction u x + v y + w.

struct Face {
    // The viewpoint, and the remainder beyond single precision.
    eye: vec4f,
    eye_rest: vec4f,
    // Axes of the face in the world: x along the columns, y along the rows, w through the middle.
    x: vec4f,
    y: vec4f,
    w: vec4f,
    // 1/w of the plane behind which a reflected world begins: coefficients of u, v and 1.
    begin: vec4f,
    // Origin of the face in the atlas, the scale from pixels to u and v, and v of the first row's
    // edge.
    origin: vec4f,
    // Clip coordinate y is `rows.x` w + `rows.y` v; `rows.z` is the nearest w.
    rows: vec4f,
    // The window's number, and the mirror behind which it is.
    numbers: vec4u,
}

@group(0) @binding(0) var<uniform> face: Face;
// The number of the window of each pixel of the atlas.
@group(1) @binding(0) var windows: texture_2d<u32>;

struct Corner {
    @builtin(position) position: vec4f,
    // 1/w of the facet's plane: coefficients of u, v and 1.
    @location(0) @interpolate(flat, either) nearness: vec3f,
    // Side of the patch; mirror.
    @location(1) @interpolate(flat, either) ids: vec2u,
}

@vertex
fn corner(
    @location(0) position: vec3f,
    @location(1) plane: vec4f,
    @location(2) ids: vec2u,
) -> Corner {
    // The first difference is exact for points near the viewpoint, so they keep their precision.
    let p = (position - face.eye.xyz) - face.eye_rest.xyz;
    let seen = vec3f(dot(p, face.x.xyz), dot(p, face.y.xyz), dot(p, face.w.xyz));
    // n · (eye + w d) = offset, so 1/w = n · d / away. It comes from the plane and not from the
    // corners, so coplanar facets have equal depths on every card.
    let n = plane.xyz;
    let away = (plane.w - dot(n, face.eye.xyz)) - dot(n, face.eye_rest.xyz);
    let along = vec3f(dot(n, face.x.xyz), dot(n, face.y.xyz), dot(n, face.w.xyz));
    var corner: Corner;
    let y = face.rows.x * seen.z + face.rows.y * seen.y;
    // A constant z clips nearer points; the depth is set by the fragment shader.
    corner.position = vec4f(seen.x, y, face.rows.z, seen.z);
    corner.nearness = along / away;
    // The lowest bit of the side is set if the plane's normal points to the back.
    let is_behind = u32(away > 0.0) ^ (ids.x & 1u);
    corner.ids = vec2u((ids.x & 0xfffffffeu) | is_behind, ids.y);
    return corner;
}

struct Pixel {
    @location(0) side: u32,
    @builtin(frag_depth) depth: f32,
}

// With the nearness, if distances are requested.
struct FarPixel {
    @location(0) side: u32,
    @location(1) nearness: u32,
    @builtin(frag_depth) depth: f32,
}

fn image_point(position: vec4f) -> vec3f {
    let uv = (position.xy - face.origin.xy) * face.origin.z;
    return vec3f(uv.x - 1.0, uv.y + face.origin.w, 1.0);
}

// Nearness of a pixel of the facet; that of an edge-on facet is mere rounding.
fn nearness(corner: Corner) -> f32 {
    let near = dot(corner.nearness, image_point(corner.position));
    if !(near > 0.0 && near < 1e9) {
        discard;
    }
    return near;
}

// The same, restricted to this window and to points behind its mirror.
fn nearness_in_window(corner: Corner) -> f32 {
    let place = vec2i(corner.position.xy);
    let near = nearness(corner);
    let is_here = textureLoad(windows, place, 0).r == face.numbers.x;
    let begin = dot(face.begin.xyz, image_point(corner.position));
    if !is_here || near > begin || corner.ids.y == face.numbers.y {
        discard;
    }
    return near;
}

fn depth(near: f32) -> f32 {
    return min(near * face.rows.w, 1.0);
}

@fragment
fn straight(corner: Corner) -> Pixel {
    return Pixel(corner.ids.x, depth(nearness(corner)));
}

@fragment
fn straight_far(corner: Corner) -> FarPixel {
    let near = nearness(corner);
    return FarPixel(corner.ids.x, bitcast<u32>(near), depth(near));
}

@fragment
fn window(corner: Corner) -> Pixel {
    return Pixel(corner.ids.x, depth(nearness_in_window(corner)));
}

@fragment
fn window_far(corner: Corner) -> FarPixel {
    let near = nearness_in_window(corner);
    return FarPixel(corner.ids.x, bitcast<u32>(near), depth(near));
}
