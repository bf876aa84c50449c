"""Matrices of form factors."""

from __future__ import annotations

import warnings as _warnings
from collections.abc import Hashable, Mapping, Sequence
from functools import cached_property
from html import escape
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from ._checks import (
    division,
    hemicubes,
    listed,
    optional_whole,
    periods,
    positive,
    real,
    sky_division,
    whole,
)
from ._checks import memory as _memory
from ._checks import share as _share
from ._checks import threads as _threads
from ._compressed import CompressedFactors
from ._foreign import check_sums, compressed, row_list, row_names
from ._page import SHOWN_ROWS, table
from ._progress import Progress, watching
from ._pyazulejo import (
    AzulejoError,
    NativeFormFactors,
    NativeMaterials,
    compute_compressed_factors,
    compute_form_factors,
    foreign_form_factors,
    load_form_factors,
    save_form_factors,
)
from ._rows import MatrixRows
from ._scene import Scene, _read_only
from ._scene import _unit as _metres

if TYPE_CHECKING:
    from pandas import DataFrame
    from scipy.sparse import csr_array

    Floats = npt.NDArray[np.float64]


class Factor(float):
    """A number with its standard error: the truth lies within two of them 95 times in 100."""

    std_error: float

    def __new__(cls, value: float, std_error: float) -> Factor:
        factor = super().__new__(cls, value)
        factor.std_error = std_error
        return factor

    def __getnewargs__(self) -> tuple[float, float]:  # type: ignore[override]
        """What copies and pickles are made of."""
        return float(self), self.std_error


