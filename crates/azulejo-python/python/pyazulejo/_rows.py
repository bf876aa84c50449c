"""What is known of the rows of a matrix."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._checks import listed
from ._pyazulejo import AzulejoError, NativeFormFactors, NativeMaterials
from ._scene import _read_only

if TYPE_CHECKING:
    Floats = npt.NDArray[np.float64]


class SkyPatches(NamedTuple):
    """What rows, or points, see of the patches of the sky: the irradiance of each is
    ``np.pi * p.shares @ radiance``. Patch 0 is the ground; the others follow in the order of Radiance's
    `gendaymtx`, in bands from the horizon to the zenith, each from north clockwise. All arrays are read-only."""

    shares: npt.NDArray[np.float32]
    """(n, p): share of each row's light that leaves toward each patch; of points without a normal, of the sphere."""
    std_error: npt.NDArray[np.float32]
    """(n, p): their standard errors, as those of independent rays: an upper bound."""
    directions: npt.NDArray[np.float64]
    """(p, 3): unit vectors of the scene to the middles of the patches."""
    solid_angles: npt.NDArray[np.float64]
    """(p,): sr."""
    division: str
    """Name of the division: "tregenza", "reinhart:2", …"""


def sky_patches(found: tuple[Any, ...] | None) -> SkyPatches | None:
    """Of what compiled code found."""
    if found is None:
        return None
    shares, std_error, directions, solid_angles, division = found
    return SkyPatches(
        _read_only(shares),
        _read_only(std_error),
        _read_only(directions),
        _read_only(solid_angles),
        division,
    )


