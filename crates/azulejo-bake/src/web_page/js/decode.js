// The data of the page; src/web_page/ of azulejo-bake writes them and says what is in them.

const element = (id) => document.getElementById(id);

function bytesOf(id) {
    const text = element(id).textContent;
    if (Uint8Array.fromBase64) {
        return Uint8Array.fromBase64(text);
    }
    const letters = atob(text);
    const bytes = new Uint8Array(letters.length);
    for (let k = 0; k < letters.length; k++) {
        bytes[k] = letters.charCodeAt(k);
    }
    return bytes;
}

async function inflated(id) {
    const decompression = new DecompressionStream("deflate-raw");
    const stream = new Blob([bytesOf(id)]).stream().pipeThrough(decompression);
    return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Lists of numbers, one after another, each as differences with their bytes apart.
class Lists {
    constructor(bytes) {
        this.bytes = bytes;
        this.offset = 0;
    }

    // `count` unsigned 32-bit integers.
    words(count) {
        const { bytes, offset } = this;
        const words = new Uint32Array(count);
        let last = 0;
        for (let k = 0; k < count; k++) {
            const a = offset + k;
            const zigzag = bytes[a] | (bytes[a + count] << 8) | (bytes[a + 2 * count] << 16) |
                (bytes[a + 3 * count] << 24);
            last = (last + ((zigzag >>> 1) ^ -(zigzag & 1))) | 0;
            words[k] = last;
        }
        this.offset += 4 * count;
        return words;
    }

    floats(count) {
        return new Float32Array(this.words(count).buffer);
    }

    signedBytes(count) {
        const values = new Int8Array(count);
        let last = 0;
        for (let k = 0; k < count; k++) {
            last += this.bytes[this.offset + k];
            values[k] = last;
        }
        this.offset += count;
        return values;
    }
}

// The geometry of all meshes: vertices of all of them in common lists, and indices into these.
async function decodeGeometry(head) {
    const lists = new Lists(await inflated("geometry"));
    const sum = (counts) => counts.reduce((a, b) => a + b, 0);
    const all = head.meshes.map((mesh) => mesh.vertices);
    const of = (property) => head.meshes.map((mesh) => (mesh[property] ? mesh.vertices : 0));
    const components = (number, count, read) => {
        const planes = Array.from({ length: number }, () => read(count));
        return { planes, count };
    };
    const floats = (count) => lists.floats(count);
    const positions = components(3, sum(all), floats);
    const normals = components(3, sum(all), (count) => lists.signedBytes(count));
    const uvs = components(2, sum(of("uvs")), floats);
    const lightUvs = components(2, sum(of("lit")), floats);
    const colors = components(3, sum(of("colors")), (count) => lists.words(count));
    const indices = lists.words(sum(head.meshes.map((mesh) => mesh.indices)));
    const spread = (list, counts, width, Type, missing) =>
        interleaved(list, counts, all, width, new Type(width * sum(all)).fill(missing));
    return {
        positions: spread(positions, all, 3, Float32Array, 0),
        normals: spread(normals, all, 4, Int8Array, 0),
        uvs: spread(uvs, of("uvs"), 2, Float32Array, 0),
        lightUvs: spread(lightUvs, of("lit"), 2, Float32Array, 0),
        colors: spread(colors, of("colors"), 4, Uint16Array, 65535),
        indices,
        vertices: sum(all),
    };
}

// Values of some meshes, component by component, as values of all, vertex by vertex.
function interleaved(list, counts, all, width, target) {
    let [from, to] = [0, 0];
    for (let mesh = 0; mesh < all.length; mesh++) {
        for (let k = 0; k < counts[mesh]; k++) {
            for (let c = 0; c < list.planes.length; c++) {
                target[width * (to + k) + c] = list.planes[c][from + k];
            }
        }
        from += counts[mesh];
        to += all[mesh];
    }
    return target;
}

// What the prediction from the texels to the left, above, and above left leaves, made whole again.
function whole(bytes, offset, width, height) {
    const count = width * height;
    const upper = offset + count;
    const numbers = new Int16Array(count);
    for (let k = 0, y = 0; y < height; y++) {
        for (let x = 0; x < width; x++, k++) {
            let predicted = 0;
            if (y === 0) {
                predicted = x === 0 ? 0 : numbers[k - 1];
            } else if (x === 0) {
                predicted = numbers[k - width];
            } else {
                const left = numbers[k - 1];
                const above = numbers[k - width];
                const sum = left + above - numbers[k - width - 1];
                const low = left < above ? left : above;
                const high = left < above ? above : left;
                predicted = sum < low ? low : sum > high ? high : sum;
            }
            const zigzag = bytes[offset + k] | (bytes[upper + k] << 8);
            numbers[k] = predicted + ((zigzag >>> 1) ^ -(zigzag & 1));
        }
    }
    return numbers;
}

// The bits of a half float for a normal number.
function half(value) {
    const exponent = clamp(Math.floor(Math.log2(value)), -14, 15);
    const mantissa = Math.round((value / 2 ** exponent - 1) * 1024);
    return ((exponent + 15) << 10) + mantissa;
}

// Half floats and values of all codes of `steps` per octave; the largest code is 2^15 and 1.
function codes(steps, octaves) {
    const count = steps * octaves + 1;
    const halves = new Uint16Array(count);
    const values = new Float32Array(count);
    for (let code = 1; code < count; code++) {
        values[code] = 2 ** (code / steps - octaves);
        halves[code] = half(values[code] * 32768);
    }
    return { halves, values };
}

// A lightmap: `texels` are halves of irradiance in rgb and the luminance of its standard error in alpha,
// times `scale` and `errorScale`; `light(k)` is the luminance of texel k, `error(k)` that of its error.
async function decodeLightmap(head, number) {
    const { width, height, peak, errorPeak } = head.lightmaps[number];
    const bytes = await inflated(`light-${number}`);
    const count = width * height;
    const list = (k) => whole(bytes, 2 * k * count, width, height);
    const [green, red, blue] = [list(0), list(1), list(2)];
    const errors = errorPeak === null ? null : list(3);
    const { halves, values } = codes(head.lightSteps, head.octaves);
    const ofErrors = codes(head.errorSteps, head.octaves);
    const texels = new Uint16Array(4 * count);
    for (let k = 0; k < count; k++) {
        red[k] += green[k];
        blue[k] += green[k];
        texels[4 * k] = halves[red[k]];
        texels[4 * k + 1] = halves[green[k]];
        texels[4 * k + 2] = halves[blue[k]];
        texels[4 * k + 3] = errors ? ofErrors.halves[errors[k]] : 0;
    }
    return {
        width,
        height,
        texels,
        scale: peak / 32768,
        errorScale: (errorPeak || 0) / 32768,
        light: (k) => peak * luminance(values[red[k]], values[green[k]], values[blue[k]]),
        error: (k) => (errors ? errorPeak * ofErrors.values[errors[k]] : 0),
    };
}

// A picture, or null if this browser cannot decode it.
async function decodePicture(head, number) {
    const blob = new Blob([bytesOf(`picture-${number}`)], { type: head.pictures[number].type });
    const exact = { premultiplyAlpha: "none", colorSpaceConversion: "none" };
    try {
        return await createImageBitmap(blob, exact);
    } catch (problem) {
        console.warn(`picture ${number} is not shown:`, problem);
        return null;
    }
}

