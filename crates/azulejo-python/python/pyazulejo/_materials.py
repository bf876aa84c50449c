"""Materials."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from os import PathLike, fspath
from typing import Any, Union

from ._checks import Colour, colour, listed, real
from ._pyazulejo import AzulejoError, NativeMaterials

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


def of_meshes(
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
