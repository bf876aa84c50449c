"""Checks of what users pass, with sentences that say what was found and what was expected."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Iterable, Mapping
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._pyazulejo import AzulejoError

Colour = Union[float, "npt.ArrayLike"]
"""One number, or red, green and blue."""

_U32 = 2**32 - 1
_BYTES = {"": 1, "k": 2**10, "m": 2**20, "g": 2**30, "t": 2**40}


def whole(name: str, value: Any, low: int = 1, high: int = _U32) -> int:
    """A whole number in a range."""
    try:
        number = operator.index(value)
    except TypeError:
        kind = type(value).__name__
        raise TypeError(f"{name} is a {kind}, expected a whole number") from None
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} is a bool, expected a whole number")
    if not low <= number <= high:
        raise AzulejoError(f"{name} is {number}, expected {low} to {high}")
    return number


def optional_whole(name: str, value: Any, low: int = 1, high: int = _U32) -> int | None:
    """A whole number in a range, or the default."""
    return None if value is None else whole(name, value, low, high)


def real(name: str, value: Any) -> float:
    """A finite number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {value!r}, expected a number") from None
    if not math.isfinite(number):
        raise AzulejoError(f"{name} is {number}, expected a finite number")
    return number


def periods(value: Any) -> str | None:
    """Axes along which a scene repeats itself, with or without lengths, as the command spells them."""
    if value is None or isinstance(value, str):
        return value
    if not isinstance(value, Mapping):
        kind = type(value).__name__
        raise TypeError(f"periodic is a {kind}, expected text as 'x,y' or a mapping of axes to lengths")
    lengths = value.items()
    return ",".join(
        f"{axis}" if length is None else f"{axis}={real(f'periodic[{axis!r}]', length)!r}"
        for axis, length in lengths
    )


def not_negative(name: str, value: Any) -> float | None:
    """A number that is not negative, or the default."""
    if value is None:
        return None
    number = real(name, value)
    if number < 0:
        raise AzulejoError(f"{name} is {number}, expected 0 or more")
    return number


def positive(name: str, value: Any) -> float | None:
    """A number above 0, or the default."""
    if value is None:
        return None
    number = real(name, value)
    if number <= 0:
        raise AzulejoError(f"{name} is {number}, expected more than 0")
    return number


def share(name: str, value: Any) -> float | None:
    """A share of 1, or the default."""
    number = positive(name, value)
    if number is not None and number > 1:
        raise AzulejoError(f"{name} is {number}, expected at most 1 (0.01 is one percent)")
    return number


def memory(value: int | str | None, name: str = "memory") -> int | None:
    """Bytes: a number, or text as "8G"."""
    if isinstance(value, str):
        found = re.fullmatch(r"\s*([0-9.]+)\s*([kKmMgGtT]?)i?[bB]?\s*", value)
        if not found:
            raise AzulejoError(f'{name} is "{value}", expected bytes, or as in "512M" or "8G"')
        value = int(real(name, found[1]) * _BYTES[found[2].lower()])
    return optional_whole(name, value, 2**20, 2**60)


def colour(name: str, value: Colour) -> tuple[float, float, float]:
    """Red, green and blue, of one number if that is given."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {value!r}, expected a number or three") from None
    if array.shape not in ((), (3,)):
        raise AzulejoError(f"{name} has the shape {array.shape}, expected one number or three")
    red, green, blue = np.broadcast_to(array, 3).tolist()
    if not all(math.isfinite(x) and x >= 0 for x in (red, green, blue)):
        raise AzulejoError(f"{name} is {array.tolist()}, expected finite numbers of 0 or more")
    return red, green, blue


def vector(name: str, value: npt.ArrayLike | None) -> tuple[float, float, float] | None:
    """Three finite numbers, or the default."""
    if value is None:
        return None
    array = numbers(name, value)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise AzulejoError(f"{name} is {array.tolist()}, expected three finite numbers")
    x, y, z = array.tolist()
    return x, y, z


def rows(name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """An array of n rows of three finite numbers, in the order of C."""
    array = numbers(name, value)
    if array.ndim != 2 or array.shape[1] != 3:
        raise AzulejoError(f"{name} have the shape {array.shape}, expected (n, 3)")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if bad.size:
        raise AzulejoError(f"{name}: row {bad[0]} is not finite: {array[bad[0]].tolist()}")
    return array


def facing(value: npt.ArrayLike, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """A direction for each point, of any length, or of one for all."""
    array = numbers("normals", value)
    array = rows("normals", np.broadcast_to(array, points.shape) if array.shape == (3,) else array)
    if array.shape != points.shape:
        raise AzulejoError(f"{len(array)} normals for {len(points)} points")
    largest = abs(array).max(axis=1, initial=0, keepdims=True)
    if not (largest > 0).all():
        raise AzulejoError(f"normal {int(np.argmin(largest))} is zero")
    # Floats hold the squares of others; their bits stay as they are.
    is_extreme = (largest < 1e-100) | (largest > 1e100)
    return np.where(is_extreme, array / largest, array)


def numbers(name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """An array of floats, copied only if it has to be."""
    try:
        array = np.asarray(value)
    except ValueError:
        raise AzulejoError(f"{name} are lists of different lengths, expected an array") from None
    if array.dtype.kind not in "fiu":
        raise AzulejoError(f"{name} are of type {array.dtype}, expected numbers")
    return np.ascontiguousarray(array, dtype=np.float64)


def threads(value: int | None) -> int | None:
    """A number of threads, or as many as there are processors."""
    return optional_whole("threads", value, 1, 1024)


def sky_division(name: str | None, north: float) -> tuple[str, float] | None:
    """A division of the sky, and the north of the scene in degrees."""
    return None if name is None else (str(name), real("north", north))


def division(patches: int | None, patch_size: float | None) -> dict[str, Any]:
    """How finely faces are divided."""
    if patches is not None and patch_size is not None:
        raise AzulejoError("patches and patch_size contradict each other: give one of them")
    return {
        "patches": optional_whole("patches", patches, 1, 10**9),
        "patch_size": not_negative("patch_size", patch_size),
    }


def hemicubes(resolution: int | None, patch_points: int | None) -> dict[str, Any]:
    """How hemicubes are rendered."""
    resolution = optional_whole("resolution", resolution, 2, 4096)
    if resolution is not None and resolution % 2:
        raise AzulejoError(f"resolution is {resolution}, expected an even number")
    return {
        "resolution": resolution,
        "patch_points": optional_whole("patch_points", patch_points, 1, 4096),
    }


def listed(names: Iterable[str], most: int = 8) -> str:
    """Names in a sentence."""
    all_names = [f'"{name}"' for name in names]
    rest = len(all_names) - most
    return ", ".join(all_names[:most]) + (f" and {rest} more" if rest > 0 else "")
