"""A radiator of a satellite in the sun: second-surface mirrors, or white paint of the same emissivity.

Both keep the radiator about as cool, but mirrors throw sunlight on the panel beside it, up to a sharp edge.
They are mirrors for sunlight alone; of infrared light they absorb most, and emit as much. So there are two
matrices: one with mirrors, for the solar band, and one without, for the infrared.

python examples/python/satellite.py [folder for the picture]
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

LENGTH, WIDTH, HEIGHT, EDGE = 2.4, 1.2, 1.0, 0.1
"""Of the panel, of both, of the radiator, and of patches, metres."""

SUN, ELEVATION = 1361.0, 30.0
"""Irradiance, W/m², and height above the panel, degrees."""

WASTE = 250.0
"""Heat of the electronics, W/m² of radiator."""

SPACE = 2.7


def grid(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A rectangle from the origin in patches, whose fronts face u × v."""
    n, m = (round(float(np.linalg.norm(w)) / EDGE) for w in (u, v))
    s, t = np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij")
    vertices = s.reshape(-1, 1) * u + t.reshape(-1, 1) * v
    i, j = (index.ravel() for index in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    corner = i * (m + 1) + j
    return vertices, np.stack([corner, corner + m + 1, corner + m + 2, corner + 1], axis=1)


def factors(materials: dict[str, az.Material]) -> az.FormFactors:
    """Of a panel in the plane of x and y, and a radiator at x = 0, with the sun on both."""
    x, y, z = LENGTH * np.eye(3)[0], WIDTH * np.eye(3)[1], HEIGHT * np.eye(3)[2]
    toward = np.array([np.cos(np.radians(ELEVATION)), 0, np.sin(np.radians(ELEVATION))])
    meshes = {"panel": grid(x, y), "radiator": grid(y, z)}
    scene = az.Scene(meshes, materials, sun=(toward, SUN), unit="m")
    return az.form_factors(scene, patch_size=0, rays=2048)


def temperatures(mirror: float) -> tuple[az.FormFactors, az.Radiosity]:
    """With a radiator that reflects this share of sunlight as a mirror; the panel's back is insulated."""
    optics = {
        "radiator": az.Material(eps=0.8, alpha=0.1, rho_s={"solar": mirror}),
        "panel": az.Material(eps=0.8, alpha=0.4),
    }
    infrared = factors({"*": az.Material(eps=0.8)})
    solar = factors({"radiator": az.Material(eps=0.1, rho_s=mirror), "panel": az.Material(eps=0.4)})
    # Each band takes the factors that have its mirrors.
    heat = az.radiosity([infrared, solar], optics, q={"radiator": WASTE, "panel": 0}, space=SPACE)
    return infrared, heat


def main(folder: Path) -> None:
    results = {"white paint": temperatures(0.0), "mirrors": temperatures(0.9)}
    everything = np.concatenate([heat.T for _, heat in results.values()]) - 273.15
    scale = Normalize(-20, everything.max())
    figure = plt.figure(figsize=(11, 4), layout="constrained")
    views = figure.add_gridspec(1, 3, width_ratios=[1, 1, 0.9])
    graph = figure.add_subplot(views[2])
    for k, (name, (f, heat)) in enumerate(results.items()):
        radiator, panel = heat["radiator"], heat["panel"]
        print(
            f"{name:12} radiator {radiator.T - 273.15:6.2f} ± {radiator.T.std_error:.2f} °C, "
            f"panel {panel.T - 273.15:6.2f} ± {panel.T.std_error:.2f} °C, "
            f"{heat.to_sky + heat.to_ground:.0f} W to space"
        )
        axis = figure.add_subplot(views[k], projection="3d", computed_zorder=True)
        celsius = heat.T - 273.15
        axis.add_collection3d(
            Poly3DCollection(
                np.split(f.corners, f.corner_offsets[1:-1]),
                facecolors=plt.colormaps["inferno"](scale(celsius)),
                edgecolors="k",
                linewidths=0.1,
            )
        )
        axis.set(xlim=(0, LENGTH), ylim=(0, WIDTH), zlim=(0, HEIGHT), title=name)
        axis.set_box_aspect((LENGTH, WIDTH, HEIGHT), zoom=1.05)
        axis.view_init(elev=30, azim=-50)
        axis.set_axis_off()
        of_panel = f.object == 0
        places = np.round(f.centroids[of_panel, 0], 6)
        along = np.unique(places)
        graph.plot(along, [celsius[of_panel][places == x].mean() for x in along], label=name)
    bar = plt.cm.ScalarMappable(cmap="inferno", norm=scale)
    figure.colorbar(bar, ax=figure.axes[1:], label="°C", orientation="horizontal", shrink=0.6)
    graph.set(xlabel="distance from the radiator, m", ylabel="panel, °C", xlim=(0, LENGTH))
    graph.axvline(
        HEIGHT / np.tan(np.radians(ELEVATION)),
        color="0.7",
        linewidth=0.8,
        label="edge of the reflection",
    )
    graph.legend(frameon=False)
    figure.savefig(folder / "satellite.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
