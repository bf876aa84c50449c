"""Scenes."""

from __future__ import annotations

import warnings as _warnings
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike, fspath
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._checks import Colour, colour, listed, positive, vector
from ._checks import threads as _threads
from ._materials import Material, Materials, material_table, of_meshes
from ._meshes import face_arrays, is_mesh, parts
from ._page import notebook_html, table
from ._progress import Progress, watching
from ._pyazulejo import AzulejoError, NativeMaterials, NativeScene, load_scene

_UNITS = {
    "um": 1e-6,
    "µm": 1e-6,
    "mm": 1e-3,
    "cm": 1e-2,
    "dm": 1e-1,
    "m": 1.0,
    "km": 1e3,
    "in": 0.0254,
    "ft": 0.3048,
    "yd": 0.9144,
    "mi": 1609.344,
    "nmi": 1852.0,
}


class MeshArrays(NamedTuple):
    """The mesh of an object: face k has the corners
    ``corners[corner_offsets[k]:corner_offsets[k + 1]]``, indices of vertices."""

    vertices: npt.NDArray[np.float64]
    """(n, 3), scene units."""
    corners: npt.NDArray[np.uint32]
    """(c,), counter-clockwise from the front."""
    corner_offsets: npt.NDArray[np.uint32]
    """(m + 1,)"""
    irradiance: npt.NDArray[np.float64] | None
    """(n, 3), W/m², of a solved scene."""
    std_error: npt.NDArray[np.float64] | None
    """(n, 3), W/m², of a solved scene."""


