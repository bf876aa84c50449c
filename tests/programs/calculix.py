"""CalculiX reads our .vwf: two and three faces, each that of a brick of known temperature, against a
network of their radiosities; the inside of a box, whose loads are in no order, against its own symmetry; and, if its tests
are installed, a deck of them against its own factors. Needs `ccx` 2.20 (Debian: calculix-ccx, calculix-ccx-test)."""

import gzip
import itertools
import math
import os
import re
import subprocess

from common import CUBE, azulejo, check, folder, grey_fluxes, need, read_mtx, write_obj

EPS = 0.8
# Three faces of unequal area and emissivity: two meet at an edge, one is smaller and turned to both.
STEP = {
    "base": [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)],
    "riser": [(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)],
    "visor": [(1.2, 0.1, 1.1), (1.2, 0.9, 1.1), (1.8, 0.9, 0.6), (1.8, 0.1, 0.6)],
}


def brick(square):
    """The corners of a brick outside of a rectangle, whose face S1 is the rectangle."""
    outward = [-0.1 * n for n in normal(square)]
    # S1 is counter-clockwise as seen from inside of the brick.
    near = list(reversed(square))
    return near + [tuple(x + d for x, d in zip(p, outward)) for p in near]


def normal(square):
    """Of length 1."""
    a, b = ([q - p for p, q in zip(square[0], square[k])] for k in (1, 3))
    n = [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]
    return [x / math.hypot(*n) for x in n]


def area(square):
    return math.dist(square[0], square[1]) * math.dist(square[0], square[3])


def deck(squares, eps, temperatures):
    """Bricks whose back is held at a temperature, and which conduct so well that the face is as warm.
    What is conducted is what is radiated."""
    lines = ["*NODE, NSET=ALL"]
    for e, square in enumerate(squares):
        for k, p in enumerate(brick(square)):
            lines.append(f"{8 * e + k + 1}, " + ", ".join(f"{x:.6f}" for x in p))
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=BRICKS")
    for e in range(len(squares)):
        lines.append(", ".join(str(n) for n in [e + 1, *range(8 * e + 1, 8 * e + 9)]))
    for e in range(len(squares)):
        lines += [f"*NSET, NSET=N{e}, GENERATE", f"{8 * e + 5}, {8 * e + 8}"]
    lines += [
        "*MATERIAL, NAME=M", "*CONDUCTIVITY", "1.E6",
        "*SOLID SECTION, ELSET=BRICKS, MATERIAL=M",
        "*PHYSICAL CONSTANTS, ABSOLUTE ZERO=0., STEFAN BOLTZMANN=5.670374419E-8",
        "*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, 300.",
        "*STEP", "*HEAT TRANSFER, STEADY STATE",
        "*VIEWFACTOR, READ, INPUT=faces.vwf",
        "*BOUNDARY",
    ]  # fmt: skip
    lines += [f"N{e}, 11, 11, {t}" for e, t in enumerate(temperatures)]
    lines.append("*RADIATE, CAVITY=ONE")
    lines += [f"{e + 1}, R1CR, 0., {x}" for e, x in enumerate(eps)]
    for e in range(len(squares)):
        lines += [f"*NODE PRINT, NSET=N{e}, TOTALS=ONLY", "RFL"]
    return "\n".join([*lines, "*END STEP", ""])


def run(what, faces, eps, temperatures, known=None):
    """Heat of each face in W, by CalculiX and by theory."""
    place = folder()
    model = os.path.join(place, "faces.obj")
    write_obj(model, {name: [square] for name, square in faces.items()})
    for file in ["faces.vwf", "faces.mtx"]:
        azulejo("form-factors", model, "-o", os.path.join(place, file), "--patch-size", "0",
                "--engine", "analytic")  # fmt: skip
    with open(os.path.join(place, "deck.inp"), "w") as out:
        out.write(deck(list(faces.values()), eps, temperatures))
    done = subprocess.run(["ccx", "deck"], cwd=place, capture_output=True, text=True)
    with open(os.path.join(place, "deck.dat")) as lines:
        found = re.findall(r"total heat.*?\n\s*\n?\s*(-?[0-9.]+E?[-+]?[0-9]*)", lines.read())
    if len(found) != len(faces):
        raise SystemExit(f"no heat in {place}/deck.dat:\n{done.stdout[-2000:]}")
    fluxes = grey_fluxes(read_mtx(os.path.join(place, "faces.mtx")), eps, temperatures)
    expected = known or [q * area(square) for q, square in zip(fluxes, faces.values())]
    for name, heat, theory in zip(faces, found, expected):
        check(f"{what}: heat of {name}, W:", float(heat), theory, 1e-5 * abs(expected[0]))


# The bricks around the cavity of a box, by their places in a grid of three, with the face that looks into it.
CAVITY = {(1, 1, 0): 2, (1, 1, 2): 1, (1, 0, 1): 5, (1, 2, 1): 3, (0, 1, 1): 4, (2, 1, 1): 6}
GRID = [0.0, 0.2, 2.2, 2.4]


