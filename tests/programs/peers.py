"""Form factors by azulejo and by its peers, View3D, pyviewfactor and raystrack: CPU seconds, errors and peak memory, a
Markdown table for each set of models. VIEW3D is View3D's executable if it is not on the path, VIEW3D_UDALES that of the
fork that uDALES uses; the others are packages of the Python that runs this. Peers that are missing are left out. Needs
NumPy.

    peers.py [--seconds 300] [--reference-seconds 300] [--sets figures,room,towns,files] [MODEL...]

MODELs are files that azulejo reads, computed as triangles. The limit is in CPU seconds, for each computation with its
imports and compilation; reported are those of the computation alone."""

import argparse
import importlib.util
import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys

from common import CUBE, azulejo, folder, skip, write_obj

try:
    import numpy as np
except ImportError:
    skip("NumPy is missing (pip install numpy)")

ADAPTER = os.path.join(os.path.dirname(__file__), "..", "..", "crates", "azulejo-cli", "data", "peers.py")
# It has the name of this file, so that `import` would find this one.
specification = importlib.util.spec_from_file_location("adapter", ADAPTER)
adapter = importlib.util.module_from_spec(specification)
specification.loader.exec_module(adapter)

# A process between this one and the program: what a program is started from counts in its peak of memory.
BETWEEN = """
import os, resource, sys
child = os.fork()
if child == 0:
    limit = int(sys.argv[1])
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    os.execvp(sys.argv[2], sys.argv[2:])
_, status, used = os.wait4(child, 0)
with open("usage", "w") as out:
    print(used.ru_utime + used.ru_stime, used.ru_maxrss, os.waitstatus_to_exitcode(status), file=out)
"""

# Name, environment, and arguments of the adapter before the model.
PEERS = [
    ("View3D", "view3d", "VIEW3D", []),
    ("View3D, uDALES's fork", "view3d", "VIEW3D_UDALES", []),
    ("pyviewfactor", "pyviewfactor", None, []),
    ("raystrack", "raystrack", None, []),
    ("raystrack, 4,096 rays", "raystrack", None, ["--fineness", "4096"]),
]
AZULEJO = [("azulejo", []), ("azulejo `--rays 4096`", ["--rays", "4096"])]


class Failed(Exception):
    """Why there is no result, in a few words."""


def measured(command, limit, environment=os.environ):
    """Runs a command in a folder of its own; the folder, CPU seconds and peak in MiB."""
    place = folder()
    try:
        return place, *usage(command, limit, environment, place)
    except Failed:
        shutil.rmtree(place)
        raise


def usage(command, limit, environment, place):
    with open(os.path.join(place, "stdout"), "w") as out, open(os.path.join(place, "stderr"), "w") as messages:
        process = subprocess.Popen([sys.executable, "-c", BETWEEN, str(limit), *command], cwd=place, env=environment,
                                   stdout=out, stderr=messages, start_new_session=True)  # fmt: skip
        try:
            # Busy threads reach the limit earlier; beside other work, or waiting, a program may take longer.
            process.wait(2 * limit + 60)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            raise Failed(f"over {2 * limit + 60} s") from None
    with open(os.path.join(place, "usage")) as file:
        seconds, peak, code = map(float, file.read().split())
    if code == -signal.SIGXCPU or seconds >= limit:
        raise Failed(f"over {limit} CPU s")
    if code == 3:
        raise Failed("missing")
    if code != 0:
        with open(os.path.join(place, "stderr")) as messages:
            print(messages.read()[-2000:], file=sys.stderr)
        raise Failed(f"failed ({code:.0f})")
    return seconds, peak / (2**20 if sys.platform == "darwin" else 2**10)