class Scene:
    """Named meshes with materials.

    Parameters
    ----------
    meshes : mapping of str to mesh, or iterable of (str, mesh), or one mesh
        Each mesh is ``(vertices, faces)`` with vertices (n, 3) and faces (m, 3), (m, 4) or a list of
        polygons, counter-clockwise from the front; or a ``trimesh.Trimesh``, a ``pyvista.PolyData``
        or ``UnstructuredGrid`` (of solid cells, the hull), or a ``meshio.Mesh``. One ``meshio.Mesh``
        alone is split by the physical groups of Gmsh. Arrays are copied.
    materials : Material, or mapping of str to Material, or path, optional
        One for all, or by names of meshes; names may have ``*`` and ``?``, and the first that fits
        counts, ``*`` alone last. Every mesh needs one. With emissivities (`eps`), also as the file of a
        table, the factors of the scene have their mirrors, and :func:`exchange` and :func:`radiosity`
        take them where nothing else is given.
    sky : float or array_like (3,), optional
        Radiance of a uniform sky, W/(sr·m²).
    sun : (array_like (3,), float or array_like (3,)), optional
        The direction toward the sun, of any length, and the irradiance of what faces it, W/m²; a disc of
        0.533°. Sun and sky are for light, and for heat what surfaces absorb by their `alpha`.
    up : {"z", "y"}, optional
        The axis that points away from the ground: what leaves upwards is `sky`, the rest `ground`.
    unit : str or float, optional
        Length of a unit: "mm", "m", …, or in metres.

    Raises
    ------
    AzulejoError
        What is wrong, and with which mesh and face.

    Notes
    -----
    Surfaces emit and receive on their fronts, and block light from both sides.
    """

    _native: NativeScene
    _report: Mapping[str, Any] | None
    _table: NativeMaterials | None

    def __init__(
        self,
        meshes: Mapping[str, Any] | Iterable[tuple[str, Any]] | Any,
        materials: Material | Mapping[str, Material] | str | PathLike[str] | None = None,
        *,
        sky: Colour | None = None,
        sun: tuple[npt.ArrayLike, Colour] | None = None,
        up: str = "z",
        unit: str | float | None = None,
    ) -> None:
        named = list(_named(meshes))
        path = materials if isinstance(materials, (str, PathLike)) else None
        of_names = None if isinstance(materials, (str, PathLike)) else materials
        kinds, numbers = of_meshes(of_names, [name for name, _ in named])
        arrays = [
            (name, *face_arrays(name, mesh), material)
            for (name, mesh), material in zip(named, numbers, strict=True)
        ]
        self._native = NativeScene.from_meshes(
            arrays,
            [material._numbers(name) for name, material in kinds],
            None if sky is None else colour("sky", sky),
            _sun(sun),
            up,
            _unit(unit),
        )
        self._report = None
        self._table = None
        if path is not None:
            self._table = material_table(path)
        elif of_names is not None and any(m.eps is not None for _, m in kinds):
            self._table = material_table(of_names)
        if self._table is not None:
            self._native = self._table.paint(self._native)

    @classmethod
    def _of(
        cls,
        native: NativeScene,
        report: Mapping[str, Any] | None = None,
        table: NativeMaterials | None = None,
    ) -> Scene:
        scene = cls.__new__(cls)
        scene._native, scene._report, scene._table = native, report, table
        return scene

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the objects; a file may have the same name twice."""
        return tuple(self._native.names)

    @property
    def areas(self) -> npt.NDArray[np.float64]:
        """Area of each object (n,), square scene units."""
        return _read_only(self._native.areas)

    @property
    def faces(self) -> npt.NDArray[np.int64]:
        """Number of faces of each object (n,); 0 for exact shapes as spheres, which have none."""
        return _read_only(self._native.faces)

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials of the scene; pictures and glass are left out."""
        return tuple(
            Material(
                None if model else tuple(diffuse),
                0.0 if model else tuple(mirror),
                tuple(emission),
                emits_back,
                model,
                name,
            )
            for name, diffuse, mirror, emission, emits_back, model in self._native.materials
        )

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """The low and the high corner of the box around all (2, 3), scene units."""
        return _read_only(self._native.bounds)

    @property
    def up(self) -> str:
        """The axis that points away from the ground: "y" or "z"."""
        return self._native.up

    @property
    def unit(self) -> float | None:
        """Metres of a unit of length, if they are known."""
        return self._native.unit

    @property
    def warnings(self) -> tuple[str, ...]:
        """What was skipped or repaired when the scene was loaded."""
        return tuple(self._native.warnings)

    @property
    def is_solved(self) -> bool:
        """Whether its surfaces carry light: see :func:`solve_light`."""
        return self._native.is_solved

    @property
    def report(self) -> Mapping[str, Any] | None:
        """What :func:`solve_light` did: its method, error and energy balance."""
        return self._report

    def mesh(self, name: str | int) -> MeshArrays:
        """The mesh of an object, by its name or its number, with the light that it carries."""
        vertices, starts, corners, light, error = self._native.mesh(self._number(name))
        return MeshArrays(vertices, corners, starts, light, error)

    def _number(self, name: str | int) -> int:
        names = self.names
        if isinstance(name, str):
            found = [k for k, n in enumerate(names) if n == name]
            if len(found) == 1:
                return found[0]
            what = f"{len(found)} objects are" if found else "no object is"
            raise AzulejoError(f'{what} named "{name}"; there are {listed(names)}')
        if not 0 <= name < len(names):
            raise AzulejoError(f"there is no object {name}: the scene has {len(names)}")
        return int(name)

    def _page(self, limit: int | None) -> str:
        error = self._report["error"] if self._report else None
        known = "" if error is None else f"It is known to {100 * error:.4g}% of its mean."
        return self._native.html((repr(self), known), limit)

    def _summary(self) -> str:
        rows = ((n, [f, a]) for n, f, a in zip(self.names, self.faces, self.areas, strict=True))
        return table(["object", "faces", "area"], rows, len(self.names), "objects")

    def _repr_html_(self) -> str:
        return notebook_html(self)

    def __repr__(self) -> str:
        lit = ", solved" if self.is_solved else ""
        return f"Scene({len(self.names)} objects, {int(self.faces.sum())} faces{lit})"


