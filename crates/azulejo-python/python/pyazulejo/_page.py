"""Pages that show a scene with its light, in notebooks and in browsers."""

from __future__ import annotations

import sys
import webbrowser
from collections.abc import Iterable, Sequence
from html import escape
from itertools import islice
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import TYPE_CHECKING, Any, Protocol, Union

from ._checks import memory, whole
from ._pyazulejo import AzulejoError

if TYPE_CHECKING:
    from ._lightmap import Lightmap
    from ._scene import Scene

_HEIGHT = 480
_LIMIT = "8M"


class _Shown(Protocol):
    """What has a page, and a table for where that is too large."""

    def _page(self, limit: int | None) -> str: ...

    def _summary(self) -> str: ...


def show(
    thing: Union[Scene, Lightmap], *, height: int = _HEIGHT, limit: int | str | None = _LIMIT
) -> str | None:
    """Show a scene or a lightmap: in a notebook as a frame, otherwise as a page in the web browser.

    Parameters
    ----------
    thing : Scene or Lightmap
        What is shown: a lightmap, a scene with the light on its vertices, or one that is plain.
    height : int, optional
        Height of the frame, pixels.
    limit : int or str, optional
        Most bytes that the page may add to a notebook, as in "20M"; None for any. A larger one is replaced
        by a table that says so. Pages in the browser have no limit.

    Returns
    -------
    str or None
        The file of the page outside of notebooks: a temporary file, which stays.
    """
    if not hasattr(thing, "_page"):
        raise TypeError(f"thing is a {type(thing).__name__}, expected a Scene or a Lightmap")
    height = whole("height", height, 50, 10_000)
    most = memory(limit, "limit")
    if _is_notebook():
        from IPython.display import display

        shown = {"text/html": framed(thing, height, most), "text/plain": repr(thing)}
        display(shown, raw=True)
        return None
    with NamedTemporaryFile(
        "w", encoding="utf-8", prefix="azulejo-", suffix=".html", delete=False
    ) as file:
        file.write(thing._page(None))
    webbrowser.open(Path(file.name).as_uri())
    return file.name


def framed(thing: _Shown, height: int = _HEIGHT, limit: int | None = None) -> str:
    """HTML for a notebook: a page in a frame that can reach nothing around it, or why there is none."""
    words = f"<p>{escape(repr(thing))}</p>"
    try:
        page = thing._page(limit)
    except AzulejoError as error:
        return f"{words}<p>It is not shown: {escape(str(error))}.</p>{thing._summary()}"
    # Scripts run as those of a foreign site: they see neither the notebook nor its cookies.
    return (
        f'{words}<iframe sandbox="allow-scripts" allow="fullscreen" title="{escape(repr(thing))}" '
        f'style="width: 100%; height: {height}px; border: 0" srcdoc="{escape(page)}"></iframe>'
    )


def notebook_html(thing: _Shown) -> str:
    """What a notebook shows of the value of a cell."""
    return framed(thing, limit=memory(_LIMIT))


# Rows that tables in notebooks show.
SHOWN_ROWS = 20


def table(
    heads: Sequence[str], rows: Iterable[tuple[str, Sequence[Any]]], count: int, what: str = "rows"
) -> str:
    """The first of `count` rows as HTML: a name, which may be any text, and numbers."""
    lines = ["".join(f"<th>{head}</th>" for head in heads)]
    for name, numbers in islice(rows, SHOWN_ROWS):
        cells = "".join(f"<td>{number:.4g}</td>" for number in numbers)
        lines.append(f"<th>{escape(name)}</th>{cells}")
    rest = f"<p>and {count - SHOWN_ROWS:,} more {what}</p>" if count > SHOWN_ROWS else ""
    return f"<table>{''.join(f'<tr>{line}</tr>' for line in lines)}</table>{rest}"


def _is_notebook() -> bool:
    """Whether a kernel runs this, which sends what is displayed to a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return getattr(shell, "kernel", None) is not None
