// A room whose light is a formula, as a GLB with MOZ_lightmap, with the light as EXR beside it.
//
// Five walls are matt. One has its place in the lightmap by KHR_texture_transform, another is turned by it, and a third
// has an occlusion map, which baked light has no use for. A sixth surface is unlit. The last shares its material with
// the left wall, but has no place in the lightmap, and stays dark.

import { deflateSync } from "node:zlib";

const CELL = 128;
const CELLS = [3, 2];
const PADDING = 4;
const INTENSITY = 250;

// Corner, and the edges across and down the lightmap; counterclockwise from the front: corner, + down, + both, + across.
const SURFACES = [
    { name: "floor", corner: [-2, 0, -2], across: [4, 0, 0], down: [0, 0, 4], color: [0.5, 0.4, 0.3] },
    { name: "back", corner: [-2, 3, -2], across: [4, 0, 0], down: [0, -3, 0], color: [0.7, 0.7, 0.7],
        isOccluded: true },
    { name: "left", corner: [-2, 3, 2], across: [0, 0, -4], down: [0, -3, 0], color: [0.6, 0.1, 0.08], isMoved: true },
    { name: "right", corner: [2, 3, -2], across: [0, 0, 4], down: [0, -3, 0], color: [0.1, 0.45, 0.12],
        isTurned: true },
    { name: "ceiling", corner: [-2, 3, 2], across: [4, 0, 0], down: [0, 0, -4], color: [0.8, 0.8, 0.75] },
    { name: "sign", corner: [-1, 1.5, -1], across: [1.5, 0, 0.6], down: [0, -1.2, 0], color: [0.9, 0.6, 0.2], isUnlit: true },
    { name: "bare", corner: [0.9, 1.2, -0.5], across: [0.8, 0, 0], down: [0, -0.8, 0], isBare: true, material: 2 },
];
const LIT = SURFACES.filter(({ isBare }) => !isBare);

const CAMERA = { eye: [0.3, 1.6, 5.2], target: [0, 1.4, 0], up: [0, 1, 0], vertical_fov: 45, width: 320, height: 240 };

// Irradiance over INTENSITY of surface k, s across and t down it.
const share = (k, s, t) => [
    0.95 - 0.5 * s * (0.6 + 0.4 * t),
    0.5 + 0.3 * t + 0.05 * Math.cos(4 * s + k),
    0.6 + 0.2 * Math.sin(3 * s + 2 * t + k),
];

// The place of a texel in its surface, so that the padding is outside.
const placeInCell = (texel) => (texel + 0.5 - PADDING) / (CELL - 2 * PADDING);
const cellOf = (k) => [(k % CELLS[0]) * CELL, Math.floor(k / CELLS[0]) * CELL];
const [WIDTH, HEIGHT] = CELLS.map((n) => n * CELL);

// Calls back with x, y and the light of each texel.
function forTexels(callback) {
    LIT.forEach((_, k) => {
        const [left, top] = cellOf(k);
        for (let y = 0; y < CELL; y++) {
            for (let x = 0; x < CELL; x++) {
                callback(left + x, top + y, share(k, placeInCell(x), placeInCell(y)));
            }
        }
    });
}

const encoded = (x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));

function crc(bytes) {
    let c = -1;
    for (const byte of bytes) {
        c ^= byte;
        for (let k = 0; k < 8; k++) {
            c = (c >>> 1) ^ (c & 1 ? 0xedb88320 : 0);
        }
    }
    return (c ^ -1) >>> 0;
}

function png() {
    const rows = Buffer.alloc(HEIGHT * (1 + 3 * WIDTH));
    forTexels((x, y, light) => light.forEach((value, c) => {
        rows[y * (1 + 3 * WIDTH) + 1 + 3 * x + c] = encoded(value);
    }));
    const chunk = (name, data) => {
        const body = Buffer.concat([Buffer.from(name), data]);
        const frame = Buffer.alloc(8);
        frame.writeUInt32BE(data.length, 0);
        frame.writeUInt32BE(crc(body), 4);
        return Buffer.concat([frame.subarray(0, 4), body, frame.subarray(4)]);
    };
    const header = Buffer.alloc(13);
    header.writeUInt32BE(WIDTH, 0);
    header.writeUInt32BE(HEIGHT, 4);
    header.set([8, 2, 0, 0, 0], 8);
    const magic = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
    return Buffer.concat([magic, chunk("IHDR", header), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]);
}

