"""CalculiX reads our .vwf: two and three faces, each that of a brick of known temperature, against a
network of their radiosities. Needs `ccx` 2.20 (Debian: calculix-ccx)."""

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


need("ccx", "apt-get install calculix-ccx")
some = lambda *names: {name: CUBE[name] for name in names}
run("two faces", some("floor", "ceiling"), [EPS] * 2, [500.0, 300.0], [2758.212, -88.869])
run("three faces", some("floor", "ceiling", "east"), [EPS] * 3, [600.0, 300.0, 450.0])
run("a corner", some("floor", "west", "south"), [0.9, 0.5, 0.3], [650.0, 300.0, 400.0])
run("unequal areas", STEP, [0.9, 0.6, 0.4], [600.0, 320.0, 450.0])