def load(
    path: str | PathLike[str],
    *,
    unit: str | float | None = None,
    up: str | None = None,
    lod: str | float = "finest",
    allow: Sequence[str | PathLike[str]] = (),
    keep_light: bool = True,
    materials: Materials | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Scene:
    """Read a model of any format that azulejo reads: OBJ, glTF, PLY, STL, 3DS, GRF, View3D, ….

    Parameters
    ----------
    path : str or path
        The file. Files that it refers to are searched in its folder and below.
    unit : str or float, optional
        Unit of length of the scene, to which the model is scaled: "mm", "m", …, or in metres. Taken as
        the model's own where its format does not say one.
    up : {"y", "z"}, optional
        Up axis of the scene, to which the model is turned.
    lod : {"finest", "coarsest", "all"} or float, optional
        Level of detail, of models that have several; a number is a viewing distance.
    allow : sequence of paths, optional
        Other folders in which the model may refer to files.
    keep_light : bool, optional
        False removes lightmaps, so that light can be computed anew.
    materials : path, Material, float, or mapping of str to Material, optional
        Emissivities and mirror reflectances in place of the materials of the model, by names of objects
        or materials, as in ``form-factors --materials``: the factors of the scene have their mirrors, and
        :func:`exchange` and :func:`radiosity` take them where nothing else is given.
    threads : int, optional
        Number of threads, by default as many as there are processors.
    progress : callable or bool, optional
        Called as ``progress(done, what)``; True shows a bar of tqdm.

    Returns
    -------
    Scene
        What was skipped or repaired is in :attr:`Scene.warnings`, and a `UserWarning` says so.

    Raises
    ------
    OSError
        The file could not be read.
    AzulejoError
        It is not a model, or damaged; the message says where.
    """
    table = None if materials is None else material_table(materials)
    with watching(progress) as callback:
        native = load_scene(
            fspath(path),
            _unit(unit),
            up,
            lod,
            [fspath(folder) for folder in allow],
            keep_light,
            _threads(threads),
            callback,
        )
    scene = Scene._of(native if table is None else table.paint(native), table=table)
    if scene.warnings:
        more = f" (and {len(scene.warnings) - 1} more)" if len(scene.warnings) > 1 else ""
        _warnings.warn(f"{scene.warnings[0]}{more}", UserWarning, stacklevel=2)
    return scene


def _named(meshes: Any) -> Iterable[tuple[str, Any]]:
    if is_mesh(meshes):
        pairs = list(parts(meshes))
    elif isinstance(meshes, Mapping):
        pairs = list(meshes.items())
    else:
        pairs = [_pair(k, item) for k, item in enumerate(meshes)]
    seen = set()
    for name, _ in pairs:
        if not isinstance(name, str):
            raise TypeError(f"a mesh is named {name!r}, expected a text")
        if name in seen:
            raise AzulejoError(f'two meshes are named "{name}"')
        seen.add(name)
    if not pairs:
        raise AzulejoError("there are no meshes")
    return pairs


def _pair(k: int, item: Any) -> tuple[str, Any]:
    if isinstance(item, (tuple, list)) and len(item) == 2 and isinstance(item[0], str):
        return item[0], item[1]
    raise TypeError(f"item {k} is a {type(item).__name__}, expected a pair of a name and a mesh")


def _sun(sun: Any) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None:
    if sun is None:
        return None
    try:
        toward, irradiance = sun
    except (TypeError, ValueError):
        raise TypeError(f"sun is {sun!r}, expected a direction and an irradiance") from None
    direction = vector("direction of the sun", toward)
    if direction is None:
        raise TypeError("direction of the sun is None, expected three numbers")
    return direction, colour("irradiance of the sun", irradiance)


def _unit(unit: str | float | None) -> float | None:
    if isinstance(unit, str):
        if unit not in _UNITS:
            raise AzulejoError(f'unknown unit "{unit}" (known: {", ".join(_UNITS)}, or metres)')
        return _UNITS[unit]
    return positive("unit", unit)


def _read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array.flags.writeable = False
    return array
