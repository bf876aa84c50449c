"""uDALES's files of a court with houses, read as its Fortran reads them: the sparse and the full matrix agree, and its
own checks hold. So does the strict check of its Python tools (validate_view_factors), of the court and of a wall on open
ground, if UDALES is the folder of its repository. Needs NumPy and SciPy (netCDF), and trimesh for the latter; uDALES itself
is not run."""

import os
import sys

from common import azulejo, check, folder, skip
from udales_models import BLOCK, street

try:
    import numpy as np
    from scipy.io import netcdf_file
except ImportError:
    skip("NumPy or SciPy is missing (pip install numpy scipy)")

NUMBER = "042"


def normal(triangle):
    a, b, c = map(np.array, triangle)
    return np.cross(b - a, c - a) / 2


def write_stl(path, facets):
    with open(path, "w") as out:
        out.write("solid street\n")
        for facet in facets:
            out.write("facet normal {} {} {}\nouter loop\n".format(*normal(facet)))
            out.writelines("vertex {} {} {}\n".format(*p) for p in facet)
            out.write("endloop\nendfacet\n")
        out.write("endsolid street\n")


def read(place, n):
    """By list-directed reading after each header, and vf(j, i) of netCDF, whose first index is the last in C."""
    name = lambda file: os.path.join(place, f"{file}.inp.{NUMBER}")
    sparse = np.zeros((n, n))
    for line in open(name("vfsparse")):
        i, j, f = line.split()
        sparse[int(i) - 1, int(j) - 1] = float(f)
    lines = {file: open(name(file)).read().splitlines() for file in ["svf", "facetarea", "facets"]}
    for file, found in lines.items():
        check(f"{file}: header and {n} lines", len(found), n + 1, 0)
        check(f"{file}: header begins with #", float(found[0].startswith("#")), 1.0, 0)
    svf, areas = (np.array(lines[file][1:], float) for file in ["svf", "facetarea"])
    facets = np.array([line.split() for line in lines["facets"][1:]], float)
    with netcdf_file(name("vf.nc"), mmap=False) as file:
        variable = file.variables["view factor"]
        check("vf.nc: bytes of a number", variable.data.dtype.itemsize, 4, 0)
        full = variable[:].T.astype(float)
    return sparse, svf, areas, facets, full


def examine(engine, *options):
    print(engine)
    place, facets = folder(), street()
    n = len(facets)
    model = os.path.join(place, "street.stl")
    write_stl(model, facets)
    azulejo("form-factors", model, "-o", os.path.join(place, f"vfsparse.inp.{NUMBER}"), "--patch-size", "0",
            "--engine", engine, *options)  # fmt: skip
    sparse, svf, areas, table, full = read(place, n)
    vectors = np.array([normal(f) for f in facets])
    true = np.linalg.norm(vectors, axis=1)
    check("areas, largest relative error", np.abs(areas / true - 1).max(), 0.0, 1e-6)
    check("normals, largest error", np.abs(table[:, 1:] - vectors / true[:, None]).max(), 0.0, 5.1e-5)
    check("types of walls are whole", float((table[:, 0] == np.round(table[:, 0])).all()), 1.0, 0)
    check("vfsparse and vf.nc, largest difference", np.abs(sparse - full).max(), 0.0, 5e-7)
    check("least factor of vfsparse is 5e-7 or more", float(sparse[sparse != 0].min() >= 5e-7), 1.0, 0)
    for name, f in [("vfsparse", sparse), ("vf.nc", full)]:
        check(f"{name}: 0 to 1", float(f.min() >= 0 and f.max() <= 1), 1.0, 0)
        check(f"{name}: row sums with the sky, largest error", np.abs(f.sum(1) + svf - 1).max(), 0.0, 1e-3)
        exchange = areas[:, None] * f
        check(f"{name}: reciprocity, largest error in m²", np.abs(exchange - exchange.T).max(), 0.0, 1e-2)
    roofs = [k for k, f in enumerate(facets) if all(p[2] == 15.0 for p in f)]
    check("sky of the highest roofs", svf[roofs].min(), 1.0, 1e-6)
    return full


def strict(what, facets, *options):
    """The check of uDALES' own tools, which read the files as they are."""
    place = folder()
    model = os.path.join(place, "model.stl")
    write_stl(model, facets)
    azulejo("form-factors", model, "-o", os.path.join(place, f"vfsparse.inp.{NUMBER}"), "--patch-size", "0", *options)
    sparse, svf, areas, _, _ = read(place, len(facets))
    tools.validate_view_factors(csr_matrix(sparse), svf, areas=areas)
    print(f"ok: {what}: the strict check of uDALES holds, its sky is {svf.min():.4f} to {svf.max():.4f}")


exact = examine("analytic", "--tolerance", "1e-9")
# The sky of a row is estimated by its rays alone, its factors by those of both ends: sums err by noise.
traced = examine("rays", "--rays", "262144")
check("traced and exact, largest difference", np.abs(traced - exact).max(), 0.0, 1e-2)

if "UDALES" not in os.environ:
    print("skipped: UDALES is not the folder of a checkout of uDALES")
    sys.exit(0)
sys.path += [os.path.join(os.environ["UDALES"], "tools", "python", *more) for more in ([], ["udgeom"])]
import view3d as tools  # noqa: E402
from scipy.sparse import csr_matrix  # noqa: E402

for options in [(), ("--rays", "4096"), ("--rays", "1024", "--periodic", "x,y")]:
    strict(f"a wall on open ground, {options}", BLOCK, *options)
    strict(f"a court with houses, {options}", street(), *options)
