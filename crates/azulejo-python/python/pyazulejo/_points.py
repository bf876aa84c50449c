"""Form factors from points: sensors."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._checks import division, facing, listed, optional_whole, periods, rows, sky_division, whole
from ._checks import memory as _memory
from ._checks import threads as _threads
from ._form_factors import Factor
from ._progress import Progress, watching
from ._pyazulejo import AzulejoError, compute_point_factors
from ._rows import SkyPatches
from ._rows import sky_patches as _sky_patches
from ._scene import Scene, _read_only

if TYPE_CHECKING:
    from scipy.sparse import csr_array

    Floats = npt.NDArray[np.float64]


def point_factors(
    scene: Scene,
    points: npt.ArrayLike,
    normals: npt.ArrayLike | None = None,
    by: str = "object",
    *,
    rays: int | None = None,
    patches: int | None = None,
    patch_size: float | None = None,
    two_sided: bool = False,
    periodic: str | Mapping[str, float | None] | None = None,
    sky_patches: str | None = None,
    north: float = 0.0,
    seed: int = 0,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> PointFactors:
    """Compute what points see of surfaces, sky and ground: rows of form factors for sensors.

    With a normal, an entry is the form factor from an element of area there, of the hemisphere that it
    faces, directly and by mirrors. Without, it is the share of the whole sphere around the point, which a
    small globe receives: with it the mean radiant temperature is
    ``(p @ T**4 + p.sky * T_sky**4 + p.ground * T_ground**4) ** 0.25`` for black surfaces of temperatures T.

    Parameters
    ----------
    scene : Scene
        Surfaces with an area.
    points : array_like (n, 3)
        Scene units.
    normals : array_like (n, 3) or (3,), optional
        Directions that the sensors face, of any length; one for all. By default the whole sphere.
    by : {"object", "patch", "face", "material"}, optional
        What is a column, as for :func:`form_factors`.
    rays : int, optional
        Rays from each point, by default 4,096.
    patches, patch_size : optional
        How finely surfaces are divided, for ``by="patch"``, as for :func:`form_factors`.
    two_sided : bool, optional
        Whether the backs of faces are columns, too. Otherwise what they receive is `hidden`.
    periodic, sky_patches, north, seed, memory, threads, progress
        As for :func:`form_factors`.

    Returns
    -------
    PointFactors

    Examples
    --------
    An element below a corner of a square, at the distance of its side.

    >>> import numpy as np, pyazulejo as az
    >>> square = np.array([[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]])
    >>> lid = az.Scene({"lid": (square, [[0, 1, 2, 3]])})
    >>> p = az.point_factors(lid, [[0, 0, 0]], normals=[0, 0, 1], rays=16_384)
    >>> abs(p[0, "lid"] - 0.138532) < 3 * p[0, "lid"].std_error < 0.005
    True
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is a {type(scene).__name__}, expected a Scene (see load)")
    places = rows("points", points)
    directions = None if normals is None else facing(normals, places)
    if by != "patch" and patches is None and patch_size is None:
        # Groups of patches do not depend on these.
        patch_size = 0.0
    options = {
        "engine": "rays",
        **division(patches, patch_size),
        "rays": optional_whole("rays", rays),
        "two_sided": bool(two_sided),
        "closure": "never",
        "separate": False,
        "formulas": False,
        "tolerance": None,
        "resolution": None,
        "patch_points": None,
        "periodic": periods(periodic),
        "sky_patches": sky_division(sky_patches, north),
        "seed": whole("seed", seed, 0, 2**64 - 1),
        "memory": _memory(memory),
    }
    with watching(progress) as callback:
        found = compute_point_factors(
            scene._native, places, directions, by, options, _threads(threads), callback
        )
    return PointFactors(*found)


