# SPDX-License-Identifier: MIT OR Apache-2.0
"""Brings baked light into the scene, and removes it again."""

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy

from . import materials, snapshot
from .gltf_file import GltfFile
from .settings import MARK, original_material

IMAGE_NAME = "azulejo lightmap"


class ResultError(Exception):
    """What was baked does not fit the scene any more."""


@dataclass
class Corners:
    """Coordinates of the triangles of one object: corners (n, 3) and their coordinates (n, 3, 2)."""

    loops: numpy.ndarray
    uv: numpy.ndarray


def read_corners(file: GltfFile, uv_set: int) -> dict[str, Corners]:
    """The coordinates of all nodes that have numbered corners."""
    found = {}
    for node in file.json.get("nodes", []):
        if "mesh" not in node:
            continue
        loops, uv = [], []
        for primitive in file.json["meshes"][node["mesh"]]["primitives"]:
            attributes = primitive["attributes"]
            if snapshot.LOOP not in attributes or f"TEXCOORD_{uv_set}" not in attributes:
                continue
            numbers = numpy.rint(file.array(attributes[snapshot.LOOP])[:, 0]).astype(numpy.int64)
            places = file.array(attributes[f"TEXCOORD_{uv_set}"]).astype(numpy.float32)
            # Rows of pictures are counted from below in Blender.
            places[:, 1] = 1 - places[:, 1]
            if "indices" in primitive:
                order = file.array(primitive["indices"])[:, 0].astype(numpy.int64)
            else:
                order = numpy.arange(len(numbers))
            loops.append(numbers[order].reshape(-1, 3))
            uv.append(places[order].reshape(-1, 3, 2))
        if loops:
            found[node["name"]] = Corners(numpy.concatenate(loops), numpy.concatenate(uv))
    return found


