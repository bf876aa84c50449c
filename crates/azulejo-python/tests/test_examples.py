"""The scripts of examples/python run and draw their pictures."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

SCRIPTS = sorted((ROOT / "examples" / "python").glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=[path.stem for path in SCRIPTS])
def test_an_example(script: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    subprocess.run(
        [sys.executable, "-W", "error::UserWarning", script, tmp_path], check=True, cwd=ROOT
    )
    assert (tmp_path / f"{script.stem}.png").stat().st_size > 10_000
