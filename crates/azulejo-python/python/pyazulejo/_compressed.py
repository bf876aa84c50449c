"""Matrices in blocks between clusters of patches."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from functools import cached_property
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._checks import memory as _memory
from ._pyazulejo import (
    AzulejoError,
    NativeCompressedFactors,
    NativeMaterials,
    load_compressed_factors,
)
from ._rows import MatrixRows
from ._scene import _read_only

if TYPE_CHECKING:
    from scipy.sparse.linalg import LinearOperator

    from ._form_factors import Factor, FormFactors

    Floats = npt.NDArray[np.float64]


class CompressedFactors(MatrixRows):
    """Form factors in blocks between clusters of patches: for 100,000 patches and more.

    There are no single entries, but products: ``f @ x``, ``x @ f``, and :attr:`operator`, with which
    SciPy's solvers work. Made by ``form_factors(scene, compress=1e-3)`` and :meth:`load`. It never
    changes; arrays are read-only.

    Examples
    --------
    Light in a room whose floor emits, by SciPy:

    >>> import numpy as np, pyazulejo as az
    >>> from scipy.sparse.linalg import LinearOperator, gmres
    >>> square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> plates = {"floor": (square, [[0, 1, 2, 3]]), "lid": (square + [0, 0, 1], [[3, 2, 1, 0]])}
    >>> f = az.form_factors(az.Scene(plates), patches=200, rays=256, compress=1e-3)
    >>> emitted = np.where(f.object == 0, 1.0, 0.0)
    >>> system = LinearOperator(f.shape, lambda b: b - 0.5 * (f @ b), dtype=float)
    >>> b, failed = gmres(system, emitted, rtol=1e-8)
    >>> failed, bool(np.allclose(b, emitted + 0.5 * (f @ b), atol=1e-6))
    (0, True)
    """

    _blocks: NativeCompressedFactors

    def __init__(
        self, blocks: NativeCompressedFactors, table: NativeMaterials | None = None
    ) -> None:
        if not isinstance(blocks, NativeCompressedFactors):
            raise TypeError("expected form_factors(scene, compress=...) or CompressedFactors.load")
        self._blocks, self._native, self._table = blocks, blocks.rows, table

    @classmethod
    def load(cls, path: str | PathLike[str], *, memory: int | str | None = None) -> CompressedFactors:
        """Read an ``.npz`` of :meth:`save` or of ``azulejo form-factors --compress``.

        Parameters
        ----------
        path : str or path
            The file.
        memory : int or str, optional
            Bytes that its arrays may take, or text as "8G"; by default the machine's.
        """
        return cls(load_compressed_factors(fspath(path), _memory(memory)))

    def save(self, path: str | PathLike[str]) -> None:
        """Write an ``.npz``, which ``azulejo exchange`` and ``azulejo info`` read, too."""
        self._blocks.save(fspath(path))

    @property
    def dtype(self) -> np.dtype[np.float64]:
        """That of products: float64."""
        return np.dtype(np.float64)

    def _product(self, x: Any, transposed: bool) -> Any:
        if np.iscomplexobj(x):
            array = np.asarray(x)
            real, imaginary = (self._product(part, transposed) for part in (array.real, array.imag))
            return real + 1j * imaginary
        array = np.asarray(x, dtype=np.float64)
        if array.ndim not in (1, 2) or len(array) != len(self):
            raise AzulejoError(
                f"a factor of shape {array.shape}, expected ({len(self)},) or ({len(self)}, k)"
            )
        columns = np.ascontiguousarray(array.reshape(len(self), -1))
        return self._blocks.products(columns, transposed).reshape(array.shape)

    def matvec(self, x: npt.ArrayLike) -> Any:
        """X x, (n,): what arrives at each row per area, of radiosities x (n,)."""
        return self._product(x, False)

    def rmatvec(self, x: npt.ArrayLike) -> Any:
        """Xᵀ x, (n,): the power that arrives at each row, of powers x (n,) that leave."""
        return self._product(x, True)

    def matmat(self, x: npt.ArrayLike) -> Any:
        """X times a matrix (n, k), all columns in one pass over the blocks."""
        return self._product(x, False)

    def rmatmat(self, x: npt.ArrayLike) -> Any:
        """Xᵀ times a matrix (n, k)."""
        return self._product(x, True)

    @cached_property
    def operator(self) -> LinearOperator:
        """scipy.sparse.linalg.LinearOperator (n, n) of float64: X, for SciPy's solvers."""
        try:
            from scipy.sparse.linalg import LinearOperator
        except ImportError:
            raise ImportError("linear operators need SciPy: pip install scipy") from None
        return LinearOperator(
            self.shape,
            matvec=self.matvec,
            rmatvec=self.rmatvec,
            matmat=self.matmat,
            rmatmat=self.rmatmat,
            dtype=self.dtype,
        )

    def product_with_errors(self, x: npt.ArrayLike) -> tuple[Floats, Floats]:
        """X x and its standard errors (n,) by the noise of rays, where x has none of its own.

        What clusters average out is not in them: see :attr:`product_error`.
        """
        array = np.asarray(x, dtype=np.float64)
        if array.shape != (len(self),):
            raise AzulejoError(f"a vector of shape {array.shape}, expected ({len(self)},)")
        found, errors = self._blocks.product_with_errors(array.tolist())
        return _read_only(found), _read_only(errors)

    def group(self, labels: str | Mapping[str, Hashable] | Sequence[Hashable]) -> FormFactors:
        """The whole matrix between groups of rows: see :meth:`FormFactors.group`. One product each."""
        from ._form_factors import FormFactors

        return FormFactors._of(self._grouped(labels), self._table)

    def _stated(self, at: int) -> Factor:
        from ._form_factors import Factor

        return Factor(*self._blocks.stated[at : at + 2])

    @property
    def tolerance(self) -> float:
        """The tolerance that was asked for."""
        return self._blocks.stated[0]

    @property
    def product_error(self) -> Factor:
        """Error of products with random numbers in 0..1, over their RMS, with its standard error.

        By rays against the truth, from rows that were traced again (:attr:`traced_again`); otherwise
        against the whole matrix that was compressed, and exact.
        """
        return self._stated(1)

    @property
    def row_sum_error(self) -> Factor:
        """RMS error of row sums, likewise."""
        return self._stated(3)

    @property
    def traced_again(self) -> int:
        """Rows that were traced again for these errors; 0 if they are against the whole matrix."""
        return self._blocks.traced_again

    @property
    def nbytes(self) -> int:
        """Bytes of the blocks."""
        return self._blocks.bytes[0]

    @property
    def whole_nbytes(self) -> int:
        """Bytes of the whole matrix, 16 for each pair; by rays a forecast."""
        return self._blocks.bytes[1]

    @property
    def blocks(self) -> Mapping[str, int]:
        """Number of blocks that are ``sparse``, ``dense`` and of ``low_rank``."""
        return dict(zip(("sparse", "dense", "low_rank"), self._blocks.blocks, strict=True))

    # Arrays on the left leave the product to this class.
    __array_ufunc__ = None

    def __matmul__(self, other: Any) -> Any:
        return self._product(other, False)

    def __rmatmul__(self, other: Any) -> Any:
        return self._product(np.asarray(other).T, True).T

    def __repr__(self) -> str:
        return f"CompressedFactors({len(self)} patches, by {self.engine}, {self.nbytes:,} bytes)"
