"""Progress of long calls."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Union

ProgressCallback = Callable[[float, str], Any]
"""Called with the completed share of a stage, 0 to 1, and its name."""

Progress = Union[bool, ProgressCallback, None]


@contextmanager
def watching(progress: Progress) -> Iterator[ProgressCallback | None]:
    """What the compiled half calls, at most ten times a second and from the calling thread."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        with _bar() as callback:
            yield callback
    elif callable(progress):
        yield progress
    else:
        kind = type(progress).__name__
        raise TypeError(f"progress is a {kind}, expected a callable, True or None")


@contextmanager
def _bar() -> Iterator[ProgressCallback]:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        raise ImportError("progress=True needs tqdm: pip install tqdm") from None
    with tqdm(
        total=100, unit="%", leave=False, bar_format="{desc} {percentage:3.0f}% {bar}"
    ) as bar:

        def callback(done: float, what: str) -> None:
            bar.set_description_str(what, refresh=False)
            bar.n = round(100 * done)
            bar.refresh()

        yield callback
