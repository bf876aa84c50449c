"""Temperatures and fluxes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from ._checks import numbers, real
from ._exchange import Exchange, node_index, solved
from ._form_factors import Factor
from ._materials import Materials
from ._progress import Progress
from ._pyazulejo import AzulejoError, NativeThermalSolution
from ._rows import MatrixRows
from ._scene import _read_only

if TYPE_CHECKING:
    Floats = npt.NDArray[np.float64]

RowValues = Union[float, Mapping[str, float], "npt.ArrayLike"]
"""One number for all rows; numbers by name; or an array with a number for each row, NaN for none."""


def radiosity(
    factors: MatrixRows | Sequence[MatrixRows],
    materials: Materials | None = None,
    T: RowValues | None = None,
    q: RowValues | None = None,
    *,
    space: float | None = None,
    sky: float | None = None,
    ground: float | None = None,
    solar: RowValues | None = None,
    by: str = "object",
    lump: bool = False,
    lost_to_sky: bool = False,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Radiosity:
    """Solve for temperatures where net fluxes are given, and for fluxes where temperatures are.

    Parameters
    ----------
    factors, materials, by, lump, lost_to_sky, memory, threads, progress
        As for :func:`exchange`.
    T : float, mapping of str to float, or array_like (n,), optional
        Temperatures, K. Names as those of `materials`; arrays have one number for each row of the
        factors, NaN where there is none.
    q : float, mapping of str to float, or array_like (n,), optional
        Net heat that leaves by radiation, W/m²; 0 for adiabatic surfaces. Every row needs T or q.
    space, sky, ground : float, optional
        Temperatures of what is seen through openings, K; `space` of both. By default 3 K.
    solar : float, mapping of str to float, or array_like (n,), optional
        Sunlight that falls on surfaces, W/m², which they absorb by their `alpha`, after all reflections.
        By default that of the factors, if their scene has a sun or a sky.

    Returns
    -------
    Radiosity

    Raises
    ------
    AzulejoError
        As for :func:`exchange`; rows without T or q, or with both; surfaces that exchange heat among
        themselves alone, none of which has a temperature.

    Examples
    --------
    >>> import pyazulejo as az
    >>> f = az.FormFactors([[0, 1], [1, 0]], areas=[1, 1], names=["heater", "wall"])
    >>> heat = az.radiosity(f, 0.8, T={"heater": 1000}, q={"wall": 0})
    >>> round(heat["wall"].T, 6), abs(heat["heater"].Q) < 1e-9
    (1000.0, True)
    """
    whole = None if space is None else _kelvin("space", space)
    around = [
        whole if value is None else _kelvin(name, value)
        for name, value in (("sky", sky), ("ground", ground))
    ]
    count = len(factors) if isinstance(factors, MatrixRows) else None
    conditions = {
        "temperatures": _values("T", T, count),
        "fluxes": _values("q", q, count),
        "solar": _values("solar", solar, count),
        "surroundings": around,
    }
    native = solved(
        factors, materials, conditions, by, lump, lost_to_sky, memory, threads, progress
    )
    return Radiosity(native)


def _kelvin(name: str, value: Any) -> float:
    number = real(name, value)
    if number < 0:
        raise AzulejoError(f"{name} is {number}, expected 0 K or more")
    return number


def _values(name: str, value: RowValues | None, count: int | None) -> Any:
    """Numbers by name as pairs, or an array for each row."""
    if value is None:
        return None
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise TypeError(f"{name} has the key {key!r}, expected a name")
        return [(key, real(f'{name} of "{key}"', number)) for key, number in value.items()]
    if np.isscalar(value):
        return [("*", real(name, value))]
    array = numbers(name, value)
    if np.ndim(value) == 0:
        return [("*", real(name, array[0]))]
    if array.ndim != 1 or (count is not None and array.size != count):
        expected = "(n,)" if count is None else f"({count},)"
        raise AzulejoError(
            f"{name} has the shape {array.shape}, expected {expected}, one for each row"
        )
    return array


class NodeHeat(NamedTuple):
    """Temperature and heat of a node."""

    T: Factor
    """Temperature, K, of the mean of T⁴ by area, with its standard error."""
    Q: Factor
    """Net heat that it gives off by radiation, W, with its standard error."""


class Radiosity:
    """Temperatures and fluxes of rows and nodes. ``r["wall"]`` is a node, with ``.T`` and ``.Q`` as
    :class:`Factor`. All arrays are read-only.

    Made by :func:`radiosity`.
    """

    def __init__(self, native: NativeThermalSolution) -> None:
        self._native = native

    @cached_property
    def _arrays(self) -> dict[str, Floats]:
        return {}

    def _heat(self, name: str) -> Floats:
        if name not in self._arrays:
            self._arrays[name] = _read_only(self._native.heat(name))
        return self._arrays[name]

    @property
    def T(self) -> Floats:
        """(n,): temperature of each row, K."""
        return self._heat("T")

    @property
    def q(self) -> Floats:
        """(n,): net heat that leaves each row by radiation, sunlight included, W/m²."""
        return self._heat("q")

    @property
    def J(self) -> Floats:
        """(n,): diffuse radiosity of each row, without sunlight, W/m²."""
        return self._heat("J")

    @property
    def H(self) -> Floats:
        """(n,): irradiation of each row, without sunlight, W/m²."""
        return self._heat("H")

    @property
    def solar(self) -> Floats:
        """(n,): sunlight that each row absorbs, W/m²."""
        return self._heat("solar")

    @cached_property
    def areas(self) -> Floats:
        """(n,): area of each row, m²."""
        return _read_only(self._native.row_areas)

    @cached_property
    def row_names(self) -> tuple[str, ...]:
        """Names of the rows."""
        return tuple(self._native.row_names)

    @cached_property
    def row_node(self) -> npt.NDArray[np.int64]:
        """(n,): the node of each row."""
        return _read_only(self._native.row_nodes)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the m nodes."""
        return tuple(self._native.node_names)

    @property
    def node_T(self) -> Floats:
        """(m,): temperature of each node, K: of the mean of T⁴ by area."""
        return self._heat("node_T")

    @property
    def node_T_error(self) -> Floats:
        """(m,): standard errors of `node_T`, K."""
        return self._heat("node_T_error")

    @property
    def node_Q(self) -> Floats:
        """(m,): net heat that leaves each node, W."""
        return self._heat("node_Q")

    @property
    def node_Q_error(self) -> Floats:
        """(m,): standard errors of `node_Q`, W."""
        return self._heat("node_Q_error")

    @property
    def to_sky(self) -> float:
        """Net heat that the sky receives, without sunlight, W."""
        return float(self._heat("to_surroundings")[0])

    @property
    def to_ground(self) -> float:
        """Net heat that ground which is not modelled receives, W."""
        return float(self._heat("to_surroundings")[1])

    @property
    def imbalance(self) -> float:
        """Heat that rows give off in excess of what sky and ground gain and the sun brings, W: 0, but
        for what the factors lack."""
        return self._native.imbalance

    @property
    def iterations(self) -> int:
        """Steps of Newton's method; 0 where the problem is linear in T⁴."""
        return self._native.iterations

    @cached_property
    def exchange(self) -> Exchange:
        """The network of the nodes, as :func:`exchange` computes it."""
        return Exchange._of(self._native)

    def __getitem__(self, key: str | int) -> NodeHeat:
        k = node_index(self.names, key)
        return NodeHeat(
            Factor(float(self.node_T[k]), float(self.node_T_error[k])),
            Factor(float(self.node_Q[k]), float(self.node_Q_error[k])),
        )

    def save(self, path: str | PathLike[str]) -> None:
        """Write a file: ``.npz`` of all arrays, ``.csv`` of the nodes, ``.vtu`` of the surfaces, as
        ``azulejo exchange --boundary`` does."""
        args = {"model": "", "sigma": False, "truncate": None, "heat": True, "band": None}
        self._native.save(fspath(path), args)

    def to_pyvista(self) -> Any:
        """pyvista.PolyData of the surfaces, with T, q, J, H, solar, the row and the node of each cell."""
        cells = self._native.cells
        if cells is None:
            raise AzulejoError(
                "the factors were given without geometry, so there is nothing to show"
            )
        try:
            import pyvista
        except ImportError:
            raise ImportError("a mesh needs pyvista: pip install pyvista") from None
        points, corners, starts, rows = cells
        lengths = np.diff(starts.astype(np.int64))
        faces = np.insert(corners.astype(np.int64), starts[:-1].astype(np.int64), lengths)
        mesh = pyvista.PolyData(points, faces)
        for name in ("T", "q", "J", "H", "solar"):
            mesh.cell_data[name] = self._heat(name)[rows]
        mesh.cell_data["row"] = rows.astype(np.int64)
        mesh.cell_data["node"] = self.row_node[rows]
        return mesh

    def __repr__(self) -> str:
        return f"Radiosity({len(self.T)} rows, {len(self.names)} nodes)"
