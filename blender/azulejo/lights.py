# SPDX-License-Identifier: MIT OR Apache-2.0
"""Lamps and the world of a scene, as azulejo understands them.

Blender's watts are radiant and meant without any conversion: a point lamp of P watts has the radiant intensity P / 4π,
and a surface of area A that emits P watts has the radiance P / πA. The file that goes to azulejo is marked as
radiometric.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

from . import materials, shapes
from .settings import uses_nodes

# From Blender's axes (z up) to those of glTF (y up).
TO_GLTF = Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))
# Discs of about the size of the sun, half a degree wide, can be told to azulejo.
SUN_ANGLES = (math.radians(0.35), math.radians(0.75))
WORLD_SIZE = (1024, 512)
BLACK = (0.0, 0.0, 0.0)


@dataclass
class Lamps:
    """What is written of the lamps of a scene."""

    # Entries of KHR_lights_punctual with the matrices of their nodes.
    points: list[tuple[dict, Matrix]] = field(default_factory=list)
    # Emitting meshes with their places: (mesh, matrix).
    meshes: list[tuple[bpy.types.Mesh, Matrix]] = field(default_factory=list)
    # Options of the command.
    options: list[str] = field(default_factory=list)
    # Suns that may be told by --sun: (direction toward the sun in glTF's axes, colour, angle).
    suns: list[tuple[Vector, tuple, float]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def emission_of(light: bpy.types.Light, notes: list[str]) -> tuple[float, float, float]:
    """Colour times strength: watts, or watts per square metre of a sun."""
    strength = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    colour = [c * strength for c in light.color]
    if getattr(light, "use_temperature", False):
        colour = [c * t for c, t in zip(colour, light.temperature_color)]
    # Since 5.0 every light has nodes; before, they count only if the light says so.
    tree = light.node_tree if getattr(light, "use_nodes", False) else None
    if tree:
        node = next((n for n in tree.nodes if n.type == "EMISSION"), None)
        if node is None or node.inputs["Color"].is_linked or node.inputs["Strength"].is_linked:
            notes.append(f"the nodes of the lamp {light.name} are not understood")
        if node is not None and not node.inputs["Strength"].is_linked:
            colour = [c * node.inputs["Strength"].default_value for c in colour]
        if node is not None and not node.inputs["Color"].is_linked:
            colour = [c * n for c, n in zip(colour, node.inputs["Color"].default_value)]
    return tuple(max(c, 0.0) for c in colour)


def spot_cones(light: bpy.types.SpotLight) -> tuple[float, float]:
    """Half angles of the inner and the outer cone of a spot lamp.

    Cycles lets the light fall off by the smoothstep of the angle's cosine, over a share of the range of cosines; azulejo
    does the same between the cones.
    """
    outer = min(light.spot_size / 2, math.pi / 2)
    edge = math.cos(outer)
    inner = math.acos(min(1.0, edge + (1 - edge) * light.spot_blend))
    return min(inner, outer - 1e-4), outer


def add_lamp(
    lamps: Lamps,
    light: bpy.types.Light,
    matrix: Matrix,
    has_shapes: bool,
    scene: bpy.types.Scene,
    depsgraph: bpy.types.Depsgraph,
) -> None:
    """Adds one lamp, whose node in Blender has this matrix."""
    colour = emission_of(light, lamps.notes)
    if max(colour) <= 0:
        return
    place, turn, scale = matrix.decompose()
    stiff = Matrix.LocRotScale(place, turn, None)
    if light.type == "SUN":
        if not getattr(light, "normalize", True):
            # Then the strength is radiance.
            colour = tuple(c * math.pi * math.sin(light.angle / 2) ** 2 for c in colour)
        lamps.suns.append((turn @ Vector((0, 0, 1)), colour, light.angle))
    elif light.type == "AREA":
        reflectance = colour_behind(scene, depsgraph, stiff, light.size / 2)
        add_area(lamps, light, stiff, scale, colour, reflectance)
    elif light.type == "POINT" and light.shadow_soft_size > 0 and has_shapes:
        mesh = shapes.sphere(light.shadow_soft_size)
        finish_shape(lamps, light, mesh, stiff, colour, BLACK)
    else:
        intensity = [c / (4 * math.pi) for c in colour]
        if not getattr(light, "normalize", True):
            # Then the strength is that of a square metre of the sphere.
            intensity = [i * 4 * math.pi * light.shadow_soft_size**2 for i in intensity]
        entry = punctual(intensity)
        entry["type"] = light.type.lower()
        if light.type == "SPOT":
            inner, outer = spot_cones(light)
            entry["spot"] = {"innerConeAngle": inner, "outerConeAngle": outer}
        lamps.points.append((entry, stiff))


def punctual(colour: list[float] | tuple) -> dict:
    """An entry of KHR_lights_punctual, whose colour is at most 1."""
    peak = max(colour)
    return {"color": [c / peak for c in colour], "intensity": peak}


def add_area(
    lamps: Lamps,
    light: bpy.types.AreaLight,
    stiff: Matrix,
    scale: Vector,
    colour: tuple,
    reflectance: tuple,
) -> None:
    """Adds an area lamp as a surface that emits from its front."""
    width = light.size * abs(scale.x)
    is_long = light.shape in {"RECTANGLE", "ELLIPSE"}
    height = (light.size_y if is_long else light.size) * abs(scale.y)
    if width <= 0 or height <= 0:
        lamps.notes.append(f"the lamp {light.name} has no area")
        return
    if light.spread < math.pi - 1e-3:
        lamps.notes.append(f"the spread of the lamp {light.name} is not known to azulejo: it shines in all directions")
    is_round = light.shape in {"DISK", "ELLIPSE"}
    finish_shape(lamps, light, shapes.sheet(width, height, is_round), stiff, colour, reflectance)


def colour_behind(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, stiff: Matrix, distance: float
) -> tuple[float, float, float]:
    """The colour of the surface close behind a lamp, such as the ceiling; black if there is none.

    In Cycles light passes through lamps; in azulejo they are surfaces. A lamp that reflects as what it covers does
    leaves the light of a room as it would be without it.
    """
    back = (stiff.to_3x3() @ Vector((0, 0, 1))).normalized()
    start = stiff.translation + back * 1e-4
    is_hit, _place, _normal, face, thing, _matrix = scene.ray_cast(depsgraph, start, back, distance=distance)
    if not is_hit or thing.type != "MESH":
        return BLACK
    mesh = thing.evaluated_get(depsgraph).data
    index = mesh.polygons[face].material_index if face < len(mesh.polygons) else 0
    slots = thing.material_slots
    material = slots[index].material if index < len(slots) else None
    return materials.constant_colour(material)


def finish_shape(
    lamps: Lamps, light: bpy.types.Light, mesh: bpy.types.Mesh, stiff: Matrix, colour: tuple, reflectance: tuple
) -> None:
    """Gives a mesh the radiance with which it emits what the lamp does."""
    area = sum(face.area for face in mesh.polygons)
    if not getattr(light, "normalize", True):
        # The strength is then that of one square metre; the mesh of a sphere is a little smaller than the sphere.
        area = 1.0 if light.type == "AREA" else area / (4 * math.pi * light.shadow_soft_size**2)
    radiance = [c / (math.pi * area) for c in colour]
    mesh.materials.append(shapes.glow(radiance, reflectance))
    lamps.meshes.append((mesh, stiff))


def finish_suns(lamps: Lamps) -> None:
    """Decides how suns are told: one white sun of the usual size by an option, others as directions."""
    is_usual = len(lamps.suns) == 1
    for toward, colour, angle in lamps.suns:
        direction = TO_GLTF.to_3x3() @ toward
        is_white = max(colour) - min(colour) < 1e-3 * max(colour)
        if is_usual and is_white and SUN_ANGLES[0] <= angle <= SUN_ANGLES[1]:
            numbers = ",".join(f"{n:.9g}" for n in (*direction, max(colour)))
            lamps.options += ["--sun", f"dir:{numbers}"]
            continue
        if angle > SUN_ANGLES[1]:
            lamps.notes.append(f"shadows of a sun of {math.degrees(angle):.1f}° are sharp")
        entry = punctual(colour)
        entry["type"] = "directional"
        lamps.points.append((entry, toward.to_track_quat("Z", "Y").to_matrix().to_4x4()))


def write_punctual(document: dict, points: list[tuple[dict, Matrix]]) -> None:
    """Adds point, spot and directional lights to a glTF document."""
    if not points:
        return
    used = document.setdefault("extensionsUsed", [])
    if "KHR_lights_punctual" not in used:
        used.append("KHR_lights_punctual")
    lights = document.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
    nodes = document.setdefault("nodes", [])
    scene = document["scenes"][document.get("scene", 0)]
    for entry, matrix in points:
        columns = (TO_GLTF @ matrix).transposed()
        scene.setdefault("nodes", []).append(len(nodes))
        nodes.append(
            {
                "name": f"azulejo_light_{len(lights)}",
                "matrix": [number for column in columns for number in column],
                "extensions": {"KHR_lights_punctual": {"light": len(lights)}},
            }
        )
        lights.append(entry)


def world_colour(world: bpy.types.World) -> tuple[float, float, float] | None:
    """The radiance of a world that is the same in all directions; nothing if it is not."""
    # Before 5.0 a world may have no nodes; after, it always has.
    if not uses_nodes(world):
        return tuple(world.color)
    outputs = [node for node in world.node_tree.nodes if node.type == "OUTPUT_WORLD"]
    outputs.sort(key=lambda node: not node.is_active_output)
    output = outputs[0] if outputs else None
    if output is None or not output.inputs["Surface"].is_linked:
        return (0.0, 0.0, 0.0)
    node = output.inputs["Surface"].links[0].from_node
    if node.type != "BACKGROUND" or node.inputs["Color"].is_linked or node.inputs["Strength"].is_linked:
        return None
    strength = node.inputs["Strength"].default_value
    return tuple(max(0.0, c * strength) for c in node.inputs["Color"].default_value[:3])


def write_world(world: bpy.types.World | None, folder: Path) -> list[str]:
    """Writes the world as a picture of the surroundings; returns the options that name it."""
    if world is None:
        return []
    path = folder / "world.exr"
    colour = world_colour(world)
    if colour is None:
        render_world(world, path)
        options = ["--environment", str(path)]
        if any(n.type == "TEX_SKY" and getattr(n, "sun_disc", False) for n in world.node_tree.nodes):
            options.append("--extract-sun")
        return options
    if max(colour) <= 0:
        return []
    width, height = 64, 32
    image = bpy.data.images.new("azulejo world", width, height, float_buffer=True)
    try:
        # Otherwise the numbers in the file would be encoded as sRGB, although it is an EXR.
        image.colorspace_settings.name = "Non-Color"
        image.pixels.foreach_set([*colour, 1.0] * (width * height))
        image.filepath_raw = str(path)
        image.file_format = "OPEN_EXR"
        image.save()
    finally:
        bpy.data.images.remove(image)
    return ["--environment", str(path)]


def render_world(world: bpy.types.World, path: Path) -> None:
    """Has Cycles draw the world in all directions, whatever its nodes are."""
    scene = bpy.data.scenes.new("azulejo world")
    camera = bpy.data.cameras.new("azulejo world")
    eye = bpy.data.objects.new("azulejo world", camera)
    try:
        scene.collection.objects.link(eye)
        # The middle of the picture is toward +x, its upper end toward +z.
        eye.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
        camera.type = "PANO"
        # Where the kind of panorama is stored differs between versions.
        for holder in (camera, getattr(camera, "cycles", None)):
            if hasattr(holder, "panorama_type"):
                holder.panorama_type = "EQUIRECTANGULAR"
        scene.camera = eye
        scene.world = world
        render = scene.render
        render.engine = "CYCLES"
        render.resolution_x, render.resolution_y = WORLD_SIZE
        render.resolution_percentage = 100
        render.film_transparent = False
        render.use_compositing = False
        render.use_sequencer = False
        render.image_settings.file_format = "OPEN_EXR"
        render.image_settings.color_depth = "32"
        render.filepath = str(path)
        render.use_file_extension = False
        scene.cycles.device = "CPU"
        scene.cycles.samples = 16
        scene.cycles.use_denoising = False
        scene.cycles.use_adaptive_sampling = False
        bpy.ops.render.render(write_still=True, scene=scene.name)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(eye)
        bpy.data.cameras.remove(camera)
