"""Runs another program for form factors on models: python3 peers.py PEER [--fineness X] MODEL.obj..., or PEER --version.

PEER is view3d, pyviewfactor or raystrack. An OBJ has triangles and quads, counter-clockwise as seen from the front,
each of which is a row; all block light from both sides. Printed is one JSON object for each model, in a line: `program`,
`seconds` of CPU for the computation, `peak_mib` of memory, and `factors`, the full matrix; or `program` and `error`, if
there are several models and the program fails with one. Exit code 3 says that the program is missing.
"""

import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time

SQUARES = [
    [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)],
    [(0.0, 0.0, 1.0), (0.0, 1.0, 1.0), (1.0, 1.0, 1.0), (1.0, 0.0, 1.0)],
]


def missing(why):
    print(why, file=sys.stderr)
    sys.exit(3)


def read_obj(path):
    """The polygons, each a list of (x, y, z)."""
    points, polygons = [], []
    with open(path) as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["v"]:
                points.append(tuple(map(float, words[1:4])))
            elif words[:1] == ["f"]:
                numbers = [int(word.split("/")[0]) for word in words[1:]]
                polygons.append([points[k - 1 if k > 0 else k] for k in numbers])
                if len(numbers) not in (3, 4):
                    sys.exit(f"{path}: a polygon of {len(numbers)} corners; 3 or 4 are expected")
    return polygons


def numbered(polygons):
    """Distinct points, and each polygon as indices into them: some programs know by these what touches."""
    index = {}
    corners = [[index.setdefault(p, len(index)) for p in polygon] for polygon in polygons]
    return list(index), corners


def split(polygons):
    """Triangles, and the polygon that each is of."""
    triangles, parents = [], []
    for k, polygon in enumerate(polygons):
        for i in range(1, len(polygon) - 1):
            triangles.append([polygon[0], polygon[i], polygon[i + 1]])
            parents.append(k)
    return triangles, parents


def area(triangle):
    (a, b, c) = triangle
    u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
    cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    return 0.5 * sum(x * x for x in cross) ** 0.5


def program(variable, name, how):
    """An executable, named by a variable of the environment or on the path."""
    found = shutil.which(os.environ.get(variable, name))
    return found or missing(f"{name} is missing: {how}, then put it on PATH or set {variable} to it")


def run(command, folder):
    """Runs a program that writes files into a folder: CPU seconds and peak memory, its own."""
    with open(os.path.join(folder, "messages.txt"), "w+") as messages:
        process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=messages, stderr=messages)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            messages.seek(0)
            sys.exit(f"{command[0]} failed with {process.returncode}:\n{messages.read()[-2000:]}")
    return usage.ru_utime + usage.ru_stime, memory(usage)


def memory(usage):
    """The peak in MiB; Linux counts in KiB, macOS in bytes."""
    return usage.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


class OwnTime:
    """CPU seconds of this process, all of its threads included."""

    def __enter__(self):
        self.start = time.process_time()
        return self

    def __exit__(self, *_):
        self.seconds = time.process_time() - self.start

    def result(self, name, factors):
        import resource

        peak = memory(resource.getrusage(resource.RUSAGE_SELF))
        return {"program": name, "seconds": self.seconds, "peak_mib": peak, "factors": factors}


def view3d(polygons, fineness):
    """View3D and its forks; FINENESS is eps, 1e-4 unless given. Its binary output has more digits than its text."""
    executable = program("VIEW3D", "view3d", "build https://github.com/jasondegraw/View3D")
    points, corners = numbered(polygons)
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "in.vs3"), "w") as out:
            out.write(f"T model\nC eps={fineness or 1e-4:g} out=1\nF 3\n")
            out.writelines(f"V {k} {x!r} {y!r} {z!r}\n" for k, (x, y, z) in enumerate(points, 1))
            for k, indices in enumerate(corners, 1):
                numbers = [i + 1 for i in indices] + [0] * (4 - len(indices))
                out.write(f"S {k} {' '.join(map(str, numbers))} 0 0 0.9 s{k}\n")
            out.write("End of data\n")
        seconds, peak = run([executable, "in.vs3", "out.bin"], folder)
        with open(os.path.join(folder, "out.bin"), "rb") as file:
            header, data = file.read(32).decode("ascii", "replace").split(), file.read()
    n = len(polygons)
    if len(header) != 6 or header[5] != str(n):
        sys.exit("View3D wrote no factors")
    # Areas precede the factors, emissivities follow them.
    factors = (struct.unpack_from(f"={n}f", data, 4 * n * (i + 1)) for i in range(n))
    return {"program": " ".join(header[:2]), "seconds": seconds, "peak_mib": peak, "factors": factors}


