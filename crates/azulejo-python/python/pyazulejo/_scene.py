"""Scenes and materials."""

from __future__ import annotations

import warnings as _warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from os import PathLike, fspath
from typing import Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from ._checks import Colour, colour, listed, positive, real, vector
from ._checks import threads as _threads
from ._meshes import face_arrays, is_mesh, parts
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


Spectrum = Union[float, Mapping[Any, float]]
"""A number for all wavelengths, or numbers by bands of micrometres: ``{(0, 4): 0.2, (4, inf): 0.8}``,
or ``{"0-4": 0.2, "4-inf": 0.8}``."""


@dataclass(frozen=True)
class Material:
    """What a surface reflects and emits: for light, or with `eps` for heat.

    For light, numbers may be one, or red, green and blue; what is not reflected is absorbed. For heat,
    what is neither absorbed nor mirrored is reflected diffusely, ρ_d = 1 − ε − ρ_s.

    Parameters
    ----------
    diffuse : float or array_like (3,), optional
        Diffuse reflectance, 0 to 1. By default 0.5, or 0 where there is a `mirror` or a `brdf`.
    mirror : float or array_like (3,), optional
        Reflectance of the perfect mirror, 0 to 1; ``diffuse + mirror`` is at most 1.
    emission : float or array_like (3,), optional
        Emitted radiance of the front, W/(sr·m²).
    emits_back : bool, optional
        Whether the back emits the same.
    brdf : str, optional
        A reflection model as for :func:`brdf`, in place of `diffuse` and `mirror`.
    name : str, optional
        Its name, for rows by material.
    eps : float or mapping of bands to floats, optional
        Emissivity, which is absorptance, 0 to 1; in place of all above. Bands are pairs of wavelengths
        in µm, ``{(0, 4): 0.2, (4, inf): 0.8}``, and follow one another from 0 to infinity.
    rho_s : float or mapping of bands to floats, optional
        Mirror reflectance, 0 to 1 − ε, beside `eps`; also for the band ``"solar"``.
    alpha : float, optional
        Absorptance of sunlight, 0 to 1, beside `eps`.

    Examples
    --------
    >>> import pyazulejo as az
    >>> paint, foil = az.Material(diffuse=0.7), az.Material(eps=0.05, rho_s=0.9, alpha=0.1)
    """

    diffuse: Colour | None = None
    mirror: Colour = 0.0
    emission: Colour = 0.0
    emits_back: bool = False
    brdf: str | None = None
    name: str | None = None
    eps: Spectrum | None = None
    rho_s: Spectrum | None = None
    alpha: float | None = None

    def _numbers(self, name: str) -> tuple[Any, ...]:
        name = self.name if self.name is not None else name
        mirror = colour(f'material "{name}": mirror', self.mirror)
        emission = colour(f'material "{name}": emission', self.emission)
        if self.eps is None and (self.rho_s is not None or self.alpha is not None):
            raise AzulejoError(
                f'material "{name}": rho_s and alpha stand beside eps, which is missing'
            )
        of_light = (self.diffuse is not None, any(mirror), any(emission), self.brdf is not None)
        if self.eps is not None and any(of_light):
            raise AzulejoError(
                f'material "{name}": eps takes the place of diffuse, mirror, emission and brdf'
            )
        if self.brdf is not None and (self.diffuse is not None or any(mirror)):
            raise AzulejoError(f'material "{name}": a brdf takes the place of diffuse and mirror')
        plain = 0.0 if self.brdf is not None or any(mirror) else 0.5
        diffuse = plain if self.diffuse is None else self.diffuse
        return (
            name,
            colour(f'material "{name}": diffuse', diffuse),
            mirror,
            emission,
            bool(self.emits_back),
            self.brdf,
        )

    def _record(self, name: str) -> list[tuple[str, float]]:
        """What a table of emissivities has in its columns."""
        if self.eps is None:
            raise AzulejoError(f'material "{name}" has no eps, the emissivity')
        fields = _spectrum(name, "eps", self.eps)
        fields += _spectrum(name, "rho_s", self.rho_s)
        if self.alpha is not None:
            fields.append(("alpha", real(f'material "{name}": alpha', self.alpha)))
        return fields


