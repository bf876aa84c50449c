"""Writes one room in three formats: meshio writes room.bdf and room.inp, this program the mesh of OpenFOAM.

Two cells along each axis; floor, lid and walls look into the room. python3 make.py, with meshio 5.3.
"""
import meshio
import numpy as np

N = 2
at = lambda x, y, z: x + (N + 1) * (y + (N + 1) * z)
axis = range(N + 1)
points = np.array([[x / 2, y / 2, 0.125 + z / 2] for z in axis for y in axis for x in axis])

def sheet(corner):
    """Quadrilaterals over a sheet whose corners are given by two numbers."""
    steps = [(0, 0), (1, 0), (1, 1), (0, 1)]
    return [[at(*corner(u + du, v + dv)) for du, dv in steps] for v in range(N) for u in range(N)]

patches = {
    "floor": sheet(lambda u, v: (u, v, 0)),
    "lid": sheet(lambda u, v: (v, u, N)),
    "walls": sheet(lambda u, v: (0, u, v)) + sheet(lambda u, v: (N, v, u))
    + sheet(lambda u, v: (v, 0, u)) + sheet(lambda u, v: (u, N, v)),
}

quads = np.array(sum(patches.values(), []))
ends = np.cumsum([len(p) for p in patches.values()])
sets = {n: [np.arange(e - len(p), e)] for (n, p), e in zip(patches.items(), ends)}
refs = np.repeat([1, 2, 3], [len(p) for p in patches.values()])
mesh = meshio.Mesh(points, [("quad", quads)], cell_data={"nastran:ref": [refs]}, cell_sets=sets)
mesh.write("room.bdf")
mesh.write("room.inp")
text = open("room.bdf").read()
names = "".join(f'$HMNAME COMP {k + 1:>20}"{name}"\n' for k, name in enumerate(patches))
open("room.bdf", "w").write(text.replace("BEGIN BULK\n", "BEGIN BULK\n" + names))

def inner(cell):
    """The internal faces of a cell towards larger coordinates."""
    x, y, z = cell
    if x + 1 < N:
        yield [at(x + 1, y, z), at(x + 1, y + 1, z), at(x + 1, y + 1, z + 1), at(x + 1, y, z + 1)]
    if y + 1 < N:
        yield [at(x, y + 1, z), at(x, y + 1, z + 1), at(x + 1, y + 1, z + 1), at(x + 1, y + 1, z)]
    if z + 1 < N:
        yield [at(x, y, z + 1), at(x + 1, y, z + 1), at(x + 1, y + 1, z + 1), at(x, y + 1, z + 1)]

cells = [(x, y, z) for z in range(N) for y in range(N) for x in range(N)]
internal = [face for cell in cells for face in inner(cell)]
outer = [[f[0], *f[:0:-1]] for f in quads.tolist()]

def foam(name, kind, text):
    head = f"FoamFile\n{{\n    version 2.0;\n    format ascii;\n    class {kind};\n    object {name};\n}}\n\n"
    open(f"room/constant/polyMesh/{name}", "w").write(head + text)

def rows(list_of, show):
    return f"{len(list_of)}\n(\n" + "".join(show(x) + "\n" for x in list_of) + ")\n"

foam("points", "vectorField", rows(points, lambda p: "({} {} {})".format(*p)))
foam("faces", "faceList", rows(internal + outer, lambda f: "4({} {} {} {})".format(*f)))
first = len(internal)
entries = []
for name, patch in patches.items():
    entries.append(f"    {name}\n    {{\n        type wall;\n        nFaces {len(patch)};\n        startFace {first};\n    }}")
    first += len(patch)
foam("boundary", "polyBoundaryMesh", rows(entries, str))
open("room/room.foam", "w").close()
