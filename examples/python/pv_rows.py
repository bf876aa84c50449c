"""Rows of photovoltaic modules before a facade: matt, or a mirror.

How much of the light of a uniform sky arrives on the last row, over the height of its modules: directly
(its sky view factor), by the mirror (the extended view factor), and with all reflections.

python examples/python/pv_rows.py [folder for the picture]
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import pyazulejo as az

ROWS, PITCH, SLOPE, TILT = 4, 5.0, 3.0, np.radians(30)
WIDTH, FACADE = 60.0, 10.0
CELLS = 12
"""Rows of cells up the slope of a module."""

DOWN = np.array([0.0, -np.cos(TILT), -np.sin(TILT)])
NORMAL = np.array([0.0, -np.sin(TILT), np.cos(TILT)])


def rectangle(
    origin: np.ndarray, u: np.ndarray, v: np.ndarray, n: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """A rectangle in n strips along v, whose fronts face u × v."""
    edges = origin + np.linspace(0, 1, n + 1)[:, None] * v
    vertices = np.concatenate([edges, edges + u])
    k = np.arange(n)
    return vertices, np.stack([k, k + n + 1, k + n + 2, k + 1], axis=1)


def plant(facade: az.Material) -> az.Scene:
    """Modules face south, to −y; the facade stands north of the last row and faces south, too."""
    x = np.array([WIDTH, 0, 0])
    meshes = {}
    for row in range(ROWS):
        foot = np.array([0, row * PITCH, 0.6])
        meshes[f"row {row}"] = rectangle(foot, x, -SLOPE * DOWN, CELLS)
    last = (ROWS - 1) * PITCH + 5.5
    ground = np.array([-20.0, -20.0, 0.0])
    meshes["ground"] = rectangle(
        ground, np.array([WIDTH + 40, 0, 0]), np.array([0, last + 20, 0]), 20
    )
    wall = np.array([0, last, 0.0])
    meshes["facade"] = rectangle(wall, x, np.array([0, 0, FACADE]))
    materials = {
        "row *": az.Material(diffuse=0.05),
        "ground": az.Material(diffuse=0.2),
        "facade": facade,
    }
    return az.Scene(meshes, materials, sky=1 / np.pi, unit="m")


def main(folder: Path) -> None:
    facades = {
        "matt, 60%": az.Material(diffuse=0.6),
        "mirror, 60%": az.Material(diffuse=0.0, mirror=0.6),
    }
    height = (np.arange(CELLS) + 0.5) / CELLS * SLOPE
    foot = np.array([WIDTH / 2, (ROWS - 1) * PITCH, 0.6])
    # Backs of modules see the facade, fronts see the row before them.
    points = foot - height[:, None] * DOWN
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), sharex=True, layout="constrained")
    for name, facade in facades.items():
        scene = plant(facade)
        f = az.form_factors(scene, by="face", patch_size=2.5, rays=2048, two_sided=True)
        names = f.names
        assert names is not None
        for axis, side, normal in zip(axes, ("", " (back)"), (NORMAL, -NORMAL), strict=True):
            rows = [names.index(f"row {ROWS - 1}/{k}{side}") for k in range(CELLS)]
            (line,) = axis.plot(height, f.sky[rows], "--", label=f"{name}: sky view factor")
            light = az.probe(scene, points + 1e-3 * normal, normal, error=0.01)
            axis.errorbar(
                height,
                light.value[:, 1],
                2 * light.std_error[:, 1],
                color=line.get_color(),
                capsize=2,
                label=f"{name}: with all reflections",
            )
    for axis, title in zip(axes, ("front", "back"), strict=True):
        axis.set(title=f"{title} of the last row", xlabel="along the slope, m", ylim=(0, None))
    axes[0].set_ylabel("of the light on open, level ground")
    axes[1].legend(frameon=False, fontsize=8)
    figure.savefig(folder / "pv_rows.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