def _spectrum(name: str, column: str, value: Spectrum | None) -> list[tuple[str, float]]:
    if value is None:
        return []
    if not isinstance(value, Mapping):
        return [(column, real(f'material "{name}": {column}', value))]

    def band(key: Any) -> str:
        if isinstance(key, str):
            return key
        try:
            low, high = key
            return f"{float(low)!r}-{float(high)!r}"
        except (TypeError, ValueError):
            raise TypeError(
                f'material "{name}": a band of {column} is {key!r}, expected two wavelengths in µm'
            ) from None

    return [
        (f"{column}@{band(key)}", real(f'material "{name}": {column}', number))
        for key, number in value.items()
    ]


MaterialLike = Union[Material, float, Mapping[str, Any]]
"""A :class:`Material`, an emissivity, or the arguments of a Material as a mapping."""

Materials = Union[str, "PathLike[str]", Material, float, Mapping[str, MaterialLike]]
"""A table of emissivities as a file; one material for all; or materials by the names of objects,
materials, faces (``"floor/3"``) or rows, in which ``*`` and ``?`` stand for any letters."""


def material_table(materials: Materials) -> NativeMaterials:
    """Emissivities by name, as a table."""
    if isinstance(materials, (str, PathLike)):
        return NativeMaterials.read(fspath(materials))
    if not isinstance(materials, Mapping):
        materials = {"*": materials}
    if not materials:
        raise AzulejoError("there are no materials")
    return NativeMaterials.from_numbers(
        [(name, _material(name, value)._record(name)) for name, value in materials.items()]
    )


def _material(name: Any, value: MaterialLike) -> Material:
    if not isinstance(name, str):
        raise TypeError(f"a material is for {name!r}, expected a name")
    if isinstance(value, Material):
        return value
    if isinstance(value, Mapping):
        try:
            return Material(**value)
        except TypeError as error:
            raise TypeError(f'materials["{name}"]: {error}') from None
    if isinstance(value, (bool, str)) or not hasattr(value, "__float__"):
        kind = type(value).__name__
        raise TypeError(f'materials["{name}"] is a {kind}, expected a Material, or an emissivity')
    return Material(eps=value)


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
        kinds, of_meshes = _materials(of_names, [name for name, _ in named])
        arrays = [
            (name, *face_arrays(name, mesh), material)
            for (name, mesh), material in zip(named, of_meshes, strict=True)
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


def _materials(
    materials: Material | Mapping[str, Material] | None, names: list[str]
) -> tuple[list[tuple[str, Material]], list[int]]:
    """All materials with a name each, and the number of that of each mesh."""
    if materials is None:
        return [("default", Material())], [0] * len(names)
    if isinstance(materials, Material):
        return [("material", materials)], [0] * len(names)
    kinds = list(materials.items())
    for pattern, material in kinds:
        if not isinstance(material, Material):
            kind = type(material).__name__
            raise TypeError(f'materials["{pattern}"] is a {kind}, expected a Material')
        if pattern != "*" and not any(fnmatchcase(name, pattern) for name in names):
            raise AzulejoError(f'no mesh is named "{pattern}"; there are {listed(names)}')

    def first(name: str) -> int | None:
        # A name itself counts before patterns, whatever their order, and * alone last.
        fits = [k for k, (pattern, _) in enumerate(kinds) if fnmatchcase(name, pattern)]
        exact = [k for k in fits if kinds[k][0] == name]
        narrow = [k for k in fits if kinds[k][0] != "*"]
        return next(iter(exact or narrow or fits), None)

    chosen = [first(name) for name in names]
    missing = [name for name, k in zip(names, chosen, strict=True) if k is None]
    if missing:
        raise AzulejoError(f'no material for {listed(missing)}; "*" would be that of all others')
    return kinds, [k for k in chosen if k is not None]


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
