"""Scenes that tests share."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pyazulejo as az

ROOT = Path(__file__).resolve().parents[3]

# Corners of the faces of a unit cube whose fronts face inwards.
FACES = {
    "x0": [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]],
    "x1": [[1, 0, 0], [1, 0, 1], [1, 1, 1], [1, 1, 0]],
    "y0": [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]],
    "y1": [[0, 1, 0], [1, 1, 0], [1, 1, 1], [0, 1, 1]],
    "floor": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
    "lid": [[0, 0, 1], [0, 1, 1], [1, 1, 1], [1, 0, 1]],
}

OPPOSITE = 0.19982489569839
"""Between opposite faces of a cube."""


def faces_of_cube() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    quad = np.array([[0, 1, 2, 3]])
    return {name: (np.array(corners, dtype=float), quad) for name, corners in FACES.items()}


@pytest.fixture
def cube() -> az.Scene:
    return az.Scene(faces_of_cube())


@pytest.fixture
def cube_file(tmp_path: Path) -> Path:
    """The same as a file."""
    lines = []
    for k, (name, corners) in enumerate(FACES.items()):
        lines.append(f"o {name}")
        lines += ["v {} {} {}".format(*corner) for corner in corners]
        lines.append("f " + " ".join(str(4 * k + c) for c in (1, 2, 3, 4)))
    path = tmp_path / "cube.obj"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def command() -> str:
    """The command to compare with."""
    path = os.environ.get("AZULEJO_COMMAND")
    if not path:
        pytest.skip("AZULEJO_COMMAND does not name the command azulejo")
    return path


@pytest.fixture
def refuses() -> Callable[..., None]:
    """Checks that a call is refused with certain words."""

    def check(words: str, call: Callable[[], object], kind: type = az.AzulejoError) -> None:
        with pytest.raises(kind) as caught:
            call()
        assert words in str(caught.value), str(caught.value)

    return check