@overload
def form_factors(
    scene: Scene,
    by: str = "patch",
    *,
    patches: int | None = None,
    patch_size: float | None = None,
    rays: int | None = None,
    engine: str = "auto",
    two_sided: bool = False,
    closure: bool | str | None = None,
    separate: bool = False,
    formulas: bool = True,
    tolerance: float | None = None,
    resolution: int | None = None,
    patch_points: int | None = None,
    periodic: str | Mapping[str, float | None] | None = None,
    sky_patches: str | None = None,
    north: float = 0.0,
    compress: None = None,
    seed: int = 0,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> FormFactors: ...
@overload
def form_factors(
    scene: Scene,
    by: str = "patch",
    *,
    patches: int | None = None,
    patch_size: float | None = None,
    rays: int | None = None,
    engine: str = "auto",
    two_sided: bool = False,
    closure: bool | str | None = None,
    separate: bool = False,
    formulas: bool = True,
    tolerance: float | None = None,
    resolution: int | None = None,
    patch_points: int | None = None,
    periodic: str | Mapping[str, float | None] | None = None,
    sky_patches: str | None = None,
    north: float = 0.0,
    compress: float,
    seed: int = 0,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> CompressedFactors: ...
def form_factors(
    scene: Scene,
    by: str = "patch",
    *,
    patches: int | None = None,
    patch_size: float | None = None,
    rays: int | None = None,
    engine: str = "auto",
    two_sided: bool = False,
    closure: bool | str | None = None,
    separate: bool = False,
    formulas: bool = True,
    tolerance: float | None = None,
    resolution: int | None = None,
    patch_points: int | None = None,
    periodic: str | Mapping[str, float | None] | None = None,
    sky_patches: str | None = None,
    north: float = 0.0,
    compress: float | None = None,
    seed: int = 0,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> FormFactors | CompressedFactors:
    """Compute the form factors (view factors) between all surfaces of a scene.

    The entry in row i, column j is the share of the light leaving i diffusely that arrives at j,
    directly or by mirrors and glass (an extended form factor), with its standard error.

    Parameters
    ----------
    scene : Scene
        Surfaces with an area.
    by : {"patch", "face", "object", "material"}, optional
        What is a row. Surfaces are divided into patches in any case, and these are grouped.
    patches : int, optional
        About how many patches; by default 2,500.
    patch_size : float, optional
        In place of `patches`, the longest edge of a patch, scene units; 0 leaves faces whole.
    rays : int, optional
        Rays from each patch, by default 4,096; chooses the engine "rays" where that is "auto".
    engine : {"auto", "rays", "hemicube", "hybrid", "analytic"}, optional
        How they are computed: by closed forms where surfaces are few and flat, else by rays.
    two_sided : bool, optional
        Whether the backs of faces are rows, too. Otherwise what they receive is `hidden`.
    closure : bool or {"never", "closed", "always"}, optional
        Whether rows are changed within their errors so that no light is missing; by default in closed
        scenes without mirrors.
    separate : bool, optional
        Whether direct light and light by mirrors are also kept apart.
    formulas : bool, optional
        Whether closed forms replace what the engine finds of close pairs.
    tolerance : float, optional
        Error of row sums that the engine "analytic" has to reach.
    resolution, patch_points : int, optional
        Pixels of a hemicube's side, and hemicubes of a patch.
    periodic : str or mapping, optional
        Axes along which the scene repeats itself without end: ``"x,y"``, or with the distances from
        copy to copy, scene units, where these are not its size: ``{"x": 96.0, "y": None}``. Rays take
        the place of other engines.
    sky_patches : str, optional
        Also find what each row sees of the patches of the sky: "tregenza" for 145, "reinhart:2" for 577,
        "reinhart:4" for 2,305. See :attr:`FormFactors.sky_patches`.
    north : float, optional
        Where north is for these patches, degrees clockwise seen from above, from +y where z is up and from
        −z where y is up.
    compress : float, optional
        The matrix in blocks between clusters of patches, for 100,000 of them and more: the error of
        products with it, relative to the largest that there could be, such as 1e-3. By rays, and
        where it would not fit in `memory`, the whole matrix never exists.
    seed : int, optional
        Seed of the random numbers.
    memory : int or str, optional
        Bytes, or text as "8G": what needs more is refused before it begins. By default the machine's.
    threads : int, optional
        Number of threads, by default as many as there are processors.
    progress : callable or bool, optional
        Called as ``progress(done, what)`` at most ten times a second, from this thread; what it raises
        ends the work. True shows a bar of tqdm.

    Returns
    -------
    FormFactors, or CompressedFactors with `compress`

    Warns
    -----
    UserWarning
        Faces overlap in one plane, so that light counts twice, or have no area, so that they are no rows.

    Raises
    ------
    AzulejoError
        The scene has no surface, or an option is out of its range.
    MemoryError
        The matrix would not fit in `memory`; the message says how large it would be.
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is a {type(scene).__name__}, expected a Scene (see load)")
    options = {
        "engine": engine,
        **division(patches, patch_size),
        "rays": optional_whole("rays", rays),
        "two_sided": bool(two_sided),
        "closure": _closure(closure),
        "separate": bool(separate),
        "formulas": bool(formulas),
        "tolerance": positive("tolerance", tolerance),
        **hemicubes(resolution, patch_points),
        "periodic": periods(periodic),
        "sky_patches": sky_division(sky_patches, north),
        "seed": whole("seed", seed, 0, 2**64 - 1),
        "memory": _memory(memory),
    }
    tolerance_of_blocks = _compression(compress, by, bool(separate))
    found: FormFactors | CompressedFactors
    with watching(progress) as callback:
        if tolerance_of_blocks is None:
            native, flaws = compute_form_factors(
                scene._native, by, options, _threads(threads), callback
            )
            found = FormFactors._of(native, scene._table)
        else:
            blocks, flaws = compute_compressed_factors(
                scene._native, tolerance_of_blocks, options, _threads(threads), callback
            )
            found = CompressedFactors(blocks, scene._table)
    for flaw in flaws:
        _warnings.warn(flaw, UserWarning, stacklevel=2)
    return found


def _compression(compress: float | None, by: str, separate: bool) -> float | None:
    if compress is None:
        return None
    tolerance = real("compress", compress)
    if not 0 < tolerance < 1:
        raise AzulejoError(f"compress is {tolerance}, expected more than 0 and less than 1, as 1e-3")
    if by != "patch":
        raise AzulejoError(f'compress: rows are patches, but by="{by}": group() the result')
    if separate:
        raise AzulejoError("compress: blocks hold the sum of all orders, but separate=True")
    return tolerance


def _closure(closure: bool | str | None) -> str | None:
    if isinstance(closure, bool):
        return "always" if closure else "never"
    return closure


class FormFactors(MatrixRows):
    """A matrix of form factors with what is known of its rows.

    It never changes: :meth:`close`, :meth:`truncate` and :meth:`group` return others, and all arrays
    are read-only. ``f["floor", "lid"]`` or ``f[0, 5]`` is one entry as a :class:`Factor`, ``f @ x``
    the product with a vector or matrix, also from the left.

    Made by :func:`form_factors`, :meth:`load`, or of a matrix of another program:

    Parameters
    ----------
    F : array_like or SciPy sparse matrix (n, n)
        The share of what leaves i that arrives at j. A_i F_ij and A_j F_ji are replaced by their mean;
        :attr:`asymmetry` says how far they differ.
    areas : array_like (n,)
        Areas of the rows, square units.
    names : sequence of n str, optional
        Names of the rows, all different; by default "0", "1", ….
    open : bool or array_like (n,), optional
        The share of each row that goes to the sky; True for what rows lack of 1. By default nothing:
        the enclosure is closed, and what rows lack is an error that :meth:`close` corrects.
    rho_s : array_like (n,), optional
        Mirror reflectances of extended factors, by default 0.
    unit : str or float, optional
        Length of a unit: "mm", "m", …, or in metres.

    Raises
    ------
    AzulejoError
        Shapes that do not fit, numbers that are not finite or negative, rows whose sum exceeds 1 by
        more than 1%.

    Examples
    --------
    >>> import pyazulejo as az
    >>> plates = az.FormFactors([[0, 1], [1, 0]], areas=[2, 2], names=["hot", "cold"])
    >>> plates["hot", "cold"]
    1.0
    """

    _asymmetry: float

    def __init__(
        self,
        F: Any,
        areas: npt.ArrayLike,
        names: Sequence[str] | None = None,
        open: bool | npt.ArrayLike = False,
        *,
        rho_s: npt.ArrayLike | None = None,
        unit: str | float | None = None,
    ) -> None:
        sizes = row_list("areas", areas, None)
        if not sizes.all():
            raise AzulejoError(f"areas: row {int(np.argmin(sizes))} has 0, expected more")
        starts, columns, values = compressed(F, len(sizes))
        mirrors = (
            np.zeros(len(sizes)) if rho_s is None else row_list("rho_s", rho_s, len(sizes), 1.0)
        )
        check_sums(starts, columns, values * (1 - mirrors)[columns])
        titles = row_names(names, len(sizes))
        if isinstance(open, (bool, np.bool_)):
            sky = np.full(len(sizes), np.nan if open else 0.0)
        else:
            sky = row_list("open", open, len(sizes), 1.0)
        native, asymmetry = foreign_form_factors(
            starts, columns, values, sizes, mirrors, sky, titles, _metres(unit)
        )
        self._native, self._table, self._asymmetry = native, None, asymmetry
        self._warn_of_asymmetry()

    @classmethod
    def _of(
        cls,
        native: NativeFormFactors,
        table: NativeMaterials | None = None,
        asymmetry: float = 0.0,
    ) -> FormFactors:
        factors = cls.__new__(cls)
        factors._native, factors._table, factors._asymmetry = native, table, asymmetry
        return factors

    @classmethod
    def load(cls, path: str | PathLike[str], *, memory: int | str | None = None) -> FormFactors:
        """Read an ``.npz`` of :meth:`save` or of ``azulejo form-factors``, or one of
        ``scipy.sparse.save_npz`` to which an array `areas` was added.

        Parameters
        ----------
        path : str or path
            The file.
        memory : int or str, optional
            Bytes that its arrays may take, or text as "8G"; by default the machine's.
        """
        native, asymmetry = load_form_factors(fspath(path), _memory(memory))
        factors = cls._of(native, None, asymmetry)
        factors._warn_of_asymmetry()
        return factors

    def _warn_of_asymmetry(self) -> None:
        if self._asymmetry > 1e-5:
            _warnings.warn(
                f"A_i F_ij and A_j F_ji differ by up to {self._asymmetry:.3g} of the smaller area; "
                "their mean is taken",
                UserWarning,
                stacklevel=3,
            )

    @property
    def asymmetry(self) -> float:
        """Largest difference of A_i F_ij and A_j F_ji, as a share of the smaller area, in what was
        given or loaded, before their mean was taken; 0 of what was computed."""
        return self._asymmetry

    def save(
        self,
        path: str | PathLike[str],
        format: str | None = None,
        *,
        precision: str = "auto",
        rows: Sequence[str] = (),
        zone: str | None = None,
        version: str | None = None,
    ) -> tuple[str, ...]:
        """Write files for other programs: all of them, or none.

        Parameters
        ----------
        path : str or path
            The file; the folder of the case for OpenFOAM; ``vfsparse.inp.001`` for uDALES.
        format : str, optional
            By default what the name says: .npz, .csv, .txt or .vf (View3D), .vtu, .idf, .epjson, .vwf,
            .dat, .i, .bdf, .mtx. Or "npz", "csv", "view3d", "view3d-binary", "vtu", "openfoam",
            "openfoam-binary", "energyplus", "energyplus-json", "udales", "calculix", "elmer",
            "elmer-binary", "moose", "nastran", "nastran-95", "matrix-market".
        precision : {"auto", "single", "double"}, optional
            How exactly an .npz has factors: 64 bits up to 4 million entries, else 32.
        rows : sequence of str, optional
            Names of rows whose factors a .vtu shows, as arrays ``F_from_NAME``.
        zone : str, optional
            The zone, space or enclosure of EnergyPlus.
        version : str, optional
            Of OpenFOAM, "v1912", "v2312" or "org"; of CalculiX, as "2.20".

        Returns
        -------
        tuple of str
            The files that were written. What their program must be told is a `UserWarning`.
        """
        names = [rows] if isinstance(rows, str) else list(rows)
        options = {
            "format": format,
            "precision": precision,
            "rows": names,
            "zone": zone,
            "version": version,
        }
        written, notes = save_form_factors(self._native, fspath(path), options)
        for note in notes:
            _warnings.warn(note, UserWarning, stacklevel=2)
        return tuple(written)

    def to_frame(self) -> DataFrame:
        """pandas.DataFrame (n, n) of the whole matrix, with names or numbers of rows."""
        try:
            from pandas import DataFrame
        except ImportError:
            raise ImportError("a frame needs pandas: pip install pandas") from None
        labels = list(self.names) if self.names is not None else list(range(len(self)))
        return DataFrame(self.matrix.toarray(), index=labels, columns=labels)

    @cached_property
    def _buffers(self) -> tuple[npt.NDArray[Any], ...]:
        """Data, standard errors, columns and starts of rows: made once, owned by compiled code."""
        return tuple(_read_only(array) for array in self._native.csr())

    def _csr(self, data: npt.NDArray[Any]) -> csr_array:
        try:
            from scipy.sparse import csr_array
        except ImportError:
            raise ImportError("sparse matrices need SciPy: pip install scipy") from None
        _, _, columns, starts = self._buffers
        matrix = csr_array((data, columns, starts), shape=self.shape, copy=False)
        # True by construction; SciPy would find out by reading all, and sort in place.
        matrix.has_canonical_format = True
        return matrix

    @cached_property
    def matrix(self) -> csr_array:
        """scipy.sparse.csr_array (n, n) of float64: share of what leaves i that arrives at j.

        Its arrays are the compiled code's own, without a copy, and read-only. Columns ascend.
        ``f.matrix.toarray()`` is dense.
        """
        return self._csr(self._buffers[0])

    @cached_property
    def std_error(self) -> csr_array:
        """scipy.sparse.csr_array (n, n) of float32: the standard error of each entry of `matrix`."""
        return self._csr(self._buffers[1])

    @cached_property
    def orders(self) -> tuple[csr_array, csr_array, csr_array]:
        """Three csr_arrays (n, n) that add up to `matrix`: direct light, light by one mirror, and by
        more mirrors or glass. Needs ``separate=True``; they store zeros where they have no entry."""
        first, second, third = (self._csr(_read_only(self._native.order(k)[0])) for k in range(3))
        return first, second, third

    @cached_property
    def row_error(self) -> Floats:
        """(n,): expected sum of the errors of a row, sky and ground included."""
        return _read_only(self._native.row_error)

    @property
    def closed(self) -> Mapping[str, float] | None:
        """What closure moved, if it was enforced: see :meth:`close`."""
        return _moved(self._native.closed)

    @property
    def truncated(self) -> Mapping[str, float] | None:
        """What truncation moved, if there was one: see :meth:`truncate`."""
        return _moved(self._native.truncated)

    def close(self, *, threads: int | None = None, progress: Progress = None) -> FormFactors:
        """The matrix changed within its errors so that rows, sky and ground add up to 1; that of another
        program, whose errors are unknown, in proportion to its entries.

        :attr:`closed` of the result says by how much: ``total`` of the whole matrix, ``mean`` and
        ``most`` of a row, and the ``deficit`` that remains in the worst row.
        """
        with watching(progress) as callback:
            return self._changed(self._native.close(_threads(threads), callback))

    def truncate(
        self, share: float, *, threads: int | None = None, progress: Progress = None
    ) -> FormFactors:
        """The matrix without pairs whose form factors are both below `share`; their weight is moved to
        the others, so that row sums and reciprocity stay."""
        number = _share("share", share)
        if number is None:
            raise TypeError("share is None, expected a number")
        with watching(progress) as callback:
            return self._changed(self._native.truncate(number, _threads(threads), callback))

    def group(self, labels: str | Mapping[str, Hashable] | Sequence[Hashable]) -> FormFactors:
        """The matrix between groups of rows.

        Parameters
        ----------
        labels : str, or sequence of n labels, or mapping of names to labels
            "face", "object" or "material"; or the label of each row; or of each name, where rows have
            names. Rows with the label None belong to no group, and what they receive is `hidden`.

        Returns
        -------
        FormFactors
            Its names are the labels as text, in the order of their first row.
        """
        return self._changed(self._grouped(labels))

    def cluster(
        self, count: int, *, angle: float = 30.0, whole_faces: bool = False
    ) -> FormFactors:
        """The matrix between clusters of neighbouring patches, about `count` of them.

        Each is one piece without holes of one object, side and material. The smallest joins a neighbour,
        over and over.

        Parameters
        ----------
        count : int
            How many are wanted. More are left, with a `UserWarning`, where patches cannot be joined: parts
            that do not touch, bends beyond `angle`, rings.
        angle : float, optional
            Largest angle between the normals of a cluster and of each of its patches, degrees, 0 to 180.
        whole_faces : bool, optional
            Whether all patches of a face stay together, as OpenFOAM's files need.

        Returns
        -------
        FormFactors
            Its names are object/0, object/1, ….
        """
        wanted = whole("count", count, 1, 2**32 - 1)
        widest = real("angle", angle)
        if not 0 <= widest <= 180:
            raise AzulejoError(f"angle is {widest}, expected 0 to 180 degrees")
        clusters = self._changed(self._native.clustered(wanted, widest, bool(whole_faces)))
        if len(clusters) > wanted:
            _warnings.warn(
                f"cluster({wanted}): {len(clusters)} rows are left: objects, sides, materials, parts that "
                f"do not touch and bends beyond {widest:g}° stay apart, and no cluster closes a ring",
                UserWarning,
                stacklevel=2,
            )
        return clusters

    def _changed(self, native: NativeFormFactors) -> FormFactors:
        return FormFactors._of(native, self._table, self._asymmetry)

    def __getitem__(self, key: tuple[str | int, str | int]) -> Factor:
        if not isinstance(key, tuple) or len(key) != 2:
            raise TypeError('expected a row and a column, as in f["floor", "lid"]')
        return Factor(*self._native.get(self._row(key[0]), self._row(key[1])))

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {name: k for k, name in enumerate(self.names or ())}

    def _row(self, key: str | int) -> int:
        if not isinstance(key, str):
            count = len(self)
            row = whole("the row", key, -count, count - 1)
            return row % count
        if self.names is None:
            raise AzulejoError(
                'rows are patches, which have no names: ask for by="object", or group("object")'
            )
        try:
            return self._numbers[key]
        except KeyError:
            raise AzulejoError(f'no row is named "{key}"; there are {listed(self.names)}') from None

    # Arrays on the left leave the product to this class.
    __array_ufunc__ = None

    def __matmul__(self, other: Any) -> Any:
        return self.matrix @ other

    def __rmatmul__(self, other: Any) -> Any:
        return other @ self.matrix

    def __repr__(self) -> str:
        rows = "patches" if self.names is None else "groups"
        closed = ", closed" if self.closed else ""
        return f"FormFactors({len(self)} {rows}, by {self.engine}{closed})"

    def _repr_html_(self) -> str:
        """The first rows as a table for notebooks: what they send to rows, sky, ground and backs, and its sum."""
        to_rows = self.matrix @ self.ends
        shares = [to_rows, self.sky, self.ground, self.hidden, self.cut + self.lost]
        numbers = np.column_stack([self.areas, *shares, sum(shares), self.row_error])[:SHOWN_ROWS]
        heads = ["row", "area", "to rows", "sky", "ground", "backs", "lost", "sum", "error of the row"]
        names = self.names or map(str, range(len(self)))
        rows = zip(names, numbers.tolist(), strict=False)
        return f"<p>{escape(repr(self))}</p>{table(heads, rows, len(self))}"


def _moved(numbers: Sequence[float] | None) -> Mapping[str, float] | None:
    names = ("total", "mean", "most", "deficit")
    return None if numbers is None else dict(zip(names, numbers, strict=True))
