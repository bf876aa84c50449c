// A line around what is selected: a mask of it is drawn first, then pixels beside it are coloured.
// The colours of the selection itself, which one judges, stay as they are.

@group(0) @binding(0) var<uniform> color: vec4f;
@group(0) @binding(1) var mask: texture_2d<f32>;

@vertex
fn whole_picture(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    let x = f32(corner & 1u) * 4.0 - 1.0;
    let y = f32(corner >> 1u) * 4.0 - 1.0;
    return vec4f(x, y, 0.0, 1.0);
}

// Width of the line and of the dark seam around it, which shows it before any colour, pixels.
const LINE: f32 = 2.0;
const SEAM: f32 = 3.0;

@fragment
fn outline(@builtin(position) clip: vec4f) -> @location(0) vec4f {
    let here = vec2i(clip.xy);
    let last = vec2i(textureDimensions(mask)) - 1;
    if textureLoad(mask, here, 0).r > 0.5 {
        discard;
    }
    var nearest = SEAM + 1.0;
    for (var dy = -3; dy <= 3; dy++) {
        for (var dx = -3; dx <= 3; dx++) {
            let there = clamp(here + vec2i(dx, dy), vec2i(0), last);
            let distance = length(vec2f(f32(dx), f32(dy)));
            if distance < nearest && textureLoad(mask, there, 0).r > 0.5 {
                nearest = distance;
            }
        }
    }
    if nearest > SEAM + 0.5 {
        discard;
    }
    let is_line = nearest < LINE + 0.5;
    return select(vec4f(0.0, 0.0, 0.0, 0.45), vec4f(color.rgb, 1.0), is_line);
}
