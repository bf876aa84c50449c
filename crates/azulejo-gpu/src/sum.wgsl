// Sums the form factors of pixels by visible side, in 64-bit integers of two words, so that the sum
// does not depend on the order of additions.

struct Sizes {
    // Pixels along a face, tiles in a row of the atlas, sums per tile, patches.
    resolution: u32,
    columns: u32,
    slots: u32,
    patches: u32,
}

@group(0) @binding(0) var<uniform> sizes: Sizes;
@group(0) @binding(1) var sides: texture_2d<u32>;
// Delta form factors of the pixels of a hemicube, below 2^27 each.
@group(0) @binding(2) var<storage, read> weights: array<u32>;
// For each tile the world's up along the axes of its hemicube.
@group(0) @binding(3) var<storage, read> ups: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> sums: array<atomic<u32>>;

const NOTHING: u32 = 0xffffffffu;
// Pixels of a column per invocation: those of the same side are added at once.
const RUN: u32 = 16u;

// The point where a pixel's direction intersects the cube of side 2.
fn direction(column: u32, row: u32) -> vec3f {
    let n = sizes.resolution;
    let along = (2.0 * f32(column) + 1.0) / f32(n) - 1.0;
    if row < n {
        return vec3f(along, (2.0 * f32(row) + 1.0) / f32(n) - 1.0, 1.0);
    }
    let half = n / 2u;
    let up = (2.0 * f32((row - n) % half) + 1.0) / f32(n);
    switch (row - n) / half {
        case 0u: { return vec3f(1.0, along, up); }
        case 1u: { return vec3f(-1.0, -along, up); }
        case 2u: { return vec3f(-along, 1.0, up); }
        default: { return vec3f(along, -1.0, up); }
    }
}

// The index of a pixel's sum: after all sides follow the light that leaves upwards and downwards.
fn slot(side: u32, tile: u32, column: u32, row: u32) -> u32 {
    if side != NOTHING {
        return side;
    }
    let is_down = dot(direction(column, row), ups[tile].xyz) < 0.0;
    return 2u * sizes.patches + select(0u, 1u, is_down);
}

fn add(slot: u32, tile: u32, share: u32) {
    let at = 2u * (tile * sizes.slots + slot);
    let before = atomicAdd(&sums[at], share);
    if before + share < before {
        atomicAdd(&sums[at + 1u], 1u);
    }
}

@compute @workgroup_size(64)
fn sum(@builtin(global_invocation_id) id: vec3u) {
    let n = sizes.resolution;
    let column = id.x;
    let tile = id.z;
    if column >= n {
        return;
    }
    let corner = vec2u(tile % sizes.columns * n, tile / sizes.columns * 3u * n);
    let first = id.y * RUN;
    let end = min(first + RUN, 3u * n);
    var current = NOTHING;
    var share = 0u;
    for (var row = first; row < end; row++) {
        let side = textureLoad(sides, vec2i(corner + vec2u(column, row)), 0).r;
        let next = slot(side, tile, column, row);
        if next != current {
            if share > 0u {
                add(current, tile, share);
            }
            current = next;
            share = 0u;
        }
        share += weights[row * n + column];
    }
    if share > 0u {
        add(current, tile, share);
    }
}
