"""Meshes of other packages, and arrays, as vertices, corners and where faces start among them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._checks import numbers
from ._pyazulejo import AzulejoError

_MOST = 2**32 - 1

# Cells of VTK by their numbers: how many of their points are corners of a polygon, in their order.
_VTK_CORNERS = {5: 3, 9: 4, 22: 3, 23: 4, 28: 4, 34: 3}
_VTK_POLYGON = 7
_VTK_PIXEL = 8
# Points and lines have no area.
_VTK_NO_AREA = {0, 1, 2, 3, 4, 21, 35, 68}

_MESHIO_CORNERS = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}
_MESHIO_NO_AREA = ("vertex", "line")


class FaceArrays(NamedTuple):
    """Polygons over vertices, checked."""

    vertices: npt.NDArray[np.float64]
    starts: npt.NDArray[np.uint32]
    corners: npt.NDArray[np.uint32]


def is_mesh(value: object) -> bool:
    """Whether this is one mesh, and not a list or mapping of them."""
    return bool(_packages(value) & {"meshio", "trimesh", "pyvista"})


def face_arrays(name: str, mesh: object) -> FaceArrays:
    """The polygons of any mesh."""
    packages = _packages(mesh)
    if "meshio" in packages:
        return _of_meshio(name, mesh)
    if "pyvista" in packages:
        return _of_pyvista(name, mesh)
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return _of_arrays(name, mesh.vertices, mesh.faces)
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return _of_arrays(name, mesh[0], mesh[1])
    kind = type(mesh).__name__
    raise TypeError(
        f'mesh "{name}" is a {kind}, expected (vertices, faces), a trimesh.Trimesh, '
        "a pyvista.PolyData or UnstructuredGrid, or a meshio.Mesh"
    )


def parts(mesh: Any) -> Iterator[tuple[str, object]]:
    """The named parts of one mesh: physical groups of Gmsh if it has any."""
    groups = getattr(mesh, "cell_data", {}) if "meshio" in _packages(mesh) else {}
    if "gmsh:physical" not in groups:
        yield "mesh", mesh
        return
    names = {int(number): name for name, (number, _) in mesh.field_data.items()}
    cells: dict[int, list[npt.NDArray[Any]]] = {}
    for block, physical in zip(mesh.cells, groups["gmsh:physical"], strict=True):
        if block.type.startswith(_MESHIO_NO_AREA):
            continue
        count = _meshio_corners("mesh", block.type, block.data)
        for number in np.unique(physical):
            chosen = block.data[np.asarray(physical) == number]
            cells.setdefault(int(number), []).append(chosen[:, :count])
    for number, blocks in cells.items():
        faces = list(chain.from_iterable(b.tolist() for b in blocks))
        yield names.get(number, f"physical {number}"), (mesh.points, faces)


def _packages(value: object) -> set[str]:
    return {c.__module__.split(".")[0] for c in type(value).__mro__}


def _of_arrays(name: str, vertices: npt.ArrayLike, faces: Any) -> FaceArrays:
    starts, corners = _polygons(name, faces)
    return _checked(name, vertices, starts, corners)


def _polygons(name: str, faces: Any) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Where faces start, and their corners, of an array (n, k) or of lists of any length."""
    try:
        array = np.asarray(faces)
    except ValueError:
        array = np.empty(0, dtype=object)
    if array.dtype == object:
        return _ragged(name, list(faces))
    if array.size == 0:
        raise AzulejoError(f'mesh "{name}" has no faces')
    if array.ndim != 2 or array.shape[1] < 3:
        raise AzulejoError(
            f'mesh "{name}": faces have the shape {array.shape}, expected (n, 3), (n, 4) or a list '
            "of polygons"
        )
    count, width = array.shape
    return np.arange(count + 1, dtype=np.int64) * width, array.reshape(-1)


def _ragged(name: str, faces: Sequence[Any]) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    if not faces:
        raise AzulejoError(f'mesh "{name}" has no faces')
    arrays = [np.asarray(face) for face in faces]
    for k, face in enumerate(arrays):
        if face.ndim != 1 or face.size < 3:
            raise AzulejoError(
                f'mesh "{name}": face {k} is {faces[k]!r}, expected 3 indices or more'
            )
    lengths = [0, *(face.size for face in arrays)]
    return np.cumsum(lengths, dtype=np.int64), np.concatenate(arrays)


