# SPDX-License-Identifier: MIT OR Apache-2.0
"""Small scenes, built by script, and pictures of them by Cycles."""

import math
from pathlib import Path

import bpy
import numpy
from mathutils import Vector


def nodes_of(owner) -> bpy.types.NodeTree:
    """The nodes of a material or a world, which do not exist by themselves before Blender 5.0."""
    if bpy.app.version < (5, 0, 0):
        owner.use_nodes = True
    return owner.node_tree


def matt(name: str, colour: tuple, glow: float = 0.0) -> bpy.types.Material:
    """A matt material that may emit white light."""
    material = bpy.data.materials.new(name)
    tree = nodes_of(material)
    node = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    node.inputs["Base Color"].default_value = (*colour, 1)
    node.inputs["Roughness"].default_value = 1
    node.inputs["Specular IOR Level"].default_value = 0
    node.inputs["Emission Color"].default_value = (1, 1, 1, 1)
    node.inputs["Emission Strength"].default_value = glow
    return material


def add_mesh(name: str, points: list, faces: list, *materials: bpy.types.Material) -> bpy.types.Object:
    """A mesh object at the origin."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    for material in materials:
        mesh.materials.append(material)
    return add_object(name, mesh)


def add_object(name: str, data) -> bpy.types.Object:
    """An object in the scene."""
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def box(name: str, low: tuple, high: tuple, *materials: bpy.types.Material) -> bpy.types.Object:
    """A box with normals outward."""
    points = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return add_mesh(name, points, faces, *materials)


def camera(place: tuple, target: tuple, lens: float) -> None:
    """The camera of the scene."""
    data = bpy.data.cameras.new("camera")
    data.lens = lens
    thing = add_object("camera", data)
    thing.location = place
    thing.rotation_euler = (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = thing


def world(colour: tuple, strength: float = 1.0) -> None:
    """A world of one colour."""
    made = bpy.data.worlds.new("world")
    tree = nodes_of(made)
    node = next((n for n in tree.nodes if n.type == "BACKGROUND"), None) or tree.nodes.new("ShaderNodeBackground")
    output = next((n for n in tree.nodes if n.type == "OUTPUT_WORLD"), None) or tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    node.inputs["Color"].default_value = (*colour, 1)
    node.inputs["Strength"].default_value = strength
    bpy.context.scene.world = made


def cornell() -> None:
    """A box of 2 m, open to the camera, with two boxes in it and an area lamp of 20 W under its ceiling."""
    white = matt("white", (0.73, 0.73, 0.73))
    red, green = matt("red", (0.63, 0.06, 0.05)), matt("green", (0.14, 0.45, 0.09))
    points = [(x, y, z) for z in (0, 2) for y in (0, 2) for x in (0, 2)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    walls = add_mesh("walls", points, faces, white, red, green)
    walls.data.polygons.foreach_set("material_index", [0, 0, 0, 1, 2])
    tall = box("tall", (-0.3, -0.3, 0), (0.3, 0.3, 1.2), white)
    tall.location, tall.rotation_euler = (0.7, 1.3, 0), (0, 0, 0.3)
    low = box("low", (-0.3, -0.3, 0), (0.3, 0.3, 0.6), white)
    low.location, low.rotation_euler = (1.35, 0.65, 0), (0, 0, -0.3)
    lamp = bpy.data.lights.new("lamp", "AREA")
    lamp.shape, lamp.size, lamp.size_y, lamp.energy, lamp.color = "RECTANGLE", 0.6, 0.4, 20, (1, 0.9, 0.7)
    add_object("lamp", lamp).location = (1, 1, 1.95)
    camera((1, -3.4, 1), (1, 1, 1), 50)


def daylight() -> None:
    """A room with an opening in one wall, the sun and a blue world; the walls face inward."""
    wall, floor = matt("wall", (0.6, 0.6, 0.6)), matt("floor", (0.5, 0.35, 0.2))
    points = [(x, y, z) for z in (0, 2) for y in (0, 3) for x in (0, 3)]
    faces = [(1, 3, 2, 0), (6, 7, 5, 4), (3, 7, 6, 2), (5, 7, 3, 1)]
    room = add_mesh("room", points, faces, floor, wall)
    room.data.polygons.foreach_set("material_index", [0, 1, 1, 1])
    # The wall at x = 0 has an opening between y = 0.8 and 2.2, z = 0.6 and 1.6.
    corners = [(0, y, z) for y, z in ((0, 0), (3, 0), (3, 2), (0, 2), (0.8, 0.6), (2.2, 0.6), (2.2, 1.6), (0.8, 1.6))]
    add_mesh("window", corners, [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)], wall)
    block = box("block", (-0.4, -0.4, 0), (0.4, 0.4, 0.8), wall)
    block.location = (2, 2, 0)
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle = 4, math.radians(0.526)
    thing = add_object("sun", sun)
    thing.rotation_euler = Vector((-1.2, -0.15, 1)).to_track_quat("Z", "Y").to_euler()
    world((0.3, 0.5, 1.0), 1.0)
    camera((1.7, -3.6, 1.2), (1.6, 1.5, 0.9), 40)


def lamps() -> None:
    """A floor and a wall, a strip that emits, a point and a spot lamp, posts by a modifier, two instances."""
    white, blue = matt("white", (0.7, 0.7, 0.7)), matt("blue", (0.15, 0.25, 0.6))
    add_mesh("floor", [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], [(0, 1, 2, 3)], white)
    add_mesh("wall", [(-2, 2, 0), (2, 2, 0), (2, 2, 2), (-2, 2, 2)], [(0, 1, 2, 3)], white)
    corners = [(-1.5, 1.6, 1.8), (1.5, 1.6, 1.8), (1.5, 1.8, 1.8), (-1.5, 1.8, 1.8)]
    strip = add_mesh("strip", corners, [(3, 2, 1, 0)], matt("strip", (0, 0, 0), 12.0))
    strip.visible_camera = False
    lamp = bpy.data.lights.new("lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size, lamp.color = 60, 0.05, (1, 0.7, 0.4)
    add_object("lamp", lamp).location = (-0.9, -0.9, 1.5)
    spot = bpy.data.lights.new("spot", "SPOT")
    spot.energy, spot.shadow_soft_size, spot.spot_size, spot.spot_blend = 150, 0, math.radians(50), 0.4
    thing = add_object("spot", spot)
    thing.location = (1.2, -1.6, 2)
    thing.rotation_euler = (Vector((1.2, -1.6, 2)) - Vector((0.9, -0.4, 0))).to_track_quat("Z", "Y").to_euler()
    posts = box("posts", (-0.1, -0.1, 0), (0.1, 0.1, 0.7), blue)
    posts.location = (-1.5, 0.6, 0)
    array = posts.modifiers.new("array", "ARRAY")
    array.use_relative_offset, array.use_constant_offset = False, True
    array.constant_offset_displace, array.count = (0.8, 0, 0), 4
    first = box("first", (-0.2, -0.2, 0), (0.2, 0.2, 0.4), blue)
    first.location = (-0.3, -0.3, 0)
    second = add_object("second", first.data)
    second.location, second.rotation_euler, second.scale = (0.5, -1.1, 0), (0, 0, 0.6), (1, -1, 1.5)
    camera((0.4, -5.2, 3), (0, 0.2, 0.5), 45)


def select_meshes() -> None:
    """Selects what can be baked."""
    for thing in bpy.context.scene.objects:
        thing.select_set(thing.type == "MESH")


def picture(path: Path, samples: int, seed: int, bounces: int = 64, size: tuple = (160, 120)) -> numpy.ndarray:
    """A picture by Cycles: radiance, rows from below."""
    scene = bpy.context.scene
    for thing in scene.objects:
        if thing.type == "LIGHT":
            thing.visible_camera = False
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = str(path)
    render.use_file_extension = False
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, seed
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.light_sampling_threshold = 0
    cycles.max_bounces = cycles.diffuse_bounces = bounces
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    pixels = numpy.zeros(size[0] * size[1] * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(size[1], size[0], 4)[..., :3].astype(float)