// OpenEXR, uncompressed scan lines of 32-bit floats, values in the unit of E.
export function exr() {
    const parts = [Buffer.from([0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0])];
    const integers = (...values) => Buffer.from(Int32Array.from(values).buffer);
    const floats = (...values) => Buffer.from(Float32Array.from(values).buffer);
    const attribute = (name, type, data) => parts.push(Buffer.from(`${name}\0${type}\0`), integers(data.length), data);
    const channel = (name) => Buffer.concat([Buffer.from(`${name}\0`), integers(2, 0, 1, 1)]);
    attribute("channels", "chlist", Buffer.concat([...["B", "G", "R"].map(channel), Buffer.from([0])]));
    attribute("compression", "compression", Buffer.from([0]));
    attribute("dataWindow", "box2i", integers(0, 0, WIDTH - 1, HEIGHT - 1));
    attribute("displayWindow", "box2i", integers(0, 0, WIDTH - 1, HEIGHT - 1));
    attribute("lineOrder", "lineOrder", Buffer.from([0]));
    attribute("pixelAspectRatio", "float", floats(1));
    attribute("screenWindowCenter", "v2f", floats(0, 0));
    attribute("screenWindowWidth", "float", floats(1));
    parts.push(Buffer.from([0]));
    const lines = Array.from({ length: HEIGHT }, () => new Float32Array(3 * WIDTH));
    forTexels((x, y, light) => [2, 1, 0].forEach((c, plane) => {
        lines[y][plane * WIDTH + x] = INTENSITY * light[c];
    }));
    const size = 8 + 12 * WIDTH;
    const start = parts.reduce((sum, part) => sum + part.length, 0) + 8 * HEIGHT;
    lines.forEach((_, y) => {
        const offset = Buffer.alloc(8);
        offset.writeBigUInt64LE(BigInt(start + y * size));
        parts.push(offset);
    });
    lines.forEach((line, y) => parts.push(integers(y, 12 * WIDTH), Buffer.from(line.buffer)));
    return Buffer.concat(parts);
}

const plus = (a, b, s = 1) => a.map((x, k) => x + s * b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.sqrt(dot(a, a)));

export function glb() {
    const binary = [];
    const json = {
        asset: { version: "2.0", generator: "azulejo's tests" },
        extensionsUsed: ["MOZ_lightmap", "KHR_materials_specular", "KHR_materials_unlit", "KHR_texture_transform"],
        scene: 0,
        scenes: [{ nodes: SURFACES.map((_, k) => k) }],
        nodes: [], meshes: [], materials: [], accessors: [], bufferViews: [],
        images: [{ bufferView: 0, mimeType: "image/png" }],
        samplers: [{ magFilter: 9729, minFilter: 9729, wrapS: 33071, wrapT: 33071 }],
        textures: [{ source: 0, sampler: 0 }],
    };
    let length = 0;
    const addView = (bytes) => {
        const padded = Buffer.concat([bytes, Buffer.alloc(-bytes.length & 3)]);
        json.bufferViews.push({ buffer: 0, byteOffset: length, byteLength: bytes.length });
        binary.push(padded);
        length += padded.length;
        return json.bufferViews.length - 1;
    };
    const addAccessor = (values, type, more) => {
        const bytes = Buffer.from(Float32Array.from(values.flat()).buffer);
        json.accessors.push({ bufferView: addView(bytes), componentType: 5126, count: values.length, type, ...more });
        return json.accessors.length - 1;
    };
    addView(png());
    SURFACES.forEach(({ name, corner, across, down, isBare, material }, k) => {
        const corners = [[0, 0], [0, 1], [1, 1], [1, 0]];
        const positions = corners.map(([s, t]) => plus(plus(corner, across, s), down, t));
        const bound = (pick) => [0, 1, 2].map((axis) => pick(...positions.map((p) => p[axis])));
        const { inMap } = placement(k, corners);
        const normal = unit(cross(down, across));
        const primitive = {
            attributes: {
                POSITION: addAccessor(positions, "VEC3", { min: bound(Math.min), max: bound(Math.max) }),
                NORMAL: addAccessor(corners.map(() => normal), "VEC3"),
                // No lightmap takes this set.
                TEXCOORD_0: addAccessor(corners.map(() => [0.5, 0.5]), "VEC2"),
                ...(isBare ? {} : { TEXCOORD_1: addAccessor(inMap, "VEC2") }),
            },
            material: material ?? k,
        };
        const indices = Buffer.from(Uint16Array.from([0, 1, 2, 0, 2, 3]).buffer);
        json.accessors.push({ bufferView: addView(indices), componentType: 5123, count: 6, type: "SCALAR" });
        primitive.indices = json.accessors.length - 1;
        json.meshes.push({ primitives: [primitive] });
        json.nodes.push({ name, mesh: k });
    });
    LIT.forEach(({ name, color, isUnlit, isOccluded }, k) => {
        const { transform } = placement(k, []);
        // The set of the transform counts, not that beside it.
        const coordinates = transform
            ? { texCoord: 0, extensions: { KHR_texture_transform: { ...transform, texCoord: 1 } } }
            : { texCoord: 1 };
        json.materials.push({
            name,
            pbrMetallicRoughness: { baseColorFactor: [...color, 1], metallicFactor: 0, roughnessFactor: 1 },
            ...(isOccluded ? { occlusionTexture: { index: 0 } } : {}),
            extensions: {
                MOZ_lightmap: { index: 0, intensity: INTENSITY, ...coordinates },
                ...(isUnlit ? { KHR_materials_unlit: {} } : { KHR_materials_specular: { specularFactor: 0 } }),
            },
        });
    });
    json.buffers = [{ byteLength: length }];
    return packed(json, Buffer.concat(binary));
}

