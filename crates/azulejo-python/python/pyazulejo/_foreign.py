"""Checks of matrices of other programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._checks import numbers
from ._pyazulejo import AzulejoError

if TYPE_CHECKING:
    Floats = npt.NDArray[np.float64]


def row_list(name: str, value: npt.ArrayLike, count: int | None, most: float = np.inf) -> Floats:
    """Numbers of rows, not negative."""
    array = numbers(name, value)
    if array.ndim != 1 or array.size == 0 or (count is not None and array.size != count):
        expected = "(n,)" if count is None else f"({count},)"
        raise AzulejoError(f"{name} have the shape {array.shape}, expected {expected}")
    wrong = np.flatnonzero(~((array >= 0) & (array <= most) & np.isfinite(array)))
    if wrong.size:
        range_ = "finite numbers of 0 or more" if most == np.inf else f"0 to {most:g}"
        raise AzulejoError(f"{name}: row {wrong[0]} has {array[wrong[0]]}, expected {range_}")
    return array


def compressed(F: Any, count: int) -> tuple[npt.NDArray[Any], npt.NDArray[Any], Floats]:
    """Starts, columns and values of the rows of any matrix, checked."""
    shape = getattr(F, "shape", None)
    if hasattr(F, "tocsr"):
        matrix = F.tocsr()
        try:
            matrix.check_format()
        except (ValueError, TypeError) as error:
            raise AzulejoError(f"F is a damaged matrix: {error}") from None
        starts, columns = (np.asarray(a, dtype=np.int64) for a in (matrix.indptr, matrix.indices))
        values = numbers("F", matrix.data)
    else:
        array = numbers("F", F)
        shape = array.shape
        if array.ndim == 2:
            rows, columns = (a.astype(np.int64) for a in np.nonzero(array))
            starts = np.searchsorted(rows, np.arange(len(array) + 1)).astype(np.int64)
            values = array[rows, columns]
    if shape != (count, count):
        raise AzulejoError(
            f"F has the shape {shape}, expected ({count}, {count}) as there are areas"
        )
    wrong = np.flatnonzero(~(np.isfinite(values) & (values >= 0)))
    if wrong.size:
        k = int(wrong[0])
        row = int(np.searchsorted(starts, k, side="right")) - 1
        raise AzulejoError(
            f"F[{row}, {columns[k]}] is {values[k]}, expected finite numbers of 0 or more"
        )
    return starts, columns, values


def check_sums(starts: npt.NDArray[Any], columns: npt.NDArray[Any], values: Floats) -> None:
    sums = np.add.reduceat(np.append(values, 0.0), starts[:-1]) * (np.diff(starts) > 0)
    worst = int(np.argmax(sums))
    if sums[worst] > 1.01:
        raise AzulejoError(
            f"row {worst} of F has the sum {sums[worst]:.6g}, expected at most 1: is it transposed, or "
            "does it hold A F?"
        )


def row_names(names: Sequence[str] | None, count: int) -> list[str]:
    if names is None:
        return [str(k) for k in range(count)]
    titles = [names] if isinstance(names, str) else list(names)
    if len(titles) != count:
        raise AzulejoError(f"{len(titles)} names for {count} rows")
    for title in titles:
        if not isinstance(title, str):
            raise TypeError(f"a row is named {title!r}, expected a text")
    seen: set[str] = set()
    for title in titles:
        if title in seen:
            raise AzulejoError(f'two rows are named "{title}"')
        seen.add(title)
    return titles