def _checked(
    name: str, vertices: npt.ArrayLike, starts: npt.NDArray[Any], corners: npt.NDArray[Any]
) -> FaceArrays:
    """What the compiled half may rely on."""
    points = numbers(f'mesh "{name}": vertices', vertices)
    if points.ndim != 2 or points.shape[1] != 3:
        raise AzulejoError(
            f'mesh "{name}": vertices have the shape {points.shape}, expected (n, 3)'
        )
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise AzulejoError(
            f'mesh "{name}": vertex {bad[0]} is not finite: {points[bad[0]].tolist()}'
        )
    if len(starts) < 2:
        raise AzulejoError(f'mesh "{name}" has no faces')
    if corners.dtype.kind not in "iu":
        kind = corners.dtype
        raise AzulejoError(f'mesh "{name}": faces are of type {kind}, expected whole numbers')
    if max(len(points), len(corners)) > _MOST:
        raise AzulejoError(f'mesh "{name}" has more than {_MOST} vertices or corners')
    wrong = np.flatnonzero((corners < 0) | (corners >= len(points)))
    if wrong.size:
        face = int(np.searchsorted(starts, wrong[0], side="right")) - 1
        index = int(corners[wrong[0]])
        there = f"there are {len(points)} vertices" if index >= 0 else "indices start at 0"
        raise AzulejoError(f'mesh "{name}": face {face} has the index {index}, but {there}')
    return FaceArrays(
        points,
        np.ascontiguousarray(starts, dtype=np.uint32),
        np.ascontiguousarray(corners, dtype=np.uint32),
    )


def _of_meshio(name: str, mesh: Any) -> FaceArrays:
    lengths: list[npt.NDArray[Any]] = [np.zeros(1, dtype=np.int64)]
    corners: list[npt.NDArray[Any]] = [np.empty(0, dtype=np.int64)]
    for block in mesh.cells:
        if block.type.startswith(_MESHIO_NO_AREA):
            continue
        count = _meshio_corners(name, block.type, block.data)
        chosen = np.asarray(block.data)[:, :count]
        lengths.append(np.full(len(chosen), count, dtype=np.int64))
        corners.append(chosen.reshape(-1))
    return _checked(name, mesh.points, np.cumsum(np.concatenate(lengths)), np.concatenate(corners))


def _meshio_corners(name: str, kind: str, data: Any) -> int:
    if kind == "polygon":
        return int(np.asarray(data).shape[1])
    if kind not in _MESHIO_CORNERS:
        raise AzulejoError(
            f'mesh "{name}" has cells of type {kind}, expected triangles, quadrilaterals or polygons: '
            "pass the surface, for instance pyvista.from_meshio(mesh).extract_surface()"
        )
    return _MESHIO_CORNERS[kind]


def _of_pyvista(name: str, mesh: Any) -> FaceArrays:
    import pyvista

    if isinstance(mesh, pyvista.PolyData):
        if mesh.n_strips:
            mesh = mesh.triangulate()
        polygons = mesh.GetPolys()
        starts = pyvista.convert_array(polygons.GetOffsetsArray())
        corners = pyvista.convert_array(polygons.GetConnectivityArray())
        return _checked(name, mesh.points, np.asarray(starts), np.asarray(corners))
    if not isinstance(mesh, pyvista.UnstructuredGrid):
        mesh = mesh.cast_to_unstructured_grid()
    kinds = set(np.unique(mesh.celltypes).tolist())
    flat = set(_VTK_CORNERS) | {_VTK_POLYGON, _VTK_PIXEL} | _VTK_NO_AREA
    if not kinds <= flat:
        # The hull of solid cells, whose faces are oriented outwards.
        hull = (
            mesh.extract_surface(algorithm=None)
            if _names_algorithm(mesh)
            else mesh.extract_surface()
        )
        return _of_pyvista(name, hull)
    faces = []
    # Older versions of pyvista have the second name.
    offsets = mesh.cell_offsets if hasattr(mesh, "cell_offsets") else mesh.offset
    connectivity = mesh.cell_connectivity
    for k, kind in enumerate(mesh.celltypes.tolist()):
        if kind in _VTK_NO_AREA:
            continue
        cell = connectivity[offsets[k] : offsets[k + 1]]
        if kind == _VTK_PIXEL:
            cell = cell[[0, 1, 3, 2]]
        faces.append(cell[: _VTK_CORNERS.get(kind)])
    return _of_arrays(name, mesh.points, faces)


def _names_algorithm(mesh: Any) -> bool:
    """Whether this version of pyvista wants to be told which algorithm extracts surfaces."""
    import inspect

    return "algorithm" in inspect.signature(mesh.extract_surface).parameters
