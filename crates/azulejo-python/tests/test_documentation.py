"""The examples of pages."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import pytest
from conftest import ROOT

PAGES = ["docs/python.md", "README.md", "crates/azulejo-python/README.md"]


@pytest.mark.parametrize("page", PAGES)
def test_a_page(
    page: str, cube_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each block goes on where the one before it ended."""
    for package in ("scipy", "pandas", "pyvista"):
        pytest.importorskip(package)
    blocks = re.findall(
        r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE
    )
    assert blocks, "there are no examples"
    cube_file.rename(tmp_path / "room.obj")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        for block in blocks:
            exec(compile(block, page, "exec"), names)
