// Vectors are arrays of three numbers; matrices are 16 numbers, column by column.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
];
const length = (a) => Math.hypot(a[0], a[1], a[2]);
const normalize = (a) => times(a, 1 / (length(a) || 1));
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
const luminance = (r, g, b) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

// From places relative to the eye to clip space. `frame` has right, up and forward; `tangents` are those
// of half the angles of view, across and up; `lift` is how far the middle of the view is above that of
// the picture, in halves of its height.
function viewProjection({ frame, tangents, lift = 0 }, near, far) {
    const { right, up, forward } = frame;
    const depth = (far + near) / (far - near);
    const m = new Float32Array(16);
    for (let axis = 0; axis < 3; axis++) {
        m[4 * axis] = right[axis] / tangents[0];
        m[4 * axis + 1] = up[axis] / tangents[1] + lift * forward[axis];
        m[4 * axis + 2] = depth * forward[axis];
        m[4 * axis + 3] = forward[axis];
    }
    m[14] = (-2 * far * near) / (far - near);
    return m;
}

