"""What the scripts for OpenFOAM share: running its programs, and reading its lists."""

import os
import re
import subprocess

# OpenFOAM computes it from six digits of h, k and c.
SIGMA_OF_OPENFOAM = 5.67040856e-8

# Debian's package needs to be told where it is.
if os.path.isdir("/usr/share/openfoam"):
    os.environ.setdefault("WM_PROJECT_DIR", "/usr/share/openfoam")


def run(program, place, *arguments):
    """Runs a program of OpenFOAM in a case; returns what it prints."""
    done = subprocess.run([program, *arguments], cwd=place, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{program} failed in {place}:\n{done.stdout[-2500:]}\n{done.stderr[-2500:]}")
    return done.stdout


def patch_values(path, lengths):
    """Values of a field by patch; uniform ones as often as the patch has faces."""
    text = open(path).read()
    text = text[text.index("boundaryField"):]
    found = {}
    for patch, length in lengths.items():
        block = re.search(rf"\b{patch}\s*\{{(.*?)\}}", text, re.S).group(1)
        many = re.search(r"\bvalue\s+nonuniform List<scalar>\s*\d*\s*\(([^)]*)\)", block)
        one = re.search(r"\bvalue\s+uniform ([-0-9.e+]+)", block)
        found[patch] = [float(x) for x in many.group(1).split()] if many else [float(one.group(1))] * length
    return found


def patch_lengths(place):
    """Number of faces of each patch of the mesh in this folder."""
    text = open(os.path.join(place, "polyMesh/boundary")).read()
    entries = re.findall(r"(\w+)\s*\{([^{}]*\bnFaces[^{}]*)\}", text)
    return {name: int(re.search(r"\bnFaces\s+(\d+)", entry).group(1)) for name, entry in entries}


def row_sums(path):
    """Sums of the rows of a file F in text."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/|FoamFile\s*\{.*?\}", "", open(path).read(), flags=re.S)
    rows = re.finditer(r"(\d+)\s*\(([^()]*)\)|(\d+)\{([^}]*)\}", text)
    # 3{0.1} is OpenFOAM's notation of three equal values.
    return [sum(map(float, m[2].split())) if m[1] else int(m[3]) * float(m[4]) for m in rows]