def by_corner(corners: Corners, count: int) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Coordinates of each corner, and the corners that have different ones in different triangles."""
    uv = numpy.zeros((count, 2), numpy.float32)
    loops, places = corners.loops.ravel(), corners.uv.reshape(-1, 2)
    uv[loops] = places
    differs = numpy.abs(uv[loops] - places).max(axis=1) > 1e-6
    return uv, numpy.unique(loops[differs])


def apply(shot: snapshot.Snapshot, is_indirect: bool, context: bpy.types.Context) -> list[bpy.types.Object]:
    """Shows the baked light on the objects that were exported."""
    found = read_corners(GltfFile(shot.folder / snapshot.RESULT), shot.uv_set)
    work = []
    # All meshes are made before anything changes.
    for receiver in shot.receivers:
        thing = context.scene.objects.get(receiver.name)
        if thing is None or receiver.node not in found:
            raise ResultError(f"{receiver.name} was removed or renamed while its light was computed")
        work.append((thing, *new_mesh(thing, context, receiver, found[receiver.node])))
    image = load_image(shot.folder / snapshot.LIGHTMAP)
    group = materials.lightmap_group(image, is_indirect)
    copies: dict = {}
    try:
        for thing, mesh, uv in work:
            remember(thing)
            if mesh is not None:
                replace_mesh(thing, mesh)
            add_coordinates(thing, uv)
            give_materials(thing, group, copies)
    except Exception:
        for thing, _mesh, _uv in work:
            remove(thing)
        raise
    finally:
        purge()
    return [thing for thing, _mesh, _uv in work]


def new_mesh(
    thing: bpy.types.Object, context: bpy.types.Context, receiver: snapshot.Receiver, corners: Corners
) -> tuple[bpy.types.Mesh | None, numpy.ndarray]:
    """The mesh that an object needs to show the light, and the coordinates of its corners.

    There is none if the object's own mesh will do: nothing else uses it, modifiers leave its corners as they are, and
    no chart ends within a face.
    """
    depsgraph = context.evaluated_depsgraph_get()
    evaluated = thing.evaluated_get(depsgraph)
    shown, own = evaluated.data, thing.data
    if len(shown.loops) != receiver.loops:
        raise ResultError(f"{receiver.name} was changed while its light was computed")
    uv, conflicts = by_corner(corners, receiver.loops)
    is_shared = own.users - (1 if own.use_fake_user else 0) > 1 or own.library is not None
    if not is_shared and not len(conflicts) and is_same(shown, own):
        return None, uv
    mesh = bpy.data.meshes.new_from_object(evaluated, preserve_all_data_layers=True, depsgraph=depsgraph)
    mesh.name = f"{own.name.removesuffix(f' ({MARK})')} ({MARK})"
    if len(conflicts):
        uv = cut(mesh, corners, conflicts)
    return mesh, uv


def is_same(a: bpy.types.Mesh, b: bpy.types.Mesh) -> bool:
    """Whether two meshes have the same corners."""
    if (len(a.loops), len(a.polygons)) != (len(b.loops), len(b.polygons)):
        return False
    return all(
        numpy.array_equal(read_integers(getattr(a, what), name), read_integers(getattr(b, what), name))
        for what, name in (("loops", "vertex_index"), ("polygons", "loop_start"))
    )


def read_integers(items: bpy.types.bpy_prop_collection, name: str) -> numpy.ndarray:
    """A property of all items."""
    numbers = numpy.zeros(len(items), numpy.int32)
    items.foreach_get(name, numbers)
    return numbers


def remember(thing: bpy.types.Object) -> None:
    """Notes the state of an object before its first bake."""
    state = thing.azulejo
    if state.is_baked:
        return
    state.is_baked = True
    state.mesh = None
    state.modifiers.clear()
    state.slots.clear()
    for slot in thing.material_slots:
        item = state.slots.add()
        item.material, item.link = slot.material, slot.link


def add_coordinates(thing: bpy.types.Object, uv: numpy.ndarray) -> None:
    """Adds the UV map to the mesh of an object."""
    target = thing.data
    old = target.uv_layers.get(MARK)
    if old:
        target.uv_layers.remove(old)
    # Neither the active map nor the one that is rendered changes.
    active = target.uv_layers.active_index
    layer = target.uv_layers.new(name=MARK, do_init=False)
    if layer is None:
        raise ResultError(f"{thing.name} has no room for another UV map")
    layer.data.foreach_set("uv", uv.ravel())
    if len(target.uv_layers) > 1:
        target.uv_layers.active_index = active
    target.update()


def cut(mesh: bpy.types.Mesh, corners: Corners, conflicts: numpy.ndarray) -> numpy.ndarray:
    """Cuts the faces within which charts end into triangles; returns the coordinates of the new corners."""
    starts = read_integers(mesh.polygons, "loop_start")
    order = numpy.argsort(starts)
    faces = order[numpy.searchsorted(starts[order], conflicts, side="right") - 1]
    snapshot.number_corners(mesh)
    snapshot.triangulate(mesh, set(faces.tolist()))
    numbers = snapshot.corner_numbers(mesh)
    mesh.attributes.remove(mesh.attributes[snapshot.LOOP])
    uv, _ = by_corner(corners, int(max(numbers.max(), corners.loops.max())) + 1)
    result = uv[numbers]
    # Corners of the faces that were cut have their coordinates by triangle.
    known = {}
    chosen = numpy.isin(corners.loops, conflicts).any(axis=1)
    for loops, places in zip(corners.loops[chosen], corners.uv[chosen]):
        for loop, place in zip(loops, places):
            known[(frozenset(loops.tolist()), int(loop))] = place
    for face in mesh.polygons:
        if face.loop_total == 3:
            own = numbers[face.loop_start : face.loop_start + 3]
            triangle = frozenset(own.tolist())
            for index, loop in enumerate(own):
                place = known.get((triangle, int(loop)))
                if place is not None:
                    result[face.loop_start + index] = place
    return result


def replace_mesh(thing: bpy.types.Object, mesh: bpy.types.Mesh) -> None:
    """Gives an object a mesh of its own; the modifiers that are in it rest."""
    state, old = thing.azulejo, thing.data
    links = [(slot.link, slot.material) for slot in thing.material_slots]
    has_own = state.mesh is not None
    if not has_own:
        state.mesh = old
        for modifier in thing.modifiers:
            item = state.modifiers.add()
            item.name, item.viewport, item.render = modifier.name, modifier.show_viewport, modifier.show_render
    thing.data = mesh
    for modifier in thing.modifiers:
        modifier.show_viewport = modifier.show_render = False
    for slot, (link, material) in zip(thing.material_slots, links):
        slot.link = link
        if link == "OBJECT":
            slot.material = material
    if has_own and old.users == 0:
        bpy.data.meshes.remove(old)


def give_materials(thing: bpy.types.Object, group: bpy.types.NodeTree, copies: dict) -> None:
    """Gives an object materials that show the light."""
    if not thing.material_slots:
        thing.data.materials.append(None)
    for slot in thing.material_slots:
        material = original_material(slot.material)
        key = material.name_full if material else None
        if key not in copies:
            copies[key] = materials.showing(material, group)
        slot.material = copies[key]


def load_image(path: Path) -> bpy.types.Image:
    """Loads the lightmap into the file."""
    image = bpy.data.images.load(str(path))
    image.name = IMAGE_NAME
    try:
        image.colorspace_settings.name = "Linear Rec.709"
    except TypeError:
        # A configuration of colours of the user's own may not have it.
        image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "NONE"
    image.pack()
    return image


def remove(thing: bpy.types.Object) -> bool:
    """Gives an object back the state before its first bake; false if it has no baked light."""
    state = thing.azulejo
    if not state.is_baked:
        return False
    mesh = thing.data
    if state.mesh is not None:
        thing.data = state.mesh
        for item in state.modifiers:
            modifier = thing.modifiers.get(item.name)
            if modifier:
                modifier.show_viewport, modifier.show_render = item.viewport, item.render
        state.mesh = None
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)
    else:
        layer = mesh.uv_layers.get(MARK)
        if layer:
            active = mesh.uv_layers.active_index
            mesh.uv_layers.remove(layer)
            mesh.uv_layers.active_index = min(active, len(mesh.uv_layers) - 1)
    if len(state.slots) == 0:
        thing.data.materials.clear()
    for slot, item in zip(thing.material_slots, state.slots):
        # Slots of linked meshes cannot be set, and have not changed.
        if slot.link != item.link:
            slot.link = item.link
        if slot.material != item.material:
            slot.material = item.material
    state.modifiers.clear()
    state.slots.clear()
    state.is_baked = False
    return True


def purge() -> None:
    """Removes materials, node groups and images of bakes that nothing shows any more."""
    for material in [m for m in bpy.data.materials if m.azulejo.is_baked and m.users == 0]:
        bpy.data.materials.remove(material)
    for group in [g for g in bpy.data.node_groups if g.name.startswith(materials.GROUP_NAME) and g.users == 0]:
        bpy.data.node_groups.remove(group)
    for image in [i for i in bpy.data.images if i.name.startswith(IMAGE_NAME) and i.users == 0]:
        bpy.data.images.remove(image)
