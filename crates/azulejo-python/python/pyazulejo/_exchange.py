"""Networks: Gebhart factors, conductances, script-F."""

from __future__ import annotations

import warnings as _warnings
from collections.abc import Mapping, Sequence
from functools import cached_property
from os import PathLike, fspath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._checks import listed, numbers, whole
from ._checks import memory as _memory
from ._checks import share as _share
from ._checks import threads as _threads
from ._form_factors import Factor
from ._materials import Materials, material_table
from ._progress import Progress, watching
from ._pyazulejo import (
    AzulejoError,
    NativeMaterials,
    NativeThermalSolution,
    band_fractions,
    solve_exchange,
)
from ._rows import MatrixRows
from ._scene import _read_only

if TYPE_CHECKING:
    from pandas import DataFrame

    Floats = npt.NDArray[np.float64]


def exchange(
    factors: MatrixRows | Sequence[MatrixRows],
    materials: Materials | None = None,
    *,
    by: str = "object",
    lump: bool = False,
    lost_to_sky: bool = False,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Exchange:
    """Who absorbs what others emit, after all reflections: Gebhart factors, conductances, script-F.

    Parameters
    ----------
    factors : FormFactors or CompressedFactors, or several
        Factors of the same rows; several if bands have other mirrors, of which each band takes the
        first that was computed with its own.
    materials : path, Material, float, or mapping of str to Material, optional
        Emissivities: the file of a table, one for all, or by the names of objects, materials, faces
        (``"floor/3"``) or rows, with ``*`` and ``?``. Exact names come before patterns, ``*`` alone is for
        all others. By default those of the scene.
    by : {"object", "row", "face", "material"}, optional
        What is one node of the network; rows that are groups are nodes themselves.
    lump : bool, optional
        Whether the rows of a node are combined before the exchange is solved, as network programs do;
        otherwise rows are solved, and their exchange is added up.
    lost_to_sky : bool, optional
        Whether light that ends on backs, or is cut off between mirrors, goes to the sky.
    memory, threads, progress
        As for :func:`form_factors`.

    Returns
    -------
    Exchange

    Raises
    ------
    AzulejoError
        Rows without a material, numbers out of range, factors that were computed with other mirrors.
    MemoryError
        The network has so many nodes that it would not fit in `memory`.

    Examples
    --------
    Two large plates: GR / A is 1 / (1/ε₁ + 1/ε₂ − 1).

    >>> import pyazulejo as az
    >>> plates = az.FormFactors([[0, 1], [1, 0]], areas=[2, 2], names=["hot", "cold"])
    >>> gr = az.exchange(plates, {"hot": 0.8, "cold": az.Material(eps=0.5)})
    >>> round(gr["hot", "cold"], 12) == round(2 / (1 / 0.8 + 1 / 0.5 - 1), 12)
    True
    """
    native = solved(factors, materials, None, by, lump, lost_to_sky, memory, threads, progress)
    return Exchange._of(native)


def band_fraction(product: npt.ArrayLike) -> Any:
    """The share of a black body's emission that has shorter wavelengths.

    Parameters
    ----------
    product : array_like
        Wavelength times temperature, µm·K.

    Returns
    -------
    float or ndarray
        0 to 1, of the shape of `product`; its error is below 1e-13.

    Examples
    --------
    A quarter lies below the wavelength of the maximum.

    >>> import pyazulejo as az
    >>> round(az.band_fraction(2897.771955), 6)
    0.250055
    """
    array = numbers("product", product)
    if (array < 0).any():
        raise AzulejoError(f"product is {array[array < 0][0]}, expected 0 or more, in µm·K")
    shares = band_fractions(array.ravel()).reshape(np.shape(product))
    return float(shares) if shares.ndim == 0 else shares


def solved(
    factors: MatrixRows | Sequence[MatrixRows],
    materials: Materials | None,
    conditions: dict[str, Any] | None,
    by: str,
    lump: bool,
    lost_to_sky: bool,
    memory: int | str | None,
    threads: int | None,
    progress: Progress,
) -> NativeThermalSolution:
    if not isinstance(factors, (MatrixRows, Sequence)):
        raise TypeError(f"factors is a {type(factors).__name__}, expected FormFactors")
    several = [factors] if isinstance(factors, MatrixRows) else list(factors)
    for item in several:
        if not isinstance(item, MatrixRows):
            raise TypeError(f"factors has a {type(item).__name__}, expected FormFactors")
    if not several:
        raise AzulejoError("there are no form factors")
    table = _table(several, materials)
    args = {
        "by": by,
        "lump": bool(lump),
        "lost_to_sky": bool(lost_to_sky),
        "memory": _memory(memory),
    }
    natives = [f._native for f in several]
    with watching(progress) as callback:
        native = solve_exchange(natives, table, conditions, args, _threads(threads), callback)
    for note in native.notes:
        _warnings.warn(note, UserWarning, stacklevel=3)
    return native


def _table(factors: list[MatrixRows], materials: Materials | None) -> NativeMaterials:
    if materials is not None:
        return material_table(materials)
    table = next((f._table for f in factors if f._table is not None), None)
    if table is None:
        raise AzulejoError(
            "no emissivities are known: pass materials, or give the scene materials with eps"
        )
    return table


class Exchange:
    """Conductances between the nodes of a network: surfaces, and after them sky and ground where light
    leaves the scene. ``x["panel", "sky"]`` is a GR as a :class:`Factor`. All arrays are read-only.

    Made by :func:`exchange`. With several bands, each is an Exchange in :attr:`bands`.
    """

    _native: NativeThermalSolution
    _band: int | None

    @classmethod
    def _of(cls, native: NativeThermalSolution, band: int | None = None) -> Exchange:
        exchange = cls.__new__(cls)
        exchange._native = native
        exchange._band = 0 if band is None and len(native.bands) == 1 else band
        return exchange

    @cached_property
    def bands(self) -> Mapping[str, Exchange]:
        """Each band in which surfaces emit, by its wavelengths in µm, as ``"0-4"`` and ``"4-inf"``; of
        grey surfaces one, named ``""``."""
        names = self._native.bands
        return MappingProxyType(
            {name: Exchange._of(self._native, k) for k, name in enumerate(names)}
        )

    def _number(self) -> int:
        if self._band is None:
            bands = listed(self._native.bands)
            raise AzulejoError(f"there are several bands: choose one of .bands, {bands}")
        return self._band

    @cached_property
    def _network(self) -> dict[str, Any]:
        return self._native.network(self._number())

    @cached_property
    def _arrays(self) -> dict[str, npt.NDArray[Any]]:
        return {}

    def _array(self, name: str) -> npt.NDArray[Any]:
        """Made when it is first asked for: networks of thousands of nodes are large."""
        if name not in self._arrays:
            known = self._network.get(name)
            array = self._native.matrix(self._number(), name) if known is None else known
            self._arrays[name] = _read_only(array)
        return self._arrays[name]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the nodes: surfaces, then "sky" and "ground" if they are seen."""
        return tuple(self._network["names"])

    @property
    def is_surface(self) -> npt.NDArray[np.bool_]:
        """(n,): whether each node is a surface, not sky or ground."""
        return self._array("is_surface")

    @property
    def areas(self) -> Floats:
        """(n,): areas, m²; of sky and ground the area that would send surfaces as much."""
        return self._array("areas")

    @property
    def emitting(self) -> Floats:
        """(n,): Σ ε A of each node, m²."""
        return self._array("emitting")

    @property
    def GR(self) -> Floats:
        """(n, n): conductances, m²; σ GR_ab (T_a⁴ − T_b⁴) flows from a to b. Symmetric to the bit."""
        return self._array("GR")

    @property
    def GR_error(self) -> Floats:
        """(n, n): standard errors of `GR`, m²."""
        return self._array("GR_error")

    @property
    def B(self) -> Floats:
        """(n, n): Gebhart factors, the share of what a emits that b absorbs in the end."""
        return self._array("B")

    @property
    def B_error(self) -> Floats:
        """(n, n): standard errors of `B`."""
        return self._array("B_error")

    @property
    def script_f(self) -> Floats:
        """(n, n): script-F, Hottel's grey interchange factor, GR_ab / A_a."""
        return self._array("script_f")

    @property
    def script_f_error(self) -> Floats:
        """(n, n): standard errors of `script_f`."""
        return self._array("script_f_error")

    def _opening(self, name: str) -> Floats:
        surfaces = self.is_surface
        count = int(surfaces.sum())
        for k in range(count, len(surfaces)):
            if self.names[k].split(" #")[0] == name:
                return self.B[:count, k]
        return _read_only(np.zeros(count))

    @property
    def sky(self) -> Floats:
        """(m,): the share of what each surface emits that ends in the sky, after all reflections."""
        return self._opening("sky")

    @property
    def ground(self) -> Floats:
        """(m,): the share that ends in ground that is not modelled."""
        return self._opening("ground")

    @property
    def asymmetry(self) -> float:
        """Largest difference of both directions of a GR, relative to the smaller `emitting`, before
        their mean was taken: the error of the solution."""
        return float(self._network["asymmetry"])

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, key: tuple[str | int, str | int]) -> Factor:
        if not isinstance(key, tuple) or len(key) != 2:
            raise TypeError('expected two nodes, as in x["panel", "sky"]')
        a, b = (node_index(self.names, k) for k in key)
        return Factor(float(self.GR[a, b]), float(self.GR_error[a, b]))

    def save(
        self,
        path: str | PathLike[str],
        *,
        model: str = "",
        sigma: bool = False,
        truncate: float | None = None,
    ) -> None:
        """Write a file: ``.npz`` of all arrays and bands, ``.csv``, or ``.esatan`` and ``.sinda`` for
        thermal networks, as ``azulejo exchange`` does.

        Parameters
        ----------
        path : str or path
            The file.
        model : str, optional
            Name of the model in .esatan, of the submodel in .sinda.
        sigma : bool, optional
            Whether .sinda has conductances times σ.
        truncate : float, optional
            The share of the smaller node's emitting area below which lists leave out conductances; their
            weight goes to the others.
        """
        args = {
            "model": model,
            "sigma": bool(sigma),
            "truncate": _share("truncate", truncate),
            "heat": False,
            "band": self._band,
        }
        self._native.save(fspath(path), args)

    def to_frame(self, quantity: str = "GR") -> DataFrame:
        """pandas.DataFrame (n, n) of "GR", "B", "script_f" or their errors, as "GR_error"."""
        known = ["GR", "B", "script_f", "GR_error", "B_error", "script_f_error"]
        if quantity not in known:
            raise AzulejoError(f'unknown quantity "{quantity}", expected {listed(known)}')
        try:
            from pandas import DataFrame
        except ImportError:
            raise ImportError("a frame needs pandas: pip install pandas") from None
        return DataFrame(self._array(quantity), index=self.names, columns=self.names)

    def __repr__(self) -> str:
        if self._band is None:
            return f"Exchange(bands {', '.join(self._native.bands)})"
        return f"Exchange({len(self)} nodes)"


def node_index(names: tuple[str, ...], key: str | int) -> int:
    if isinstance(key, str):
        try:
            return names.index(key)
        except ValueError:
            raise AzulejoError(f'no node is named "{key}"; there are {listed(names)}') from None
    return whole("the node", key, -len(names), len(names) - 1) % len(names)