class MatrixRows:
    """Areas, names, geometry and shares of the rows of a matrix, whole or in blocks."""

    _native: NativeFormFactors
    _table: NativeMaterials | None

    def __len__(self) -> int:
        return len(self._native)

    @property
    def shape(self) -> tuple[int, int]:
        """(n, n)"""
        return len(self), len(self)

    @cached_property
    def areas(self) -> Floats:
        """(n,), square scene units."""
        return _read_only(self._native.areas)

    def _rest(self, name: str) -> Floats:
        return _read_only(self._native.share(name))

    @cached_property
    def sky(self) -> Floats:
        """(n,): share that leaves the scene upwards, the sky view factor."""
        return self._rest("sky")

    @cached_property
    def sky_error(self) -> Floats:
        """(n,): standard error of `sky`."""
        return self._rest("sky_error")

    @cached_property
    def ground(self) -> Floats:
        """(n,): share that leaves the scene downwards."""
        return self._rest("ground")

    @cached_property
    def ground_error(self) -> Floats:
        """(n,): standard error of `ground`."""
        return self._rest("ground_error")

    @cached_property
    def sky_patches(self) -> SkyPatches | None:
        """What rows see of each patch of the sky, if `sky_patches` was asked for, else None."""
        return sky_patches(self._native.sky_patches)

    @cached_property
    def hidden(self) -> Floats:
        """(n,): share that ends on sides without a row: backs, without ``two_sided``."""
        return self._rest("hidden")

    @cached_property
    def hidden_error(self) -> Floats:
        """(n,): standard error of `hidden`."""
        return self._rest("hidden_error")

    @cached_property
    def cut(self) -> Floats:
        """(n,): share that is cut off between mirrors as too weak."""
        return self._rest("cut")

    @cached_property
    def lost(self) -> Floats:
        """(n,): share that is absorbed where there is no row, in coloured glass."""
        return self._rest("lost")

    @cached_property
    def irradiance(self) -> Floats | None:
        """(n, 3): light of the scene's sun, sky and pictures of the surroundings on each row, W/m²,
        red, green and blue, straight and by way of one mirror; None if there is none."""
        outside = self._native.outside
        return None if outside is None else _read_only(outside[0])

    @cached_property
    def irradiance_error(self) -> Floats | None:
        """(n, 3): standard error of `irradiance`."""
        outside = self._native.outside
        return None if outside is None else _read_only(outside[1])

    @cached_property
    def ends(self) -> Floats:
        """(n,): share of the light arriving at each column that ends there, 1 − ρ_s. Rows close:
        ``f @ f.ends + f.sky + f.ground + f.hidden + f.cut + f.lost`` is 1 but for noise."""
        return _read_only(self._native.ends)

    @cached_property
    def names(self) -> tuple[str, ...] | None:
        """Names of the rows if they are groups, else None. Backs are groups of their own."""
        names = self._native.names
        return None if names is None else tuple(names)

    @cached_property
    def _pieces(self) -> list[npt.NDArray[Any]]:
        return [_read_only(array) for array in self._native.pieces]

    @property
    def object(self) -> npt.NDArray[np.int32]:
        """(n,): the number of each row's object in the scene; of a group, that of its first patch."""
        return self._pieces[0]

    @property
    def face(self) -> npt.NDArray[np.int32]:
        """(n,): the number of each row's face in its object."""
        return self._pieces[1]

    @property
    def material(self) -> npt.NDArray[np.int32]:
        """(n,): the number of each row's material in the scene."""
        return self._pieces[2]

    @property
    def is_back(self) -> npt.NDArray[np.bool_]:
        """(n,): whether each row is the back of its patch."""
        return self._pieces[3]

    @cached_property
    def _geometry(self) -> tuple[npt.NDArray[Any], ...]:
        geometry = self._native.geometry
        if geometry is None:
            if self.engine == "given":
                raise AzulejoError(
                    "the matrix was given without geometry, so its rows have no corners"
                )
            raise AzulejoError('rows are groups, which have no corners: ask for by="patch"')
        return tuple(_read_only(array) for array in geometry)

    @property
    def corners(self) -> Floats:
        """(c, 3): corners of all patches, counter-clockwise from the front, scene units."""
        return self._geometry[0]

    @property
    def corner_offsets(self) -> npt.NDArray[np.int64]:
        """(n + 1,): row i has ``corners[corner_offsets[i]:corner_offsets[i + 1]]``, three or four."""
        return self._geometry[1]

    @property
    def centroids(self) -> Floats:
        """(n, 3), scene units."""
        return self._geometry[2]

    @property
    def normals(self) -> Floats:
        """(n, 3): unit normals."""
        return self._geometry[3]

    @property
    def engine(self) -> str:
        """The engine that ran."""
        return self._native.engine[0]

    @property
    def notes(self) -> tuple[str, ...]:
        """Why that engine ran, and deviations from what was asked for."""
        return tuple(self._native.engine[2])

    @property
    def rays(self) -> int:
        """Rays traced from patches."""
        return self._native.rays

    @property
    def is_closed(self) -> bool:
        """Whether no row loses light to the outside."""
        return self._native.is_closed

    def _grouped(
        self, labels: str | Mapping[str, Hashable] | Sequence[Hashable]
    ) -> NativeFormFactors:
        """The matrix between groups of rows."""
        if isinstance(labels, str):
            return self._native.grouped_by(labels)
        if isinstance(labels, Mapping):
            labels = self._labels_of_names(labels)
        listed_labels = labels.tolist() if isinstance(labels, np.ndarray) else list(labels)
        if len(listed_labels) != len(self):
            raise AzulejoError(f"{len(listed_labels)} labels for {len(self)} rows")
        numbers: dict[Hashable, int] = {}
        groups = [
            -1 if label is None else numbers.setdefault(label, len(numbers))
            for label in listed_labels
        ]
        names = [str(label) for label in numbers]
        if not names:
            raise AzulejoError("no row has a label")
        if len(set(names)) < len(names):
            raise AzulejoError("two labels are the same as text")
        return self._native.grouped(np.asarray(groups, dtype=np.int64), names)

    def _labels_of_names(self, labels: Mapping[str, Hashable]) -> list[Hashable]:
        if self.names is None:
            raise AzulejoError("rows are patches, which have no names: pass a label for each row")
        missing = [name for name in self.names if name not in labels]
        if missing:
            raise AzulejoError(f"no label for {listed(missing)}")
        return [labels[name] for name in self.names]
