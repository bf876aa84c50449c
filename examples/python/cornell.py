"""The Cornell box: light solved once, then shown from two viewpoints.

python examples/python/cornell.py [folder for the picture]
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import pyazulejo as az


def main(folder: Path) -> None:
    here = Path(__file__).resolve().parent
    scene = az.load(here.parent / "cornell.grf")
    lit = az.solve_light(scene, error=0.03)
    report = lit.report
    assert report is not None
    print(f"{lit}: {report['patches']} patches, error {report['error']:.1%}")
    front = az.render(lit, size=(400, 400))
    eye, target = (60, 480, 60), (330, 120, 400)
    corner = az.render(lit, eye=eye, target=target, fov=65, size=(400, 400))
    figure, axes = plt.subplots(1, 2, figsize=(9, 4.8), layout="constrained")
    for axis, image, title in zip(axes, (front, corner), ("front", "from a corner"), strict=True):
        axis.imshow(az.tone_map(image))
        axis.set_title(title)
        axis.set_axis_off()
    figure.savefig(folder / "cornell.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