class PointFactors:
    """Form factors from n points to m columns. ``p[0, "floor"]`` is one of them as a
    :class:`Factor`, ``p @ x`` the product with a vector or matrix. All arrays are read-only.

    Made by :func:`point_factors`.
    """

    def __init__(
        self,
        rows: tuple[npt.NDArray[Any], ...],
        names: list[str] | None,
        columns: int,
        rest: list[Floats],
        sky: tuple[Any, ...] | None,
    ) -> None:
        self._rows = tuple(_read_only(array) for array in rows)
        self._names = None if names is None else tuple(names)
        self._columns = columns
        self._rest = [_read_only(array) for array in rest]
        self._sky = _sky_patches(sky)

    def __len__(self) -> int:
        return self.shape[0]

    @property
    def shape(self) -> tuple[int, int]:
        """(n, m)"""
        return len(self._rows[3]) - 1, self._columns

    def _csr(self, data: npt.NDArray[Any]) -> csr_array:
        try:
            from scipy.sparse import csr_array
        except ImportError:
            raise ImportError("sparse matrices need SciPy: pip install scipy") from None
        return csr_array((data, self._rows[2], self._rows[3]), shape=self.shape)

    @cached_property
    def matrix(self) -> csr_array:
        """scipy.sparse.csr_array (n, m): form factors, or shares of the whole sphere."""
        return self._csr(self._rows[0])

    @cached_property
    def std_error(self) -> csr_array:
        """scipy.sparse.csr_array (n, m): the standard error of each entry of `matrix`."""
        return self._csr(self._rows[1])

    @property
    def names(self) -> tuple[str, ...] | None:
        """Names of the columns; None of patches."""
        return self._names

    @property
    def sky(self) -> Floats:
        """(n,): share that leaves the scene upwards."""
        return self._rest[0]

    @property
    def sky_error(self) -> Floats:
        """(n,): standard error of `sky`."""
        return self._rest[1]

    @property
    def ground(self) -> Floats:
        """(n,): share that leaves the scene downwards."""
        return self._rest[2]

    @property
    def ground_error(self) -> Floats:
        """(n,): standard error of `ground`."""
        return self._rest[3]

    @property
    def sky_patches(self) -> SkyPatches | None:
        """What points see of each patch of the sky, if `sky_patches` was asked for, else None."""
        return self._sky

    @property
    def hidden(self) -> Floats:
        """(n,): share that ends on sides without a column: backs, without ``two_sided``."""
        return self._rest[4]

    @property
    def hidden_error(self) -> Floats:
        """(n,): standard error of `hidden`."""
        return self._rest[7]

    @property
    def cut(self) -> Floats:
        """(n,): share that is cut off between mirrors as too weak."""
        return self._rest[5]

    @property
    def lost(self) -> Floats:
        """(n,): share that is absorbed where there is no column, in coloured glass."""
        return self._rest[6]

    def __getitem__(self, key: tuple[int, str | int]) -> Factor:
        if not isinstance(key, tuple) or len(key) != 2:
            raise TypeError('expected a point and a column, as in p[0, "lid"]')
        count, columns = self.shape
        row = whole("the point", key[0], -count, count - 1) % count
        column = key[1]
        if isinstance(column, str):
            if self._names is None:
                raise AzulejoError('columns are patches, which have no names: ask for by="object"')
            if column not in self._names:
                raise AzulejoError(
                    f'no column is named "{column}"; there are {listed(self._names)}'
                )
            column = self._names.index(column)
        column = whole("the column", column, -columns, columns - 1) % columns
        values, errors, places, starts = self._rows
        piece = slice(int(starts[row]), int(starts[row + 1]))
        k = int(np.searchsorted(places[piece], column))
        if k < piece.stop - piece.start and places[piece][k] == column:
            return Factor(float(values[piece][k]), float(errors[piece][k]))
        return Factor(0.0, 0.0)

    __array_ufunc__ = None

    def __matmul__(self, other: Any) -> Any:
        return self.matrix @ other

    def __repr__(self) -> str:
        return f"PointFactors({self.shape[0]} points, {self.shape[1]} columns)"
