"""A house in the coordinates of a national grid, 5,400 km from the origin: trimesh finds in our files the volume that it
has. Needs the Python packages numpy and trimesh."""

import os

from common import azulejo, check, folder, skip, write_obj

try:
    import numpy as np
    import trimesh
except ImportError:
    skip("trimesh or NumPy is missing (pip install trimesh numpy)")

ORIGIN = (500000.25, 5400000.5, 300.125)
# Corner and size of the walls and of the roof.
BOXES = {
    "south": ((0, 0, 0), (10, 0.3, 3)),
    "north": ((0, 7.7, 0), (10, 0.3, 3)),
    "west": ((0, 0.3, 0), (0.3, 7.4, 3)),
    "east": ((9.7, 0.3, 0), (0.3, 7.4, 3)),
    "roof": ((0, 0, 3), (10, 8, 0.2)),
}
VOLUME = 47.32
# Corners of each side, counter-clockwise as seen from outside.
SIDES = ["000 010 110 100", "001 101 111 011", "000 100 101 001", "010 011 111 110", "000 001 011 010",
         "100 110 111 101"]  # fmt: skip


def box(corner, size):
    def at(word):
        return tuple(o + c + s * int(k) for o, c, s, k in zip(ORIGIN, corner, size, word))

    return [[at(word) for word in side.split()] for side in SIDES]


def volume(mesh):
    """From a corner of the mesh, since the sum from the origin would cancel out."""
    triangles = mesh.triangles - mesh.triangles[0, 0]
    return float(np.einsum("ij,ij->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])) / 6)


def meshes(path):
    scene = trimesh.load(path, process=False)
    return [scene] if isinstance(scene, trimesh.Trimesh) else scene.dump()


def examine(name, path, tolerance, expected=VOLUME):
    found = sum(volume(mesh) for mesh in meshes(path))
    check(f"volume of {name}, m3", found, expected, tolerance)


place = folder()
model = os.path.join(place, "house.obj")
write_obj(model, {name: box(*given) for name, given in BOXES.items()})
upright = ["--place", f"{model}:up=z"]
for extension in ["glb", "gltf", "ply"]:
    path = os.path.join(place, f"house.{extension}")
    azulejo("convert", model, *upright, "-o", path)
    examine(f"house.{extension}", path, 1e-4)
lowest = np.min([mesh.bounds[0] for mesh in meshes(os.path.join(place, "house.glb"))], axis=0)
for axis, expected in enumerate([ORIGIN[0], ORIGIN[2], -ORIGIN[1] - 8]):
    check(f"lowest {'xyz'[axis]} of house.glb, m", float(lowest[axis]), expected, 1e-5)

baked, light = os.path.join(place, "baked.glb"), ["--rays", "4"]
azulejo("bake", model, *upright, "--sky", "1", "--size", "128", *light, "-o", baked)
examine("house.glb with a lightmap", baked, 1e-4)
solved = os.path.join(place, "solved.glb")
azulejo("solve", model, *upright, "--sky", "1", *light, "-o", solved)
examine("house.glb with light on its vertices", solved, 1e-4)

moved = os.path.join(place, "moved.stl")
azulejo("convert", model, "--place", f"{model}:up=z,translate=-500005,-5400005,-302", "-o", moved)
examine("house.stl at its origin", moved, 1e-4)
# What the warning is about: walls of 0.3 m become 0.5 m thick.
stl = os.path.join(place, "house.stl")
azulejo("convert", model, *upright, "-o", stl)
examine("house.stl where it stands", stl, 1e-3, expected=59.126)
