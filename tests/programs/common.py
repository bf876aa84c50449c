"""What the scripts share: the command under test, models, and grey exchange by elimination."""

import os
import shutil
import subprocess
import sys
import tempfile

SIGMA = 5.670374419e-8

# A cube's squares by name, each counter-clockwise as seen from inside.
CUBE = {
    "floor": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
    "ceiling": [(0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 0, 1)],
    "south": [(0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0)],
    "north": [(0, 1, 0), (1, 1, 0), (1, 1, 1), (0, 1, 1)],
    "west": [(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)],
    "east": [(1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0)],
}


def skip(why):
    print(f"skipped: {why}")
    sys.exit(0)


def need(program, package):
    if shutil.which(program) is None:
        skip(f"{program} is missing ({package})")


def azulejo(*arguments):
    """Runs the command; AZULEJO names it if it is not on the path."""
    command = os.environ.get("AZULEJO", "azulejo")
    if shutil.which(command) is None:
        skip(f"{command} is missing: set AZULEJO to the program")
    done = subprocess.run([command, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{command} failed:\n{done.stderr}")


def folder():
    return tempfile.mkdtemp(prefix="azulejo-programs-")


def write_obj(path, objects):
    """Polygons by object, each a list of polygons of (x, y, z)."""
    count = 0
    with open(path, "w") as out:
        for name, polygons in objects.items():
            out.write(f"o {name}\n")
            for polygon in polygons:
                out.writelines(f"v {x:.17g} {y:.17g} {z:.17g}\n" for x, y, z in polygon)
                numbers = range(count + 1, count + 1 + len(polygon))
                out.write("f " + " ".join(map(str, numbers)) + "\n")
                count += len(polygon)


def read_mtx(path):
    """A matrix of Matrix Market."""
    with open(path) as lines:
        lines = [line for line in lines if not line.startswith("%")]
    n = int(lines[0].split()[0])
    matrix = [[0.0] * n for _ in range(n)]
    for line in lines[1:]:
        i, j, f = line.split()
        matrix[int(i) - 1][int(j) - 1] = float(f)
    return matrix


def solve(matrix, right):
    """Gaussian elimination with pivoting."""
    rows = [list(row) + [b] for row, b in zip(matrix, right)]
    n = len(rows)
    for k in range(n):
        p = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[p] = rows[p], rows[k]
        for i in range(k + 1, n):
            ratio = rows[i][k] / rows[k][k]
            for j in range(k, n + 1):
                rows[i][j] -= ratio * rows[k][j]
    x = [0.0] * n
    for k in reversed(range(n)):
        x[k] = (rows[k][n] - sum(rows[k][j] * x[j] for j in range(k + 1, n))) / rows[k][k]
    return x


def grey_fluxes(factors, eps, temperatures, sigma=SIGMA):
    """Net flux that leaves each row, in W/m², with black surroundings at 0 K."""
    n = len(factors)
    emitted = [e * sigma * t**4 for e, t in zip(eps, temperatures)]
    system = [
        [(i == j) - (1 - eps[i]) * factors[i][j] for j in range(n)] for i in range(n)
    ]
    radiosity = solve(system, emitted)
    incident = [sum(f * j for f, j in zip(row, radiosity)) for row in factors]
    return [e - a * h for e, a, h in zip(emitted, eps, incident)]


def script_f(factors, eps):
    """ε_i B_ij: what i emits and j absorbs, per area of i and σT⁴."""
    n = len(factors)
    system = [
        [(i == k) - factors[i][k] * (1 - eps[k]) for k in range(n)] for i in range(n)
    ]
    columns = []
    for j in range(n):
        right = [factors[i][j] * eps[j] for i in range(n)]
        columns.append([eps[i] * b for i, b in enumerate(solve(system, right))])
    return [list(row) for row in zip(*columns)]


def check(what, found, expected, tolerance):
    error = abs(found - expected)
    state = "ok" if error <= tolerance else "WRONG"
    print(f"{state}: {what} {found:.9g}, expected {expected:.9g}, off by {error:.2g}")
    if state != "ok":
        sys.exit(1)
