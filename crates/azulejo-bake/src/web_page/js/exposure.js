// Exposure under which what is seen is neither black nor white.

const KEY = 0.18;

// The factor that makes the typical luminance a middle grey: the logarithmic mean (Reinhard et al. 2002,
// eqs. (1) and (2)), each value clamped between 1/64 and 8 times the upper quartile so that neither
// deep shadow nor a lamp dominates. As azulejo's own pictures have it.
function exposureOf(luminances) {
    const lit = luminances.filter((l) => l > 0 && Number.isFinite(l)).sort((a, b) => a - b);
    if (lit.length === 0) {
        return 1;
    }
    const quartile = lit[Math.floor((lit.length * 3) / 4)];
    const logarithm = (l) => Math.log(clamp(l, quartile / 64, 8 * quartile));
    const mean = lit.reduce((sum, l) => sum + logarithm(l), 0) / lit.length;
    const exposure = KEY / Math.exp(mean);
    return Number.isFinite(exposure) ? exposure : 1;
}

// The exposure for what a view shows of surfaces; for all surfaces where that cannot be read.
function exposureOfView(renderer, view, model, hideBacks) {
    const [width, height] = [96, 64];
    const pixels = renderer.read(view, { show: SHOW.radiance, hideBacks }, width, height);
    const seen = [];
    for (let k = 0; pixels && k < pixels.length; k += 4) {
        if (pixels[k + 3] > 0) {
            seen.push(luminance(pixels[k], pixels[k + 1], pixels[k + 2]));
        }
    }
    const isEnough = seen.length > 0.01 * width * height;
    return exposureOf(isEnough ? seen : model.samples.map((s) => s.radiance));
}

