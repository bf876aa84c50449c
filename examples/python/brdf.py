"""Lobes of reflection models in the plane of incidence.

python examples/python/brdf.py [folder for the picture]
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.projections.polar import PolarAxes

import pyazulejo as az

MODELS = {
    "matt": "diffuse kd=0.5",
    "rough soil": "eon rho=0.5 r=1",
    "brushed": "ward_gmd kd=0.3 ks=0.1 ax=0.3 ay=0.3",
    "varnish": "ggx_smith kd=0.3 eta=1.5 ax=0.25",
}


def main(folder: Path) -> None:
    incident = 50.0
    angles = np.linspace(-90, 90, 721)
    figure = plt.figure(figsize=(7, 4.6), layout="constrained")
    axis = figure.add_subplot(projection="polar")
    assert isinstance(axis, PolarAxes)
    for name, model in MODELS.items():
        # Light comes from phi = 180 degrees, so that mirrors would send it to the right.
        values = az.brdf(model, az.directions(incident, 180), az.directions(angles))[:, 1]
        albedo = az.brdf(model, az.directions(incident, 180), quantity="albedo")[1]
        axis.plot(np.radians(angles), values, label=f"{name}: albedo {albedo:.2f}")
    axis.annotate("", (0, 0), (np.radians(-incident), 0.3), arrowprops={"arrowstyle": "->"})
    axis.set_theta_zero_location("N")
    axis.set_theta_direction(-1)
    axis.set_thetalim(-np.pi / 2, np.pi / 2)
    axis.set_title(f"$f_r$ in 1/sr of light from {incident:.0f}°")
    axis.legend(loc="lower center", bbox_to_anchor=(0.5, -0.15), ncols=2, frameon=False)
    figure.savefig(folder / "brdf.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
