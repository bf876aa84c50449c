// What the pages share.

// RGB at places of a picture whose rows of four numbers go upwards; x and y are in pixels from the upper left.
window.pixelsAt = (numbers, width, height, points) => points.map(([x, y]) => {
    const column = Math.min(Math.max(Math.floor(x), 0), width - 1);
    const row = Math.min(Math.max(Math.floor(y), 0), height - 1);
    const k = 4 * ((height - 1 - row) * width + column);
    return Array.from(numbers.slice(k, k + 3));
});

// The exposure that makes the typical luminance a middle grey, as azulejo's own pictures have it.
window.exposureOf = (numbers) => {
    const lit = [];
    for (let k = 0; k < numbers.length; k += 4) {
        const l = 0.2126 * numbers[k] + 0.7152 * numbers[k + 1] + 0.0722 * numbers[k + 2];
        if (l > 0 && Number.isFinite(l)) {
            lit.push(l);
        }
    }
    if (lit.length === 0) {
        return 1;
    }
    lit.sort((a, b) => a - b);
    const quartile = lit[Math.floor((lit.length * 3) / 4)];
    const mean = lit.reduce((sum, l) => sum + Math.log(Math.min(Math.max(l, quartile / 64), 8 * quartile)), 0) / lit.length;
    return 0.18 / Math.exp(mean);
};