// Coordinates of corners of surface k in the lightmap, and the texture transform that they need, if any.
function placement(k, corners) {
    const { isMoved, isTurned } = SURFACES[k];
    const [left, top] = cellOf(k);
    const inner = CELL - 2 * PADDING;
    const [width, height] = [inner / WIDTH, inner / HEIGHT];
    const [x, y] = [(left + PADDING) / WIDTH, (top + PADDING) / HEIGHT];
    if (isTurned) {
        // u = x + width × second coordinate, v = y + height - height × first coordinate.
        const transform = { offset: [x, y + height], rotation: Math.PI / 2, scale: [height, width] };
        return { inMap: corners.map(([s, t]) => [1 - t, s]), transform };
    }
    if (isMoved) {
        return { inMap: corners, transform: { offset: [x, y], scale: [width, height] } };
    }
    return { inMap: corners.map(([s, t]) => [x + width * s, y + height * t]) };
}

function packed(json, binary) {
    const text = Buffer.from(JSON.stringify(json));
    const padded = Buffer.concat([text, Buffer.alloc(-text.length & 3, " ")]);
    const words = (...values) => Buffer.from(Uint32Array.from(values).buffer);
    const total = 12 + 8 + padded.length + 8 + binary.length;
    return Buffer.concat([words(0x46546c67, 2, total), words(padded.length, 0x4e4f534a), padded,
        words(binary.length, 0x004e4942), binary]);
}

// The camera, places in its picture, and the radiance that is there.
export function expectation() {
    const { eye, target, up, vertical_fov: fov, width, height } = CAMERA;
    const forward = unit(plus(target, eye, -1));
    const right = unit(cross(forward, up));
    const upright = cross(right, forward);
    const tangent = Math.tan((fov * Math.PI) / 360);
    const [points, radiance] = [[], []];
    for (let y = 8.5; y < height; y += 16) {
        for (let x = 8.5; x < width; x += 16) {
            const across = ((2 * x) / width - 1) * tangent * (width / height);
            const direction = plus(plus(forward, right, across), upright, (1 - (2 * y) / height) * tangent);
            const seen = nearest(eye, direction);
            if (seen) {
                points.push([x, y]);
                radiance.push(seen);
            }
        }
    }
    return { camera: CAMERA, points, radiance };
}

// Radiance along a ray; null near edges and where nothing is.
function nearest(eye, direction) {
    let [least, seen] = [Infinity, null];
    SURFACES.forEach(({ corner, across, down, color, isUnlit, isBare }, k) => {
        const normal = cross(down, across);
        const distance = dot(plus(corner, eye, -1), normal) / dot(direction, normal);
        const from = plus(plus(eye, direction, distance), corner, -1);
        const [s, t] = [dot(from, across) / dot(across, across), dot(from, down) / dot(down, down)];
        const margin = Math.min(s, 1 - s, t, 1 - t);
        if (!(distance > 0 && distance < least && margin > -0.01)) {
            return;
        }
        least = distance;
        if (isBare) {
            seen = margin < 0.01 ? null : [0, 0, 0];
            return;
        }
        const light = share(k, s, t);
        const factor = isUnlit ? INTENSITY : INTENSITY / Math.PI;
        seen = margin < 0.01 ? null : light.map((value, c) => value * factor * color[c]);
    });
    return seen;
}
