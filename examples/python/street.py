"""Sky view factors of a street canyon, facet by facet, as urban climate models want them.

The facets of four blocks of houses and of the ground between them are the rows. In the middle of a long
canyon of height H and width W the ground sees sqrt(1 + (H/W)²) − H/W of the sky (Oke 1987).

python examples/python/street.py [folder for the picture]
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import Normalize
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import pyazulejo as az

HEIGHT, WIDTH, DEPTH, LENGTH = 12.0, 10.0, 14.0, 50.0
FACET = 2.0
"""Edge of the facets, metres."""


def grid(origin: np.ndarray, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A rectangle as facets, whose fronts face u × v."""
    n, m = (max(1, round(float(np.linalg.norm(w)) / FACET)) for w in (u, v))
    s, t = np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij")
    vertices = origin + s.reshape(-1, 1) * u + t.reshape(-1, 1) * v
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    corner = i * (m + 1) + j
    return vertices, np.stack([corner, corner + m + 1, corner + m + 2, corner + 1], axis=1)


def street() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    x, y, z = np.eye(3)
    meshes = {}
    whole = 2 * DEPTH + 3 * WIDTH, 2 * LENGTH + 3 * WIDTH
    for a in range(2):
        for b in range(2):
            low = np.array([WIDTH + a * (DEPTH + WIDTH), WIDTH + b * (LENGTH + WIDTH), 0.0])
            name = f"house {2 * a + b}"
            dx, dy, dz = DEPTH * x, LENGTH * y, HEIGHT * z
            meshes[f"{name} roof"] = grid(low + dz, dx, dy)
            meshes[f"{name} south"] = grid(low, dx, dz)
            meshes[f"{name} east"] = grid(low + dx, dy, dz)
            meshes[f"{name} north"] = grid(low + dx + dy, -dx, dz)
            meshes[f"{name} west"] = grid(low + dy, -dy, dz)
    # The ground in strips, because under the houses there is none.
    xs = np.cumsum([0, WIDTH, DEPTH, WIDTH, DEPTH, WIDTH])
    ys = np.cumsum([0, WIDTH, LENGTH, WIDTH, LENGTH, WIDTH])
    for i in range(5):
        for j in range(5):
            if i % 2 and j % 2:
                continue
            low = np.array([xs[i], ys[j], 0])
            size = (xs[i + 1] - xs[i]) * x, (ys[j + 1] - ys[j]) * y
            meshes[f"ground {i}{j}"] = grid(low, *size)
    assert np.isclose(xs[-1], whole[0]) and np.isclose(ys[-1], whole[1])
    return meshes


def main(folder: Path) -> None:
    scene = az.Scene(street(), unit="m")
    # Facets are the rows as they are.
    f = az.form_factors(scene, patch_size=0, rays=1024)
    print(f"{f}, {f.matrix.nnz} entries, row errors {f.row_error.mean():.1%}")

    middle = np.array([1.5 * WIDTH + DEPTH, WIDTH + LENGTH / 2, 0])
    nearest = int(np.argmin(((f.centroids - middle) ** 2).sum(axis=1)))
    ratio = HEIGHT / WIDTH
    print(
        f"middle of the street: {f.sky[nearest]:.3f} ± {f.sky_error[nearest]:.3f}, "
        f"endless canyon {np.hypot(1, ratio) - ratio:.3f}"
    )

    figure = plt.figure(figsize=(9, 6), layout="constrained")
    axis = figure.add_subplot(projection="3d", computed_zorder=True)
    polygons = np.split(f.corners, f.corner_offsets[1:-1])
    colours = plt.colormaps["viridis"](f.sky)
    axis.add_collection3d(
        Poly3DCollection(polygons, facecolors=colours, edgecolors="k", linewidths=0.1)
    )
    low, high = scene.bounds
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axis.set_box_aspect(high - low, zoom=1.25)
    axis.view_init(elev=42, azim=-60)
    axis.set_xlabel("x, m")
    axis.set_ylabel("y, m", labelpad=12)
    axis.set_zticks([0, HEIGHT])
    bar = plt.cm.ScalarMappable(cmap="viridis", norm=Normalize(0, 1))
    figure.colorbar(bar, ax=axis, label="sky view factor", shrink=0.6)
    axis.set_title(f"{len(f)} facets, H/W = {ratio:.1f}")
    figure.savefig(folder / "street.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
