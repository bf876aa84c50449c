"""An electric furnace: how hot heaters and walls become, and what the load takes up.

Known are the power of the heaters, what the lining loses to the outside, and the temperature of the load;
wanted are the temperatures of heaters and lining, and the heat that the load receives.

python examples/python/furnace.py [folder for the picture]
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

SIZE = np.array([2.4, 1.4, 1.0])
"""Of the chamber, metres."""

POWER, HEATERS = 20e3, 4
"""Of each heater, W."""

LOSS = 1200.0
"""What the lining conducts to the outside, W/m²."""

LOAD = 700.0 + 273.15
"""Temperature of the load, K."""

Mesh = tuple[np.ndarray, list[list[int]]]

# Corners of the faces of a unit cube whose fronts face outwards.
CUBE = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
SIDES = {
    "hearth": [0, 2, 3, 1],
    "vault": [4, 5, 7, 6],
    "front": [0, 1, 5, 4],
    "back": [2, 6, 7, 3],
    "left": [0, 4, 6, 2],
    "right": [1, 3, 7, 5],
}


def rod(x: float, radius: float = 0.05, sides: int = 10) -> Mesh:
    """A heater that spans most of the width below the vault."""
    angles = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([x + radius * np.cos(angles), 0 * angles, 0.85 + radius * np.sin(angles)], 1)
    ends = [ring + [0, y, 0] for y in (0.1, SIZE[1] - 0.1)]
    tube = [[k, k + sides, (k + 1) % sides + sides, (k + 1) % sides] for k in range(sides)]
    caps = [list(range(sides)), list(range(2 * sides - 1, sides - 1, -1))]
    return np.concatenate(ends), tube + caps


def furnace() -> az.Scene:
    meshes: dict[str, Mesh] = {
        name: (SIZE * CUBE, [corners[::-1]]) for name, corners in SIDES.items()
    }
    block = np.array([0.7, 0.45, 0.15]) + np.array([1.0, 0.5, 0.3]) * CUBE
    meshes["load"] = block, list(SIDES.values())
    for k in range(HEATERS):
        meshes[f"heater {k}"] = rod((k + 0.5) * SIZE[0] / HEATERS)
    materials = {
        "heater *": az.Material(eps=0.85),
        "load": az.Material(eps=0.75),
        "*": az.Material(eps=0.6),
    }
    return az.Scene(meshes, materials, unit="m")


def main(folder: Path) -> None:
    scene = furnace()
    f = az.form_factors(scene, patches=1500, rays=1024)
    area = dict(zip(scene.names, scene.areas, strict=True))
    heat = az.radiosity(
        f,
        T={"load": LOAD},
        q={"heater *": POWER / area["heater 0"], "*": -LOSS},
    )
    for name in ("heater 0", "heater 1", "vault", "hearth", "load"):
        node = heat[name]
        print(f"{name:9} {node.T - 273.15:6.0f} ± {node.T.std_error:.0f} °C {node.Q / 1e3:8.2f} kW")
    lining = sum(area[name] for name in SIDES)
    print(f"load by the balance {(LOSS * lining - HEATERS * POWER) / 1e3:8.2f} kW")

    figure = plt.figure(figsize=(7.4, 5.2), layout="constrained")
    axis = figure.add_subplot(projection="3d", computed_zorder=True)
    elevation, azimuth = np.radians(24), np.radians(-62)
    viewer = np.array(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.sin(elevation),
        ]
    )
    # Walls whose fronts face away are left out, so that one looks inside.
    shown = np.flatnonzero(f.normals @ viewer > 0)
    polygons = np.split(f.corners, f.corner_offsets[1:-1])
    celsius = heat.T - 273.15
    scale = Normalize(650, celsius.max())
    axis.add_collection3d(
        Poly3DCollection(
            [polygons[k] for k in shown],
            facecolors=plt.colormaps["inferno"](scale(celsius[shown])),
            edgecolors="k",
            linewidths=0.15,
        )
    )
    axis.set(xlim=(0, SIZE[0]), ylim=(0, SIZE[1]), zlim=(0, SIZE[2]))
    axis.set_box_aspect(SIZE, zoom=1.2)
    axis.view_init(elev=np.degrees(elevation), azim=np.degrees(azimuth))
    axis.set_axis_off()
    bar = plt.cm.ScalarMappable(cmap="inferno", norm=scale)
    figure.colorbar(bar, ax=axis, label="°C", shrink=0.7)
    figure.suptitle(
        f"{HEATERS} heaters of {POWER / 1e3:.0f} kW; the load at {LOAD - 273.15:.0f} °C takes up "
        f"{-heat['load'].Q / 1e3:.1f} kW"
    )
    figure.savefig(folder / "furnace.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
