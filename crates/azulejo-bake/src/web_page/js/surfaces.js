// What is drawn: ranges of one list of triangles, and light in places of their surfaces.

// Sorts the meshes so that those of one material and lightmap follow each other. A batch is such a run;
// its parts are its meshes.
function makeBatches(head, geometry) {
    const placed = head.meshes.map((mesh, number) => ({ mesh, number }));
    let [vertex, index] = [0, 0];
    for (const place of placed) {
        [place.vertex, place.index] = [vertex, index];
        vertex += place.mesh.vertices;
        index += place.mesh.indices;
    }
    const mode = (place) => ["opaque", "mask", "blend"].indexOf(head.materials[place.mesh.material].mode);
    const lightmap = (place) => (place.mesh.lit ? place.mesh.lightmap : -1);
    placed.sort((a, b) =>
        mode(a) - mode(b) || a.mesh.material - b.mesh.material || lightmap(a) - lightmap(b) ||
        a.number - b.number);
    const sorted = new Uint32Array(geometry.indices.length);
    const batches = [];
    let first = 0;
    for (const place of placed) {
        const count = place.mesh.indices;
        for (let k = 0; k < count; k++) {
            sorted[first + k] = geometry.indices[place.index + k] + place.vertex;
        }
        const part = { first, count, number: place.number, centre: middle(geometry, sorted, first, count) };
        const last = batches[batches.length - 1];
        const { material } = place.mesh;
        if (last && last.material === material && last.lightmap === lightmap(place)) {
            last.parts.push(part);
            last.count += count;
        } else {
            batches.push({ material, lightmap: lightmap(place), first, count, parts: [part] });
        }
        first += count;
    }
    geometry.indices = sorted;
    return batches;
}

const corner = (geometry, index) => {
    const k = 3 * geometry.indices[index];
    return [geometry.positions[k], geometry.positions[k + 1], geometry.positions[k + 2]];
};

// The middle of the box around some triangles.
function middle(geometry, indices, first, count) {
    const box = new Box();
    for (let k = first; k < first + count; k++) {
        box.add(geometry.positions, 3 * indices[k]);
    }
    return box.isEmpty() ? [0, 0, 0] : box.centre();
}

class Box {
    constructor() {
        this.low = [Infinity, Infinity, Infinity];
        this.high = [-Infinity, -Infinity, -Infinity];
    }

    add(list, k) {
        for (let axis = 0; axis < 3; axis++) {
            this.low[axis] = Math.min(this.low[axis], list[k + axis]);
            this.high[axis] = Math.max(this.high[axis], list[k + axis]);
        }
    }

    isEmpty() {
        return !(this.low[0] <= this.high[0]);
    }

    centre() {
        return times(add(this.low, this.high), 0.5);
    }

    diagonal() {
        return this.isEmpty() ? 1 : length(subtract(this.high, this.low)) || 1;
    }

    corners() {
        return Array.from({ length: 8 }, (_, k) =>
            [0, 1, 2].map((axis) => ((k >> axis) & 1 ? this.high : this.low)[axis]));
    }
}

function boundsOf(geometry) {
    const box = new Box();
    for (const index of geometry.indices) {
        box.add(geometry.positions, 3 * index);
    }
    if (box.isEmpty()) {
        [box.low, box.high] = [[-1, -1, -1], [1, 1, 1]];
    }
    return box;
}

const LIGHT_SAMPLES = 20000;

// Light in places spread evenly over all lit surfaces: luminance of E, of its error, and radiance.
function sampleLight(head, geometry, batches, lightmaps) {
    const triangles = [];
    let total = 0;
    for (const batch of batches.filter((b) => b.lightmap >= 0)) {
        for (let k = batch.first; k + 2 < batch.first + batch.count; k += 3) {
            const [a, b, c] = [0, 1, 2].map((j) => corner(geometry, k + j));
            total += length(cross(subtract(b, a), subtract(c, a)));
            triangles.push({ k, batch, until: total });
        }
    }
    const samples = [];
    let triangle = 0;
    for (let n = 0; n < (total > 0 ? LIGHT_SAMPLES : 0); n++) {
        const target = ((n + 0.5) / LIGHT_SAMPLES) * total;
        while (triangles[triangle].until < target && triangle < triangles.length - 1) {
            triangle++;
        }
        const { k, batch } = triangles[triangle];
        samples.push(lightSample(head, geometry, lightmaps, k, batch, n));
    }
    return samples;
}

function lightSample(head, geometry, lightmaps, k, batch, n) {
    // Two irrational steps fill the square evenly; folding it fills the triangle.
    let [s, t] = [(n * 0.7548776662) % 1, (n * 0.5698402910) % 1];
    if (s + t > 1) {
        [s, t] = [1 - s, 1 - t];
    }
    const weights = [1 - s - t, s, t];
    const place = [0, 1].map((axis) => weights.reduce((sum, weight, j) =>
        sum + weight * geometry.lightUvs[2 * geometry.indices[k + j] + axis], 0));
    const map = lightmaps[batch.lightmap];
    const x = clamp(Math.floor(place[0] * map.width), 0, map.width - 1);
    const y = clamp(Math.floor(place[1] * map.height), 0, map.height - 1);
    const light = map.light(y * map.width + x);
    const { baseColor, emission } = head.materials[batch.material];
    return {
        light,
        error: map.error(y * map.width + x),
        radiance: (light * luminance(...baseColor)) / Math.PI + luminance(...emission),
    };
}