def by_azulejo(model, limit, *options):
    """CPU seconds, MiB, factors, and the error of a row that it states, RMS."""
    command = [shutil.which(os.environ.get("AZULEJO", "azulejo")), "form-factors", model, "-o", "f.npz",
               "--patch-size", "0", "--no-journal", *options]  # fmt: skip
    place, seconds, peak = measured(command, limit)
    file = np.load(os.path.join(place, "f.npz"))
    n = file["shape"][0]
    factors = np.zeros((n, n))
    factors[np.repeat(np.arange(n), np.diff(file["indptr"])), file["indices"]] = file["data"]
    stated = math.sqrt(np.mean(file["row_error"] ** 2))
    shutil.rmtree(place)
    return seconds, peak, factors, stated


def by_peer(peer, variable, model, limit, fineness):
    """Its name and version, CPU seconds, MiB and factors."""
    environment = dict(os.environ)
    if variable is not None:
        environment["VIEW3D"] = os.environ.get(variable, "view3d" if variable == "VIEW3D" else "missing")
    command = [sys.executable, os.path.abspath(ADAPTER), peer, *fineness, model]
    place, _, _ = measured(command, limit, environment)
    with open(os.path.join(place, "stdout")) as file:
        found = json.load(file)
    shutil.rmtree(place)
    return found["program"], found["seconds"], found["peak_mib"], np.array(found["factors"], float)


def version():
    """That of azulejo."""
    command = os.environ.get("AZULEJO", "azulejo")
    return subprocess.run([command, "--version"], capture_output=True, text=True).stdout.strip()


def compare(models, limit, columns, options=()):
    """A table: for each program the CPU seconds and errors of all models, and the largest peak of memory. `columns` are
    (heading, model, error of a matrix); `options` are for azulejo. Several columns may be of one model."""
    print("| " + " | ".join(["program", *(heading for heading, _, _ in columns), "CPU s", "MiB"]) + " |")
    print("|---|" + "---|" * (len(columns) + 2), flush=True)
    versions = [version()]
    programs = [(name, None, None, extra) for name, extra in AZULEJO] + PEERS
    for name, peer, variable, extra in programs:
        cells, seconds, peak, results, failure = [], 0.0, 0.0, {}, None
        for key, model in models.items():
            try:
                if peer is None:
                    used, most, factors, _ = by_azulejo(model, limit, *extra, *options)
                else:
                    found, used, most, factors = by_peer(peer, variable, model, limit, extra)
                    versions += [found] if found not in versions else []
            except Failed as why:
                failure = str(why)
                break
            results[key], seconds, peak = factors, seconds + used, max(peak, most)
        if failure == "missing":
            continue
        for _, key, error in columns:
            cells.append(f"{error(results[key]):.1e}" if key in results else "-")
        spent = failure or (f"{seconds:.3f}" if seconds < 1 else f"{seconds:.1f}")
        print("| " + " | ".join([name, *cells, spent, f"{peak:.0f}" if peak else "-"]) + " |", flush=True)
    print("\n" + ", ".join(versions) + "\n", flush=True)


def entry(i, j, true):
    return lambda factors: abs(factors[i, j] - true)


def sums(factors):
    """RMS error of the row sums of a closed model."""
    return math.sqrt(np.mean((factors.sum(1) - 1) ** 2))


def rows(reference):
    """RMS over the rows of the sum of all errors of a row."""
    return lambda factors: math.sqrt(np.mean(np.abs(factors - reference).sum(1) ** 2))


def square(half, z):
    """Facing up."""
    return [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]


