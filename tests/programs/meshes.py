"""Meshes that gmsh and meshio write of one scene, a floor and a slanted lid: from every format the same
matrix, sorted by name and place. Needs gmsh (pip install gmsh), NumPy, and for its part meshio."""

import os

from common import azulejo, check, folder, skip

try:
    import gmsh
    import numpy as np
except (ImportError, OSError):
    skip("gmsh or NumPy is missing (pip install gmsh numpy)")
try:
    import meshio
except ImportError:
    meshio = None

# Corners and nodes are binary fractions, exact in every format.
PLATES = {
    "floor": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
    "lid": [(0, 0, 0.5), (0, 1, 0.5), (1, 1, 0.75), (1, 0, 0.75)],
}
TAGS = {"floor": 7, "lid": 9}
NODES = 5

NAMED = {"floor": "floor", "lid": "lid"}
PHYSICAL = {"floor": "gmsh:physical 7", "lid": "gmsh:physical 9"}
PROPERTIES = {"floor": "PID 7", "lid": "PID 9"}
CELLS = {"floor": "CellEntityIds 7", "lid": "CellEntityIds 9"}


def plate(name, corners, quads):
    """A surface of a regular mesh; gmsh's own mesher would round."""
    tag = gmsh.model.addDiscreteEntity(2)
    a, b, _, d = (np.array(c, float) for c in corners)
    steps = np.arange(NODES) / (NODES - 1)
    points = [a + s * (b - a) + t * (d - a) for t in steps for s in steps]
    numbers = np.arange(len(points)).reshape(NODES, NODES) + 1 + (tag - 1) * NODES**2
    gmsh.model.mesh.addNodes(2, tag, numbers.ravel(), np.ravel(points))
    cells = zip(*(m.ravel() for m in (numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1])))
    faces = [[p, q, r, s] if quads else [p, q, r, p, r, s] for p, q, r, s in cells]
    gmsh.model.mesh.addElementsByType(tag, 3 if quads else 2, [], np.ravel(faces))
    gmsh.model.addPhysicalGroup(2, [tag], TAGS[name], name)


def write_by_gmsh(place, quads):
    """Files, and the names that their objects have."""
    gmsh.initialize()
    options = {"General.Terminal": 0, "Mesh.SaveElementTagType": 2, "Mesh.StlOneSolidPerSurface": 2}
    for option, value in options.items():
        gmsh.option.setNumber(option, value)
    for name, corners in PLATES.items():
        plate(name, corners, quads)
    files = {}

    def write(file, names, **options):
        for option, value in options.items():
            gmsh.option.setNumber(f"Mesh.{option}", value)
        files[file] = names
        gmsh.write(os.path.join(place, file))

    for version in [2.2, 4.1]:
        for binary, kind in enumerate(["text", "binary"]):
            write(f"gmsh {version} {kind}.msh", NAMED, MshFileVersion=version, Binary=binary)
    write("gmsh binary.vtk", CELLS)
    write("gmsh.vtk", CELLS, Binary=0)
    write("gmsh.inp", NAMED)
    for field, kind in enumerate(["free", "small", "large"]):
        write(f"gmsh {kind}.bdf", PROPERTIES, BdfFieldFormat=field)
    if not quads:
        write("gmsh.stl", NAMED)
    gmsh.finalize()
    return files


def write_by_meshio(place, quads):
    """The same from the mesh that meshio reads; None for files without names."""
    files = {}

    def write(file, names, form=None, **options):
        mesh = meshio.read(os.path.join(place, "gmsh 4.1 text.msh"))
        if form == "gmsh":
            # This writer stops at what the reader has added.
            mesh.cell_sets.clear()
        mesh.cell_data["nastran:ref"] = mesh.cell_data["gmsh:physical"]
        files[file] = names
        mesh.write(os.path.join(place, file), file_format=form, **options)

    for binary, kind in enumerate(["text", "binary"]):
        write(f"meshio 2.2 {kind}.msh", NAMED, "gmsh22", binary=bool(binary))
        write(f"meshio 4.1 {kind}.msh", NAMED, "gmsh", binary=bool(binary))
        write(f"meshio {kind}.vtu", PHYSICAL, "vtu", binary=bool(binary))
        write(f"meshio {kind}.vtk", PHYSICAL, "vtk", binary=bool(binary))
    write("meshio plain.vtu", PHYSICAL, "vtu", compression=None)
    write("meshio.inp", NAMED)
    for kind in ["free", "fixed-small", "fixed-large"]:
        write(f"meshio {kind}.bdf", PROPERTIES, "nastran", point_format=kind,
              cell_format="fixed-small")  # fmt: skip
    if not quads:
        write("meshio.stl", None)
        write("meshio binary.stl", None, "stl", binary=True)
    return files


def factors(place, file, names):
    """The matrix with its rows sorted by name and place, their areas and centroids, and the sums by name."""
    out = os.path.join(place, "f.npz")
    azulejo("form-factors", os.path.join(place, file), "-o", out, "--patch-size", "0", "--engine", "analytic",
            "--tolerance", "1e-11", "--closure=never")  # fmt: skip
    z = np.load(out)
    n = int(z["shape"][0])
    matrix = np.zeros((n, n))
    matrix[np.repeat(np.arange(n), np.diff(z["indptr"])), z["indices"]] = z["data"]
    found = [str(z["object_names"][k]) for k in z["patch_face"][:, 0]]
    if names is None:
        # Whatever is above the floor is the lid.
        found = ["lid" if z > 0 else "floor" for z in z["centroids"][:, 2]]
    else:
        back = {theirs: ours for ours, theirs in names.items()}
        if set(found) != set(back):
            raise SystemExit(f"WRONG: objects of {file} are {sorted(set(found))}, expected {sorted(back)}")
        found = [back[name] for name in found]
    places = np.round(z["centroids"], 9)
    order = sorted(range(n), key=lambda i: (found[i], *places[i]))
    return [found[i] for i in order], places[order], z["areas"][order], matrix[np.ix_(order, order)]


def compare(quads):
    print("quadrilaterals" if quads else "triangles")
    place = folder()
    files = write_by_gmsh(place, quads)
    if meshio is None:
        print("skipped: meshio is missing (pip install meshio)")
    else:
        files.update(write_by_meshio(place, quads))
    first = None
    for file, names in files.items():
        got = factors(place, file, names)
        first = first or got
        count = (1 if quads else 2) * (NODES - 1) ** 2 * len(PLATES)
        check(f"rows of {file}", len(got[0]), count, 0)
        same = got[0] == first[0] and np.array_equal(got[1], first[1])
        check(f"names and places of {file}", float(same), 1.0, 0)
        check(f"areas of {file}, largest difference", np.abs(got[2] - first[2]).max(), 0.0, 1e-15)
        check(f"factors of {file}, largest difference", np.abs(got[3] - first[3]).max(), 0.0, 1e-12)


compare(quads=False)
compare(quads=True)