def pyviewfactor(polygons, fineness):
    """Its matrix [i, j] is the factor from j to i."""
    try:
        import numpy
        import pyviewfactor
        import pyvista
    except ImportError:
        missing("pyviewfactor is missing: pip install pyviewfactor")

    def matrix(polygons):
        points, corners = numbered(polygons)
        faces = [number for indices in corners for number in [len(indices), *indices]]
        mesh = pyvista.PolyData(numpy.array(points), numpy.array(faces))
        return pyviewfactor.compute_viewfactor_matrix(mesh, obstacles=mesh).T

    matrix(SQUARES)  # compiles its functions
    with OwnTime() as own:
        factors = matrix(polygons)
    return own.result(f"pyviewfactor {pyviewfactor.__version__}", factors)


def raystrack(polygons, fineness):
    """FINENESS is the number of rays from each facet; by default there are 10,240 to 204,800 for each unit of area."""
    try:
        import numpy
        import raystrack
        from importlib.metadata import version
    except ImportError:
        missing("raystrack is missing: pip install raystrack")

    options, scale = raystrack.SolveOptions(), 1.0
    if fineness:
        # Rays are shot from cells, 16 at least, more from areas above 16: small ones have 16 cells each.
        scale = max(sum(map(area, split([polygon])[0])) for polygon in polygons) ** -0.5
        options = raystrack.SolveOptions(
            sampling=raystrack.Sampling(density=1, rays_per_cell=max(1, round(fineness / 16))),
            accuracy=raystrack.Accuracy(max_replicates=1, min_replicates=1),
        )

    def matrix(polygons, options):
        meshes = {}
        for k, polygon in enumerate(polygons):
            triangles = [[0, i, i + 1] for i in range(1, len(polygon) - 1)]
            meshes[f"s{k}"] = raystrack.Mesh(numpy.array(polygon) * scale, numpy.array(triangles))
        with raystrack.Solver(raystrack.Scene.from_meshes(meshes), device="cpu") as solver:
            result = solver.solve(raystrack.Query.matrix(receiver_sides=("front",)), options)
        column = {channel: k for k, channel in enumerate(result.channels)}
        order = [column[raystrack.Channel("surface", name, "front")] for name in meshes]
        return result.dense()[:, order]

    few = raystrack.SolveOptions(accuracy=raystrack.Accuracy(max_replicates=1, min_replicates=1))
    # From 512 triangles on it takes other functions; both are compiled.
    matrix(SQUARES, few)
    if len(split(polygons)[0]) >= 512:
        matrix(SQUARES * 128, few)
    with OwnTime() as own:
        factors = matrix(polygons, options)
    return own.result(f"raystrack {version('raystrack')}", factors)


PEERS = {"view3d": view3d, "pyviewfactor": pyviewfactor, "raystrack": raystrack}


def main(arguments):
    if len(arguments) < 2 or arguments[0] not in PEERS:
        sys.exit(f"usage: peers.py {'|'.join(PEERS)} [--fineness X] MODEL.obj..., or PEER --version")
    name, *models = arguments
    if models == ["--version"]:
        print(PEERS[name](SQUARES, None)["program"])
        return
    fineness = None
    if models[0] == "--fineness":
        fineness, models = float(models[1]), models[2:]
    for model in models:
        try:
            found = PEERS[name](read_obj(model), fineness)
        except SystemExit as stop:
            if stop.code == 3 or len(models) == 1:
                raise
            print(json.dumps({"program": name, "error": str(stop.code)}))
            continue
        write(found)


def write(found):
    # Row by row, and most are zeros: matrices of thousands of rows would take gigabytes otherwise.
    rows = found.pop("factors")
    sys.stdout.write(json.dumps(found)[:-1] + ', "factors": [')
    for i, row in enumerate(rows):
        numbers = ",".join("0" if x == 0 else repr(x) for x in map(float, row))
        sys.stdout.write(("," if i else "") + f"[{numbers}]")
    sys.stdout.write("]}\n")


if __name__ == "__main__":
    main(sys.argv[1:])
