"""CalculiX reads our .vwf: two and three squares of a cube, each the face of a brick of known
temperature. Needs `ccx` 2.20 (Debian: calculix-ccx)."""

import os
import re
import subprocess

from common import CUBE, azulejo, check, folder, grey_fluxes, need, read_mtx, write_obj

EPS = 0.8


def brick(name):
    """The corners of a brick outside of a square, whose face S1 is the square."""
    square = CUBE[name]
    centre = [sum(p[k] for p in square) / 4 for k in range(3)]
    outward = [0.2 * (c - 0.5) for c in centre]
    # S1 is counter-clockwise as seen from inside of the brick.
    near = list(reversed(square))
    return near + [tuple(x + d for x, d in zip(p, outward)) for p in near]


def deck(names, temperatures):
    """Bricks whose back is held at a temperature, and which conduct so well that the face is as warm.
    What is conducted is what is radiated."""
    lines = ["*NODE, NSET=ALL"]
    for e, name in enumerate(names):
        for k, p in enumerate(brick(name)):
            lines.append(f"{8 * e + k + 1}, " + ", ".join(f"{x:.6f}" for x in p))
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=BRICKS")
    for e in range(len(names)):
        lines.append(", ".join(str(n) for n in [e + 1, *range(8 * e + 1, 8 * e + 9)]))
    for e in range(len(names)):
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
    lines += [f"{e + 1}, R1CR, 0., {EPS}" for e in range(len(names))]
    for e in range(len(names)):
        lines += [f"*NODE PRINT, NSET=N{e}, TOTALS=ONLY", "RFL"]
    return "\n".join([*lines, "*END STEP", ""])


def run(names, temperatures, known=None):
    place = folder()
    model = os.path.join(place, "faces.obj")
    write_obj(model, {name: [CUBE[name]] for name in names})
    for file in ["faces.vwf", "faces.mtx"]:
        azulejo("form-factors", model, "-o", os.path.join(place, file), "--patch-size", "0",
                "--engine", "analytic")  # fmt: skip
    with open(os.path.join(place, "deck.inp"), "w") as out:
        out.write(deck(names, temperatures))
    done = subprocess.run(["ccx", "deck"], cwd=place, capture_output=True, text=True)
    with open(os.path.join(place, "deck.dat")) as lines:
        found = re.findall(r"total heat.*?\n\s*\n?\s*(-?[0-9.]+E?[-+]?[0-9]*)", lines.read())
    if len(found) != len(names):
        raise SystemExit(f"no heat in {place}/deck.dat:\n{done.stdout[-2000:]}")
    factors = read_mtx(os.path.join(place, "faces.mtx"))
    expected = known or grey_fluxes(factors, [EPS] * len(names), temperatures)
    for name, heat, theory in zip(names, found, expected):
        check(f"heat of {name}, W:", float(heat), theory, 1e-5 * abs(expected[0]))


need("ccx", "apt-get install calculix-ccx")
run(["floor", "ceiling"], [500.0, 300.0], [2758.212, -88.869])
run(["floor", "ceiling", "east"], [600.0, 300.0, 450.0])
