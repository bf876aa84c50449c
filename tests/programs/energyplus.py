"""EnergyPlus reads our factors of a room of 4 × 3 × 2.5 m, as IDF and epJSON, and prints the same
factors and their script F. Needs the Python wheel pyenergyplus-lbnl."""

import json
import os
import subprocess
import sys

from common import CUBE, azulejo, check, folder, read_mtx, script_f, skip, write_obj

try:
    import pyenergyplus.api  # noqa: F401
except ImportError:
    skip("EnergyPlus is missing (pip install pyenergyplus-lbnl)")

SIZE = (4.0, 3.0, 2.5)
EPS = 0.8
KIND = {"floor": ("Floor", "Ground", "NoSun", "NoWind"), "ceiling": ("Roof", "Outdoors", "SunExposed", "WindExposed")}
WALL = ("Wall", "Outdoors", "SunExposed", "WindExposed")
ROOM = {name: [tuple(x * s for x, s in zip(p, SIZE)) for p in square] for name, square in CUBE.items()}

IDF = """
Version,26.1;
SimulationControl,No,No,No,Yes,No;
Building,Box,0,Suburbs,0.04,0.4,FullExterior,25,6;
Timestep,4;
Site:Location,Here,50,0,0,100;
SizingPeriod:DesignDay,Cold,1,21,WinterDesignDay,-10,0,,,Wetbulb,-10,,,,,101325,3,0,No,No,No,ASHRAEClearSky,,,,,0;
GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World;
Material,Stone,Rough,0.2,1.5,2300,900,{eps},0.7,0.7;
Construction,Massive,Stone;
Zone,Room,0,0,0,0,1,1,autocalculate,autocalculate;
Output:Surfaces:List,ViewFactorInfo,IDF;
"""


def surface(name):
    kind, outside, sun, wind = KIND.get(name, WALL)
    # Corners are counter-clockwise as seen from outside.
    corners = ", ".join(f"{x}, {y}, {z}" for x, y, z in reversed(ROOM[name]))
    return (f"BuildingSurface:Detailed,{name},{kind},Massive,Room,,{outside},,{sun},{wind},"
            f"autocalculate,4,{corners};\n")  # fmt: skip


def simulate(place, file):
    code = ("import sys; from pyenergyplus.api import EnergyPlusAPI as E; a = E(); "
            "sys.exit(a.runtime.run_energyplus(a.state_manager.new_state(), sys.argv[1:]))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code, "-D", "-d", place, file],
                          capture_output=True, text=True)  # fmt: skip
    errors = open(os.path.join(place, "eplusout.err")).read()
    if done.returncode != 0 or "** Severe" in errors:
        raise SystemExit(f"EnergyPlus failed:\n{errors}\n{done.stderr[-2000:]}")
    if "UserViewFactors" in errors:
        print(errors)
    return open(os.path.join(place, "eplusout.eio")).read()


def table(eio, title):
    """Rows by name of a table of the .eio, whose names are those of its heading."""
    rows, names = {}, None
    for line in eio.splitlines():
        words = [w.strip().lower() for w in line.split(",")]
        if words[0] == title:
            names = [w for w in words if w in ROOM]
        elif names and len(words) > len(names) and words[1] in ROOM:
            rows[words[1]] = dict(zip(names, map(float, words[-len(names):])))
        elif names:
            return rows
    return rows


def examine(eio, factors):
    names = list(ROOM)
    grey = script_f(factors, [EPS] * 6)
    for title, expected in [("final viewfactors", factors), ("script f factors", grey)]:
        found = table(eio, title)
        if set(found) != set(names):
            raise SystemExit(f"no table {title}:\n" + "\n".join(l for l in eio.splitlines() if "Factor" in l))
        worst = max(abs(found[a][b] - expected[i][j]) for i, a in enumerate(names) for j, b in enumerate(names))
        check(f"{title}, largest difference", worst, 0.0, 5.1e-5)
    check("Script F from floor to south", table(eio, "script f factors")["floor"]["south"], 0.1565, 5.1e-5)


def main():
    place = folder()
    model = os.path.join(place, "room.obj")
    write_obj(model, {name: [square] for name, square in ROOM.items()})
    for file in ["factors.idf", "factors.epjson", "factors.mtx"]:
        azulejo("form-factors", model, "-o", os.path.join(place, file), "--by", "object", "--zone",
                "Room", "--patch-size", "0", "--engine", "analytic", "--closure")  # fmt: skip
    factors = read_mtx(os.path.join(place, "factors.mtx"))
    base = IDF.format(eps=EPS) + "".join(map(surface, ROOM))
    idf = os.path.join(place, "room.idf")
    with open(idf, "w") as out:
        out.write(base + open(os.path.join(place, "factors.idf")).read())
    print("IDF")
    examine(simulate(place, idf), factors)
    # JSON's object is merged into a model that EnergyPlus converts itself.
    given = json.load(open(os.path.join(place, "factors.epjson")))
    ours = given["ZoneProperty:UserViewFactors:BySurfaceName"]["Room factors"]["view_factors"]
    check("triples of the epJSON", len(ours), 36, 0)
    converted = convert(place, base)
    if converted is None:
        print("skipped: this EnergyPlus does not convert to epJSON")
        return
    converted.update(given)
    path = os.path.join(place, "room.epJSON")
    json.dump(converted, open(path, "w"))
    print("epJSON")
    examine(simulate(place, path), factors)


def convert(place, base):
    """The model as epJSON, by EnergyPlus."""
    path = os.path.join(place, "base.idf")
    with open(path, "w") as out:
        out.write(base)
    code = ("import sys; from pyenergyplus.api import EnergyPlusAPI as E; a = E(); "
            "sys.exit(a.runtime.run_energyplus(a.state_manager.new_state(), sys.argv[1:]))")  # fmt: skip
    out = os.path.join(place, "converted")
    os.makedirs(out)
    subprocess.run([sys.executable, "-c", code, "-c", "-D", "-d", out, path],
                   cwd=out, capture_output=True)  # fmt: skip
    for root in [out, place]:
        for file in os.listdir(root):
            if file.lower() == "base.epjson":
                return json.load(open(os.path.join(root, file)))
    return None


main()