def box():
    """A deck of 26 bricks around a cavity, hot below and cold above, with the loads in no order."""
    node = lambda i, j, k: 1 + i + 4 * j + 16 * k
    lines = ["*NODE, NSET=ALL"]
    for k, j, i in itertools.product(range(4), repeat=3):
        lines.append(f"{node(i, j, k)}, {GRID[i]}, {GRID[j]}, {GRID[k] / 2}")
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=BRICKS")
    numbers, loads = {}, {}
    for k, j, i in itertools.product(range(3), repeat=3):
        if (i, j, k) == (1, 1, 1):
            continue
        numbers[i, j, k] = e = len(numbers) + 1
        ring = lambda z: [node(i + a, j + b, z) for a, b in [(0, 0), (1, 0), (1, 1), (0, 1)]]
        lines.append(", ".join(map(str, [e, *ring(k), *ring(k + 1)])))
        # The third face looks along −y, the fourth along x, the fifth along y, the sixth along −x.
        if (i, j, k) in CAVITY:
            loads[e] = CAVITY[i, j, k]
    square = lambda k: ", ".join(str(node(i, j, k)) for i in (1, 2) for j in (1, 2))
    order = list(loads)[::2] + list(loads)[1::2]
    lines += [
        "*NSET, NSET=HOT", square(0), "*NSET, NSET=COLD", square(3),
        "*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, 300.",
        "*MATERIAL, NAME=M", "*CONDUCTIVITY", "1.,0.",
        "*PHYSICAL CONSTANTS, ABSOLUTE ZERO=0., STEFAN BOLTZMANN=5.67E-8",
        "*SOLID SECTION, ELSET=BRICKS, MATERIAL=M",
        "*STEP, INC=100", "*HEAT TRANSFER, STEADY STATE", "1., 1.",
        "*BOUNDARY", "HOT, 11, 11, 600.", "COLD, 11, 11, 300.",
        "*VIEWFACTOR, READ, INPUT=deck.vwf",
        "*RADIATE", *[f"{e}, R{loads[e]}CR, 300., 0.8" for e in order],
        "*NODE PRINT, NSET=ALL", "NT", "*END STEP", "",
    ]  # fmt: skip
    return "\n".join(lines), node


def temperatures(place, job):
    """Those of all nodes at the end."""
    done = subprocess.run(["ccx", job], cwd=place, capture_output=True, text=True)
    with open(os.path.join(place, f"{job}.dat")) as lines:
        blocks = lines.read().split("temperatures")
    numbers = [line.split() for line in blocks[-1].splitlines()]
    found = {int(n[0]): float(n[1]) for n in numbers if len(n) == 2 and n[0].isdigit()}
    if not found:
        raise SystemExit(f"no temperatures in {place}/{job}.dat:\n{done.stdout[-2000:]}")
    return found


def symmetric_box():
    place, (text, node) = folder(), box()
    with open(os.path.join(place, "deck.inp"), "w") as out:
        out.write(text)
    azulejo("form-factors", os.path.join(place, "deck.inp"), "-o", os.path.join(place, "deck.vwf"),
            "--patch-size", "0", "--tolerance", "1e-9")  # fmt: skip
    found = temperatures(place, "deck")
    pairs = [((1, 1, k), (2, 2, k)) for k in range(4)] + [((0, 1, k), (1, 0, k)) for k in range(4)]
    worst = max(abs(found[node(*a)] - found[node(*b)]) for a, b in pairs)
    check("a box: largest difference of nodes that mirror each other, K", worst, 0.0, 1e-2)


def deck_of_its_tests():
    packed = "/usr/share/doc/calculix-ccx-test/examples/test/beamhtcr.inp.gz"
    if not os.path.exists(packed):
        print("skipped: the tests of CalculiX are missing (apt-get install calculix-ccx-test)")
        return
    with gzip.open(packed, "rt") as lines:
        text = lines.read()
    place = folder()
    for job, mode in [("own", None), ("ours", "*VIEWFACTOR, READ, INPUT=ours.vwf\n*RADIATE")]:
        with open(os.path.join(place, f"{job}.inp"), "w") as out:
            out.write(text.replace("*RADIATE", mode) if mode else text)
    azulejo("form-factors", os.path.join(place, "ours.inp"), "-o", os.path.join(place, "ours.vwf"),
            "--patch-size", "0")  # fmt: skip
    own, ours = (temperatures(place, job) for job in ["own", "ours"])
    worst = max(abs(own[n] - ours[n]) for n in own)
    mean = sum(abs(own[n] - ours[n]) for n in own) / len(own)
    print(f"beamhtcr.inp: {len(own)} nodes, with our factors and its own off by {mean:.2g} K in the mean")
    # Its own factors are of single triangles at their centres.
    check("beamhtcr.inp: largest difference, K", worst, 0.0, 10.0)


need("ccx", "apt-get install calculix-ccx")
symmetric_box()
deck_of_its_tests()
some = lambda *names: {name: CUBE[name] for name in names}
run("two faces", some("floor", "ceiling"), [EPS] * 2, [500.0, 300.0], [2758.212, -88.869])
run("three faces", some("floor", "ceiling", "east"), [EPS] * 3, [600.0, 300.0, 450.0])
run("a corner", some("floor", "west", "south"), [0.9, 0.5, 0.3], [650.0, 300.0, 400.0])
run("unequal areas", STEP, [0.9, 0.6, 0.4], [600.0, 320.0, 450.0])
