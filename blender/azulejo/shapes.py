# SPDX-License-Identifier: MIT OR Apache-2.0
"""Meshes that stand for lamps with a size."""

import math

import bmesh
import bpy

SIDES_OF_DISC = 32


def sheet(width: float, height: float, is_round: bool) -> bpy.types.Mesh:
    """A rectangle or an ellipse around the origin, which faces −z as lamps do."""
    if is_round:
        # The polygon has the area of the ellipse.
        step = 2 * math.pi / SIDES_OF_DISC
        grown = math.sqrt(step / math.sin(step)) / 2
        angles = [i * step for i in range(SIDES_OF_DISC)]
        corners = [(width * grown * math.cos(a), -height * grown * math.sin(a), 0.0) for a in angles]
    else:
        corners = [(x * width / 2, y * height / 2, 0.0) for x, y in ((-1, 1), (1, 1), (1, -1), (-1, -1))]
    mesh = bpy.data.meshes.new("azulejo lamp")
    mesh.from_pydata(corners, [], [tuple(range(len(corners)))])
    return mesh


def sphere(radius: float) -> bpy.types.Mesh:
    """A sphere of few triangles."""
    mesh = bpy.data.meshes.new("azulejo lamp")
    solid = bmesh.new()
    bmesh.ops.create_icosphere(solid, subdivisions=2, radius=radius)
    solid.to_mesh(mesh)
    solid.free()
    return mesh


def glow(radiance: list[float], reflectance: tuple) -> bpy.types.Material:
    """A matt material whose front has this radiance."""
    material = bpy.data.materials.new("azulejo lamp")
    if material.node_tree is None:
        # Before 5.0 a new material has no nodes.
        material.use_nodes = True
    material.use_backface_culling = True
    node = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    peak = max(radiance)
    node.inputs["Base Color"].default_value = (*reflectance, 1)
    node.inputs["Roughness"].default_value = 1
    node.inputs["Specular IOR Level"].default_value = 0
    node.inputs["Emission Color"].default_value = (*(r / peak for r in radiance), 1)
    node.inputs["Emission Strength"].default_value = peak
    return material
