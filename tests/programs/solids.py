"""Letters, bevels and set operations as STL and 3MF: trimesh, admesh, OpenSCAD and PrusaSlicer find them closed, with the
volume that they have. Needs the Python package trimesh, with lxml and networkx for 3MF; the programs are optional."""

import os
import re
import shutil
import subprocess

from common import azulejo, check, folder, skip

try:
    import numpy as np
    import trimesh
except ImportError:
    skip("trimesh or NumPy is missing (pip install trimesh lxml networkx numpy)")

HERE = os.path.dirname(os.path.abspath(__file__))
FONT = os.path.join(HERE, "../../examples/fonts/dejavu-serif.ppf")
CSG = os.path.join(HERE, "../../examples/csg.grf")
place = folder()


def scene(path):
    """Parts of a file; positions of STL are merged where they are equal."""
    loaded = trimesh.load(path)
    return [loaded] if isinstance(loaded, trimesh.Trimesh) else loaded.dump()


def examine(name, path):
    """Closedness by trimesh; returns the volume."""
    parts = scene(path)
    for part in parts:
        check(f"{name}: watertight", float(part.is_watertight and part.is_winding_consistent), 1, 0)
        sides = np.linalg.norm(part.triangles_cross, axis=1)
        check(f"{name}: triangles without area", float(np.sum(sides == 0)), 0, 0)
    return sum(float(part.volume) for part in parts)


def admesh(name, path):
    if shutil.which("admesh") is None:
        print(f"{name}: admesh is missing")
        return
    told = subprocess.run(["admesh", "-c", path], capture_output=True, text=True, check=True).stdout
    for what in ["Facets with 1 disconnected edge", "Facets with 2 disconnected edges",
                 "Facets with 3 disconnected edges", "Degenerate facets"]:  # fmt: skip
        found = re.search(re.escape(what) + r"\s*:\s*(\d+)", told)
        check(f"{name}: admesh, {what.lower()}", float(found.group(1)), 0, 0)


def slicer(name, path):
    if shutil.which("prusa-slicer") is None:
        print(f"{name}: prusa-slicer is missing")
        return None
    told = subprocess.run(["prusa-slicer", "--info", path], capture_output=True, text=True, check=True).stdout
    check(f"{name}: PrusaSlicer, manifold", float("manifold = yes" in told), 1, 0)
    return sum(float(v) for v in re.findall(r"^volume = ([0-9.]+)", told, re.M))


def openscad(name, path):
    if shutil.which("openscad") is None:
        print(f"{name}: openscad is missing")
        return
    program, cut = os.path.join(place, "cut.scad"), os.path.join(place, "cut.stl")
    with open(program, "w", encoding="utf-8") as out:
        # A set operation, for which OpenSCAD needs a closed volume.
        out.write(f'difference() {{ import("{path}"); translate([-1, -1, -1]) cube(0.5); }}')
    told = subprocess.run(["openscad", "-o", cut, program], capture_output=True, text=True, check=False)
    check(f"{name}: OpenSCAD, exit code", float(told.returncode), 0, 0)
    check(f"{name}: OpenSCAD, warnings", float("not closed" in told.stderr or "ERROR" in told.stderr), 0, 0)


volumes = {}
text = ["text", "Azulejo & 8@%", "--ppf", FONT, "--size", "40", "--depth", "5"]
for kind, more in {"flat": [], "round": ["--bevel", "1"], "both": ["--bevel", "chamfer:0.8:both"]}.items():
    for tolerance in ["0.4", "0.04", "0.004"]:
        path = os.path.join(place, f"{kind}-{tolerance}")
        for extension in ["stl", "3mf"]:
            file = f"{path}.{extension}"
            azulejo(*text, *more, "--tolerance", tolerance, "-o", file)
            volumes[kind, tolerance, extension] = examine(f"{kind} {tolerance} {extension}", file)
            if tolerance == "0.04":
                volume = slicer(f"{kind} {extension}", file)
                if volume is not None:
                    check(f"{kind} {extension}: PrusaSlicer, volume", volume / volumes[kind, tolerance, extension], 1, 1e-3)
        if tolerance == "0.04":
            admesh(kind, f"{path}.stl")
            openscad(kind, f"{path}.stl")
    coarse, middle, fine = (volumes[kind, tolerance, "stl"] for tolerance in ["0.4", "0.04", "0.004"])
    check(f"{kind}: volume, in 3MF by that in STL", volumes[kind, "0.004", "3mf"] / fine, 1, 1e-5)
    check(f"{kind}: volume at 0.04 by that at 0.004", middle / fine, 1, 2e-3)
    check(f"{kind}: converges", float(abs(coarse - fine) > 3 * abs(middle - fine)), 1, 0)

for extension in ["stl", "3mf"]:
    path = os.path.join(place, f"csg.{extension}")
    azulejo("convert", CSG, "--tolerance", "0.003", "-o", path)
    if extension == "stl":
        admesh("csg", path)
