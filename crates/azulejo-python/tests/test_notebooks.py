"""The notebooks of docs/notebooks run, and what their words state holds: cells assert it."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def cells(notebook: Path, kind: str) -> list[str]:
    read = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in read if cell["cell_type"] == kind]


def in_a_kernel(notebook: Path, folder: Path) -> list[str]:
    """Runs a notebook as Jupyter does; what its cells display."""
    import nbclient
    import nbformat

    read = nbformat.read(notebook, as_version=4)
    nbformat.validate(read)
    client = nbclient.NotebookClient(
        read, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(folder)}}
    )
    client.execute()
    outputs = [output for cell in read.cells for output in cell.get("outputs", [])]
    return [output.data["text/html"] for output in outputs if "text/html" in output.get("data", {})]


def in_this_process(notebook: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Runs the cells of a notebook one after another; what they display."""
    shown: list[str] = []

    def display(value: Any) -> None:
        if hasattr(value, "_repr_html_"):
            shown.append(value._repr_html_())

    names: dict[str, Any] = {"__name__": "__main__", "display": display}
    import pyazulejo as az

    # Without a kernel, show would open a browser.
    monkeypatch.setattr(az, "show", lambda thing, height: display(thing))
    for cell in cells(notebook, "code"):
        parts = ast.parse(cell).body
        value = parts.pop() if parts and isinstance(parts[-1], ast.Expr) else None
        exec(compile(ast.Module(parts, []), str(notebook), "exec"), names)
        if isinstance(value, ast.Expr):
            display(eval(compile(ast.Expression(value.value), str(notebook), "eval"), names))
    return shown


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
@pytest.mark.parametrize("has_kernel", [True, False])
def test_a_notebook(
    notebook: Path, has_kernel: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if has_kernel:
        for package in ("nbclient", "nbformat", "ipykernel"):
            pytest.importorskip(package)
        shown = in_a_kernel(notebook, tmp_path)
    else:
        shown = in_this_process(notebook, monkeypatch)
    frames = [html for html in shown if "<iframe" in html]
    # Two scenes, one of them solved, and a lightmap; the table of a matrix beside them.
    assert len(frames) == 3 and len(shown) == 4
    assert sorted(path.name for path in tmp_path.iterdir()) == ["room.glb", "room.html"]


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=[path.stem for path in NOTEBOOKS])
def test_notebooks_are_kept_without_outputs(notebook: Path) -> None:
    read = json.loads(notebook.read_text(encoding="utf-8"))
    assert read["nbformat"] == 4 and set(read["metadata"]) == {"kernelspec", "language_info"}
    code = [cell for cell in read["cells"] if cell["cell_type"] == "code"]
    assert code and all(c["outputs"] == [] and c["execution_count"] is None for c in code)
    for link in re.findall(r"\]\(([^)#:]+)[^):]*\)", "\n".join(cells(notebook, "markdown"))):
        assert (notebook.parent / link).exists(), link


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS
