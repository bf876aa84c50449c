"""The published case of a bowl-shaped crater (Ingersoll, Svitek and Murray, Icarus 100, 1992): of a part of a
sphere that a low sun lights in part, all places in shadow have one temperature, which is known. Bands of
sunlight and heat, direct sun with shadows, and reradiation, at three refinements. Needs NumPy."""

import math
import os

from common import SIGMA, azulejo, check, folder, skip

try:
    import numpy as np
except ImportError:
    skip("NumPy is missing (pip install numpy)")

# Share of the sphere, whose radius is 1: a depth of a quarter of the diameter.
SHARE = 0.2
ALBEDO, EPS = 0.12, 0.95
SUN, ELEVATION = 1361.0, math.radians(10)
# Rings and sectors.
MESHES = [(10, 30), (20, 60), (30, 90)]
MOST = 0.3


def known():
    """In K."""
    absorbed = SHARE * (1 - ALBEDO) / (1 - ALBEDO * SHARE) * SUN * math.sin(ELEVATION)
    return (absorbed * (EPS + ALBEDO * (1 - SHARE)) / (EPS * SIGMA)) ** 0.25


def bowl(rings, sectors):
    """Points on the sphere and flat faces that look at its centre; y is up. The bottom is a little deeper,
    so that the innermost faces, too, lean as the sphere does in their middle."""
    last = math.acos(1 - 2 * SHARE)
    first = last / rings
    depth = math.cos(first) + math.sin(first) * math.tan(2 / 3 * first)
    points, faces = [(0.0, -depth, 0.0)], []
    for i in range(1, rings + 1):
        angle = last * i / rings
        radius, height = math.sin(angle), -math.cos(angle)
        turns = [2 * math.pi * k / sectors for k in range(sectors)]
        points += [(radius * math.cos(t), height, -radius * math.sin(t)) for t in turns]
    at = lambda i, k: 1 + (i - 1) * sectors + k % sectors if i else 0
    for i in range(rings):
        for k in range(sectors):
            face = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)]
            faces.append(face if i else face[:3])
    return points, faces


def write_bowl(path, points, faces):
    with open(path, "w") as out:
        out.write("o crater\n")
        out.writelines("v {:.17g} {:.17g} {:.17g}\n".format(*p) for p in points)
        out.writelines("f " + " ".join(str(c + 1) for c in f) + "\n" for f in faces)


def is_shadowed(points):
    """Which points of the bowl have it between them and all of the sun's disc, also between corners."""
    highest = ELEVATION + math.radians(0.5)
    toward = np.array([math.cos(highest), math.sin(highest), 0])
    way = -2 * points @ toward
    hit = points + way[:, None] * toward
    return (way > 0) & (hit[:, 1] < 2 * SHARE - 1)


def temperatures(place, rings, sectors):
    """Of the rows in shadow, and the number of all rows."""
    model, out = os.path.join(place, "crater.obj"), os.path.join(place, "heat.npz")
    points, faces = bowl(rings, sectors)
    write_bowl(model, points, faces)
    tables = {"optics.csv": f"name,eps,alpha\n*,{EPS},{1 - ALBEDO}\n",
              "boundary.csv": "name,T,q\ncrater,,0\nspace,0,\n"}  # fmt: skip
    for name, text in tables.items():
        with open(os.path.join(place, name), "w") as file:
            file.write(text)
    sun = f"dir:{math.cos(ELEVATION)},{math.sin(ELEVATION)},0,{SUN}"
    azulejo("exchange", model, "--materials", os.path.join(place, "optics.csv"), "--boundary",
            os.path.join(place, "boundary.csv"), "--sun", sun, "--patch-size", "0", "--engine", "analytic",
            "-o", out)  # fmt: skip
    corners = is_shadowed(np.array(points))
    in_shadow = np.array([corners[face].all() for face in faces])
    found = np.load(out)["T"]
    check("rows", len(found), len(faces), 0)
    return found[in_shadow], len(faces)


def main():
    truth = known()
    check("the published temperature, K,", truth, 169.608216345369, 1e-9)
    errors = []
    for mesh in MESHES:
        found, rows = temperatures(folder(), *mesh)
        error = abs(found - truth).max()
        errors.append(error)
        print(f"{rows:6} rows, {len(found)} in shadow: {found.min():.4f} to {found.max():.4f} K, "
              f"mean {found.mean():.4f} K, at most {error:.4f} K off")  # fmt: skip
    falling = all(b < a for a, b in zip(errors, errors[1:]))
    check("errors fall with the mesh", float(falling), 1.0, 0)
    check("largest error of the finest, K,", errors[-1], 0.0, MOST)


main()
