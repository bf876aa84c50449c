"""VTK, pyvista and meshio read our .vtu, and scipy our .mtx and vf.nc.inp. Needs the Python packages
numpy, vtk, pyvista, meshio and scipy: those that are missing are left out, saying so."""

import importlib
import os

from common import CUBE, azulejo, check, folder, read_mtx, skip, write_obj


def module(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"skipped: {name} is missing (pip install {name.split('.')[0]})")
        return None


if module("numpy") is None:
    skip("nothing can be read without numpy")
import numpy as np

# Squares, and triangles in place of one.
OBJECTS = {name: [square] for name, square in CUBE.items()}
OBJECTS["floor"] = [[(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 0, 0), (1, 1, 0), (0, 1, 0)]]

place = folder()
model = os.path.join(place, "cube.obj")
write_obj(model, OBJECTS)
vtu, mtx = os.path.join(place, "cube.vtu"), os.path.join(place, "cube.mtx")
experiment = os.path.join(place, "vfsparse.inp.007")
for path in [vtu, mtx, experiment]:
    azulejo("form-factors", model, "-o", path, "--patch-size", "0", "--engine", "analytic",
            *(["--vtu-rows", "floor/0"] if path == vtu else []))  # fmt: skip
factors = np.array(read_mtx(mtx))
n = len(factors)


def examine(reader, rows, shown, sums):
    same = np.array_equal(shown, factors[0][rows]) and np.allclose(sums, factors.sum(1)[rows], atol=1e-15)
    check(f"rows as {reader} reads them", float(same), 1.0, 0)


vtk = module("vtk")
if vtk is not None:
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(vtu)
    reader.Update()
    grid = reader.GetOutput()
    check("cells of VTK", grid.GetNumberOfCells(), n, 0)
    arrays = {k: vtk_to_numpy(grid.GetCellData().GetArray(k)) for k in ["row", "F_from_floor/0", "row_sum"]}
    examine("VTK", *arrays.values())
pyvista = module("pyvista")
if pyvista is not None:
    grid = pyvista.read(vtu)
    examine("pyvista", *(grid.cell_data[k] for k in ["row", "F_from_floor/0", "row_sum"]))
    check("area by pyvista", grid.compute_cell_sizes()["Area"].sum(), 6.0, 1e-12)
meshio = module("meshio")
if meshio is not None:
    mesh = meshio.read(vtu)
    kinds = sorted({block.type for block in mesh.cells})
    check(f"kinds of cells of meshio {kinds}", len(kinds), 2, 0)
    data = [np.concatenate(mesh.cell_data[k]).ravel() for k in ["row", "F_from_floor/0", "row_sum"]]
    examine("meshio", data[0].astype(int), *data[1:])
scipy_io = module("scipy.io")
if scipy_io is not None:
    read = scipy_io.mmread(mtx).toarray()
    check("Matrix Market as scipy reads it", float(np.array_equal(read, factors)), 1.0, 0)
    with scipy_io.netcdf_file(os.path.join(place, "vf.nc.inp.007"), mmap=False) as file:
        full = file.variables["view factor"][:].T.copy()
    check("vf.nc against F", np.abs(full - factors).max(), 0.0, 5e-8)
    sparse = np.zeros((n, n))
    for line in open(experiment):
        i, j, f = line.split()
        sparse[int(i) - 1, int(j) - 1] = float(f)
    check("vfsparse against vf.nc", np.abs(sparse - full).max(), 0.0, 5e-7)
    svf = np.loadtxt(os.path.join(place, "svf.inp.007"))
    check("row sums of uDALES with the sky", np.abs(full.sum(1) + svf - 1).max(), 0.0, 1e-3)
