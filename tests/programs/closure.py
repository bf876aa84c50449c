"""What closure moves, and what that does to the error, where a model is open: estimates by few rays as they are, with rows
scaled to 1, with that and reciprocity in turns, and by azulejo's least squares (`--closure=always`), compared with closed
forms. Models are a cube without a lid in patches, a court with houses (that of udales.py) and a wall on open ground.
Prints a table. Needs NumPy."""

import os

from common import CUBE, azulejo, check, folder, skip, write_obj

try:
    import numpy as np
except ImportError:
    skip("NumPy is missing (pip install numpy)")

from udales_models import BLOCK, street

RAYS = 1024
SEEDS = 8
# Of scaling and averaging in turns: more change nothing.
TURNS = 100


def read(path):
    """Factors with what leaves upwards, downwards and to backs as three more columns, and areas."""
    with np.load(path) as f:
        n = len(f["areas"])
        matrix = np.zeros((n, n + 3))
        rows = np.repeat(np.arange(n), np.diff(f["indptr"]))
        matrix[rows, f["indices"]] = f["data"]
        for k, name in enumerate(["sky", "ground", "hidden"]):
            matrix[:, n + k] = f[name]
        return matrix, np.array(f["areas"], float)


def factors(place, model, *options):
    path = os.path.join(place, "f.npz")
    azulejo("form-factors", model, "-o", path, "--patch-size", "0", *options)
    return read(path)


def scaled(matrix):
    return matrix / matrix.sum(1, keepdims=True)


def reciprocal(matrix, areas):
    """Exchange areas of both directions replaced by their mean."""
    n = len(areas)
    exchange = areas[:, None] * matrix[:, :n]
    return np.hstack([(exchange + exchange.T) / 2 / areas[:, None], matrix[:, n:]])


def in_turns(matrix, areas):
    """Scaling, then the mean, over and over, with the mean last."""
    for _ in range(TURNS):
        matrix = reciprocal(scaled(matrix), areas)
    return matrix


def residuals(matrix, areas):
    """Largest lack of a row, and largest difference between directions as a share of the smaller area."""
    n = len(areas)
    exchange = areas[:, None] * matrix[:, :n]
    smaller = np.minimum(areas[:, None], areas[None, :])
    return np.abs(matrix.sum(1) - 1).max(), (np.abs(exchange - exchange.T) / smaller).max()


def row_error(matrix, truth):
    """The mean over rows of the sum of errors, sky and ground included."""
    return np.abs(matrix - truth).sum(1).mean()


def subdivided(polygons, count):
    """Each square in count × count."""
    pieces = []
    for a, b, _, d in polygons:
        a, u, v = np.array(a, float), np.subtract(b, a) / count, np.subtract(d, a) / count
        for i in range(count):
            for k in range(count):
                corner = a + i * u + k * v
                pieces.append([tuple(corner), tuple(corner + u), tuple(corner + u + v), tuple(corner + v)])
    return pieces


def models():
    open_cube = [CUBE[name] for name in CUBE if name != "ceiling"]
    yield "cube without a lid, 80 patches", subdivided(open_cube, 4)
    yield f"court with houses, {len(street())} triangles", street()
    yield "wall on open ground, 4 triangles", BLOCK


print(f"{RAYS} rays from each facet, means of {SEEDS} seeds\n")
print("| model | scheme | moved | largest lack of a row | largest lack of reciprocity | error of a row |")
print("|---|---|---|---|---|---|")
for name, polygons in models():
    place = folder()
    model = os.path.join(place, "model.obj")
    write_obj(model, {"model": polygons})
    truth, areas = factors(place, model, "--engine", "analytic", "--tolerance", "1e-7", "--closure=never")
    found = {}
    for seed in range(SEEDS):
        options = ["--engine", "rays", "--rays", str(RAYS), "--formulas=never", "--seed", str(seed)]
        raw, _ = factors(place, model, *options, "--closure=never")
        closed, _ = factors(place, model, *options, "--closure=always")
        for scheme, matrix in {
            "as traced": raw,
            "rows scaled": scaled(raw),
            "scaled and averaged in turns": in_turns(raw, areas),
            "azulejo, `--closure=always`": closed,
        }.items():
            numbers = [np.abs(matrix - raw).sum(1).mean(), *residuals(matrix, areas), row_error(matrix, truth)]
            found.setdefault(scheme, []).append(numbers)
    for scheme, numbers in found.items():
        moved, lack, asymmetry, error = np.mean(numbers, axis=0)
        print(f"| {name} | {scheme} | {moved:.2%} | {lack:.1e} | {asymmetry:.1e} | {error:.2%} |")
    ours, as_traced = (np.mean(found[scheme], axis=0) for scheme in ["azulejo, `--closure=always`", "as traced"])
    check(f"{name}: closure and reciprocity, largest residual", max(ours[1:3]), 0.0, 1e-6)
    check(f"{name}: what closure adds to the error", max(0.0, ours[3] - as_traced[3]), 0.0, 0.0)