def blocked(side):
    """From one unit square to another at distance 1, of what a centred square halfway blocks. The kernel depends on
    the displacement alone; along each axis, as much of it counts as has its middle in the blocker."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    ends = [0.0, 1.0 - side, 1.0]
    at = np.concatenate([(nodes + 1) / 2 * (b - a) + a for a, b in zip(ends, ends[1:])])
    by = np.concatenate([weights / 2 * (b - a) for a, b in zip(ends, ends[1:])])
    length = by * np.minimum(side, 1.0 - at)
    kernel = 1 / (math.pi * (1 + at[:, None] ** 2 + at**2) ** 2)
    return 4 * length @ kernel @ length


FACING = 0.19982489569838746
CORNER = 0.20004377607540316


def figures(place, limit):
    """Closed forms."""
    assert abs(blocked(1.0) - FACING) < 1e-12
    scenes = {
        "facing": [square(0.5, 0.0), square(0.5, 1.0)[::-1]],
        "corner": [CUBE["floor"], CUBE["west"]],
        "cube": list(CUBE.values()),
        "between": [square(0.5, 0.0), square(0.5, 1.0)[::-1], square(0.25, 0.5)],
    }
    columns = [
        ("facing squares", "facing", entry(0, 1, FACING)),
        ("at a right angle", "corner", entry(0, 1, CORNER)),
        ("cube, sums", "cube", sums),
        ("facing, another between", "between", entry(0, 1, FACING - blocked(0.5))),
    ]
    print("Errors of closed forms: unit squares at distance 1, at a right angle, in a cube (row sums, RMS), and with a")
    print("square of side 0.5 halfway between. CPU seconds of all four; azulejo with `--closure=never`.\n")
    compare(write(place, scenes), limit, columns, ["--closure=never"])


def write(place, scenes):
    """A file for each."""
    models = {}
    for name, polygons in scenes.items():
        models[name] = os.path.join(place, f"{name}.obj")
        write_obj(models[name], {name: polygons})
    return models


def furnished():
    """A room of 5 × 4 × 3 m with a table, a wardrobe and a chest, between the lines of a grid: what is solid is a set
    of its cells, and each side of a cell between solid and air is a facet."""
    x = [0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5]
    y = [0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4]
    z = [0, 0.35, 0.7, 0.75, 1.2, 1.8, 2.4, 3]
    pieces = [
        ((1.5, 1.0, 0.7), (3.5, 2.5, 0.75)),  # the top of the table
        ((2.0, 1.5, 0.0), (2.5, 2.0, 0.7)),  # its leg
        ((4.5, 0.0, 0.0), (5.0, 1.5, 1.8)),  # the wardrobe
        ((0.5, 3.0, 0.0), (1.5, 3.5, 0.7)),  # the chest, a step away from the wall
    ]

    def air(i, j, k):
        if not (0 <= i < len(x) - 1 and 0 <= j < len(y) - 1 and 0 <= k < len(z) - 1):
            return False
        middle = [(lines[n] + lines[n + 1]) / 2 for lines, n in zip((x, y, z), (i, j, k))]
        return not any(all(a < m < b for a, m, b in zip(low, middle, high)) for low, high in pieces)

    facets = []
    for i in range(len(x) - 1):
        for j in range(len(y) - 1):
            for k in range(len(z) - 1):
                low, high = (x[i], y[j], z[k]), (x[i + 1], y[j + 1], z[k + 1])
                for axis, step in [(a, s) for a in range(3) for s in (0, 1) if air(i, j, k)]:
                    neighbour = [i, j, k]
                    neighbour[axis] += 2 * step - 1
                    if not air(*neighbour):
                        facets.append(side(low, high, axis, step))
    return facets


def side(low, high, axis, step):
    """A side of a box, the lower or the upper one along an axis, as seen from inside."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    corners = []
    for a, b in [(0, 0), (1, 0), (1, 1), (0, 1)]:
        corner = [0.0] * 3
        corner[axis] = (low, high)[step][axis]
        corner[u], corner[v] = (low, high)[a][u], (low, high)[b][v]
        corners.append(tuple(corner))
    return corners[::-1] if step else corners


def room(place, limit):
    facets = furnished()
    model = write(place, {"room": facets})
    exact = ["--engine", "analytic", "--tolerance", "1e-9", "--closure=never"]
    seconds, _, reference, stated = by_azulejo(model["room"], limit, *exact)
    print(f"A furnished room of {len(facets)} quads, closed: row sums (RMS), and errors of rows by azulejo's formulas")
    print(f"with `--tolerance 1e-9` ({seconds:.1f} CPU s; its own errors: sums {sums(reference):.1e}, rows")
    print(f"{stated:.1e}). azulejo with `--closure=never`.\n")
    columns = [("row sums", "room", sums), ("error of a row", "room", rows(reference))]
    compare(model, limit, columns, ["--closure=never"])


