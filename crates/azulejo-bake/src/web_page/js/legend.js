// Ranges of false colours, and the scale that explains them.

// A number with three digits, as people write it.
function shown(x) {
    const size = Math.abs(x);
    if (x === 0) {
        return "0";
    }
    if (!(size >= 1e-3 && size < 1e6)) {
        return x.toExponential(1).replace("e+", "e");
    }
    const digits = clamp(2 - Math.floor(Math.log10(size)), 0, 6);
    return Number(x.toFixed(digits)).toLocaleString("en", { maximumFractionDigits: digits });
}

// The value below which a share of the sorted list is.
const quantile = (sorted, share) => sorted[clamp(Math.floor(share * sorted.length), 0, sorted.length - 1)];

// The next of 1, 2, 5, 10, 20, … at or above x, or at or below it; or of other `digits`.
function roundTo(x, isUp, digits = [1, 2, 5, 10]) {
    const power = 10 ** Math.floor(Math.log10(x));
    const steps = digits.map((s) => s * power);
    const fits = (s) => (isUp ? s >= x * 0.9999 : s <= x * 1.0001);
    return (isUp ? steps : steps.reverse()).find(fits);
}

// From where to where the colours go for these values.
function rangeOf(values, isLogarithmic) {
    const positive = values.filter((v) => v > 0 && Number.isFinite(v)).sort((a, b) => a - b);
    if (positive.length === 0) {
        return isLogarithmic ? [0.01, 1] : [0, 1];
    }
    const most = quantile(positive, 0.995);
    if (!isLogarithmic) {
        return [0, roundTo(most, true, [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10])];
    }
    const high = roundTo(most, true);
    return [roundTo(clamp(quantile(positive, 0.01), high * 1e-4, high / 10), false), high];
}

// Where numbers stand on the scale: at most about `most` of them.
function ticks([low, high], isLogarithmic, most) {
    if (!isLogarithmic) {
        const step = roundTo((high - low) / most, true);
        const count = Math.floor((high - low) / step + 1e-6);
        const first = Math.ceil(low / step - 1e-6);
        return Array.from({ length: count + 1 }, (_, k) => (first + k) * step).filter((v) => v <= high * 1.0001);
    }
    const decades = Math.log10(high / low);
    const mantissas = 3 * decades <= most ? [1, 2, 5] : [1];
    const every = mantissas.length > 1 ? 1 : Math.ceil(decades / most);
    const values = [];
    for (let e = Math.floor(Math.log10(low)); e <= Math.ceil(Math.log10(high)); e++) {
        if (e % every === 0) {
            values.push(...mantissas.map((m) => m * 10 ** e));
        }
    }
    return values.filter((v) => v >= low * 0.999 && v <= high * 1.001);
}

// Fills the scale's element with colours and numbers.
function drawLegend(scale, range, isLogarithmic) {
    const isWide = scale.clientWidth > 2 * scale.clientHeight;
    const stops = VIRIDIS.map((color) => `rgb(${color.join(" ")})`);
    scale.style.setProperty("--stops", stops.join(", "));
    const list = scale.querySelector(".ticks");
    const [low, high] = range;
    const share = (v) => (isLogarithmic ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low));
    list.replaceChildren(...ticks(range, isLogarithmic, isWide ? 6 : 9).map((value) => {
        const tick = document.createElement("li");
        tick.textContent = shown(value);
        tick.style.setProperty("--at", `${100 * share(value)}%`);
        return tick;
    }));
}

