"""Lightmaps: light in texels."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._checks import optional_whole, positive, whole
from ._checks import threads as _threads
from ._light import _native, _options
from ._page import notebook_html, table
from ._progress import Progress, watching
from ._pyazulejo import AzulejoError, NativeLightmap, bake_lightmap
from ._scene import Scene, _read_only


class LightmapPage(NamedTuple):
    """Texels of a lightmap, rows from the top, where texture coordinates begin as in glTF."""

    irradiance: npt.NDArray[np.float32]
    """(height, width, 3), W/m², red, green and blue; around charts what continues them."""
    std_error: npt.NDArray[np.float32]
    """(height, width, 3), W/m²"""
    area: npt.NDArray[np.float32]
    """(height, width), of the surface that the texel covers, square scene units; 0 where it covers none."""


class Lightmap:
    """Irradiance in the texels of surfaces, of :func:`bake`. In a notebook it is shown as a page."""

    _native: NativeLightmap

    def __init__(self) -> None:
        raise TypeError("a Lightmap is made by bake")

    @classmethod
    def _of(cls, native: NativeLightmap) -> Lightmap:
        lightmap = cls.__new__(cls)
        lightmap._native = native
        return lightmap

    @cached_property
    def pages(self) -> tuple[LightmapPage, ...]:
        """Its pages, as arrays that cannot be written to."""
        return tuple(
            LightmapPage(*(_read_only(array) for array in page)) for page in self._native.pages
        )

    @cached_property
    def report(self) -> Mapping[str, Any]:
        """How it was computed, as of :func:`solve_light`, and what it is: its `texels` that cover surfaces, those
        at which light was gathered (`gathered_texels`), its `charts`, and the share of the area whose other side
        has different light (`differing_sides`)."""
        return self._native.report

    @property
    def error(self) -> float:
        """Standard error of irradiance, root mean square over the area, as a share of the mean."""
        return float(self.report["error"])

    @property
    def mean(self) -> npt.NDArray[np.float64]:
        """Mean irradiance over the area (3,), W/m²."""
        return np.array(self.report["mean"])

    def save(self, path: str | PathLike[str]) -> None:
        """Write the model with its lightmap.

        Parameters
        ----------
        path : str or path
            ``.html`` for a page that shows it in any browser, without a network; ``.glb`` for glTF with
            ``MOZ_lightmap``, whose 8 bits are coarser than :attr:`pages`.

        Raises
        ------
        AzulejoError
            Another extension.
        OSError
            The file cannot be written.
        """
        kind = Path(path).suffix.lower()
        if kind not in (".html", ".glb"):
            raise AzulejoError(f'a lightmap is written to .html or .glb, not to "{fspath(path)}"')
        for note in self._native.save(fspath(path), kind == ".html", self._words()):
            warnings.warn(note, UserWarning, stacklevel=2)

    def _page(self, limit: int | None) -> str:
        return self._native.html(self._words(), limit)

    def _words(self) -> tuple[str, str]:
        known = f"{100 * self.error:.4g}% of its mean (one standard error)"
        return repr(self), f"Irradiance is known to {known}."

    def _summary(self) -> str:
        rows = (
            (str(k), [*page.area.shape[::-1], (page.area > 0).sum(), page.irradiance.max()])
            for k, page in enumerate(self.pages)
        )
        heads = ["page", "width", "height", "covered texels", "most, W/m²"]
        return table(heads, rows, len(self.pages), "pages")

    def _repr_html_(self) -> str:
        return notebook_html(self)

    def __repr__(self) -> str:
        texels = self.report["texels"]
        return f"Lightmap({texels} texels, error {100 * self.error:.2g}%)"


def bake(
    scene: Scene,
    *,
    size: int | None = None,
    texels: float | None = None,
    texels_per_metre: float | None = None,
    pages: int = 1,
    light: str = "total",
    sides: str = "brighter",
    error: float | None = None,
    rays: int | None = None,
    time: float | None = None,
    bounces: int | None = None,
    patches: int | None = None,
    patch_size: float | None = None,
    engine: str = "auto",
    allow_imbalance: bool = False,
    resolution: int | None = None,
    patch_points: int | None = None,
    seed: int = 0,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Lightmap:
    """Bake the light of a scene into a lightmap, as ``azulejo bake`` does with models other than glTF.

    Parameters
    ----------
    scene : Scene
        With something that emits, as for :func:`solve_light`. Light that it carries is ignored.
    size : int, optional
        Width and height of a page, texels: by default 1024; with `texels` or `texels_per_metre` the most, by
        default 8192.
    texels : float, optional
        About so many texels that cover surfaces.
    texels_per_metre : float, optional
        Texels per metre; where the scene has no unit, per unit of length.
    pages : int, optional
        Pages, among which whole objects are distributed; more if `size` is too small for all texels.
    light : {"total", "indirect", "direct"}, optional
        Which light.
    sides : {"brighter", "front", "split"}, optional
        Which side of surfaces: of each chart the back if it gets more than twice the light of the front, the
        front, or both.
    error : float, optional
        Refine until the estimated error is below this share of the mean irradiance, by default 0.03.
    rays : int, optional
        Rays from each patch; without an error or a time also from every texel, none of which is interpolated then.
    time, bounces, patches, patch_size, engine, allow_imbalance, resolution, patch_points, seed, memory, \
threads, progress
        As for :func:`solve_light`.

    Returns
    -------
    Lightmap
        Its :attr:`~Lightmap.pages` are arrays, and :meth:`~Lightmap.save` writes the model with it.
    """
    if texels is not None and texels_per_metre is not None:
        raise AzulejoError("texels and texels_per_metre contradict each other: give one of them")
    places = {
        "size": optional_whole("size", size, 1, 8192),
        "texels": positive("texels", texels),
        "texels_per_metre": positive("texels_per_metre", texels_per_metre),
        "pages": whole("pages", pages, 1, 256),
        "light": light,
        "sides": sides,
    }
    how = _options({**locals(), "sides": "auto", "keep_mesh": False, "interpolate": True})
    with watching(progress) as callback:
        return Lightmap._of(bake_lightmap(_native(scene), places, how, _threads(threads), callback))