def town(n):
    """n × n blocks of 20 m, each with a building of 12 × 12 m in its middle, of five heights: the ground around it in
    four strips, four walls and a roof, in triangles."""
    heights = random.Random(7)
    polygons = []
    for i in range(n):
        for j in range(n):
            x, y, h = 20.0 * i, 20.0 * j, float(heights.choice([6, 9, 12, 15, 21]))
            # Strips of ground, the first and the last as wide as the block; then the roof.
            ground = [(0, 0, 20, 4), (0, 16, 20, 20), (0, 4, 4, 16), (16, 4, 20, 16)]
            for a, b, c, d, z in [(*strip, 0.0) for strip in ground] + [(4, 4, 16, 16, h)]:
                polygons.append([(x + a, y + b, z), (x + c, y + b, z), (x + c, y + d, z), (x + a, y + d, z)])
            foot = [(x + 4, y + 4), (x + 16, y + 4), (x + 16, y + 16), (x + 4, y + 16)]
            for p, q in zip(foot, foot[1:] + foot[:1]):
                polygons.append([(*p, 0.0), (*q, 0.0), (*q, h), (*p, h)])
    return adapter.split(polygons)[0]


REFERENCES = [
    ("formulas with `--tolerance 1e-5`", ["--engine", "analytic", "--tolerance", "1e-5"]),
    ("rays, 65,536 from each facet", ["--rays", "65536"]),
]


def with_reference(name, model, facets, limit, patience):
    """A table of a model that is not closed, by the rows of the first of azulejo's references that comes in time."""
    columns, text = [], "no reference"
    for what, options in REFERENCES if patience > 0 else []:
        try:
            seconds, _, reference, stated = by_azulejo(model, patience, *options)
        except Failed as why:
            print(f"{what}: {why}", file=sys.stderr)
            continue
        columns = [("error of a row", name, rows(reference))]
        text = f"errors of rows by azulejo's {what} ({seconds:.1f} CPU s; its own error: {stated:.1e})"
        break
    print(f"{name}, {facets:,} facets: {text}.\n")
    compare({name: model}, limit, columns)


def towns(place, limit, patience):
    for n in (4, 8):
        facets = town(n)
        name = f"Town of {n} × {n} blocks"
        with_reference(name, write(place, {name: facets})[name], len(facets), limit, patience)


def files(place, limit, patience, paths):
    for path in paths:
        name = os.path.basename(path)
        # By way of STL all are triangles; its coordinates are in single precision, so the model is moved to its origin.
        stl, model = os.path.join(place, "model.stl"), os.path.join(place, "model.obj")
        azulejo("convert", path, "-o", model)
        with open(model) as lines:
            points = [list(map(float, line.split()[1:4])) for line in lines if line.startswith("v ")]
        shift = ",".join(f"{-math.floor(min(axis))}" for axis in zip(*points))
        azulejo("convert", path, "-o", stl, "--place", f"{path}:translate={shift}")
        azulejo("convert", stl, "-o", model)
        facets = adapter.read_obj(model)
        write_obj(model, {"model": facets})
        with_reference(name, model, len(facets), limit, patience)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=int, default=300)
    parser.add_argument("--reference-seconds", type=int, default=300, help="for azulejo's references, 0 for none")
    parser.add_argument("--sets", default="figures,room,towns,files")
    parser.add_argument("models", nargs="*")
    arguments = parser.parse_args()
    place, limit, patience = folder(), arguments.seconds, arguments.reference_seconds
    chosen = arguments.sets.split(",")
    if shutil.which(os.environ.get("AZULEJO", "azulejo")) is None:
        skip("azulejo is missing: set AZULEJO to the program")
    if "figures" in chosen:
        figures(place, limit)
    if "room" in chosen:
        room(place, limit)
    if "towns" in chosen:
        towns(place, limit, patience)
    if "files" in chosen:
        files(place, limit, patience, arguments.models)
    shutil.rmtree(place)


main()
