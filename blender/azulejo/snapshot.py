# SPDX-License-Identifier: MIT OR Apache-2.0
"""Writes what a bake needs of the scene as glTF, by way of a temporary scene that is removed again."""

import contextlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import bmesh
import bpy
import numpy
from mathutils import Matrix

from . import lights, materials
from .settings import MARK, Settings

# The attribute of corners that survives in the file: the number of the corner in Blender's mesh.
LOOP = "_LOOP"
# Objects that are only there to cast light and shadow get few texels.
OTHER = "azulejo_other"
OTHER_DENSITY = 0.02
MODEL, RESULT, LIGHTMAP = "scene.gltf", "baked.gltf", "light.exr"
SURFACES = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
# Blender's limit of UV maps of a mesh.
MOST_UV_MAPS = 8


class SnapshotError(Exception):
    """The selection cannot be baked; the text says why."""


@dataclass
class Receiver:
    """An object that gets light."""

    name: str
    node: str
    loops: int


@dataclass
class Snapshot:
    """What was written."""

    folder: Path
    receivers: list[Receiver] = field(default_factory=list)
    uv_set: int = 1
    has_others: bool = False
    options: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def command(self, executable: str, settings: Settings) -> list[str]:
        """The command that bakes it."""
        command = [executable, "bake", str(self.folder / MODEL), "-o", str(self.folder / RESULT)]
        command += ["--lightmap", str(self.folder / LIGHTMAP), "--as", "plain", "--json"]
        command += ["--size", str(settings.size), "--light", settings.light, "--double-sided", settings.sides]
        command += ["--uv-set", str(self.uv_set)]
        command += ["--rays", str(settings.rays)] if settings.rays else ["--error", f"{settings.error:.6g}%"]
        if self.has_others:
            command += ["--density", f"{OTHER}*={OTHER_DENSITY}"]
        return command + self.options


def can_receive(thing: bpy.types.Object) -> str:
    """Why an object cannot get a lightmap; empty if it can."""
    if thing.type != "MESH":
        return "is not a mesh: convert it first"
    if thing.library is not None:
        return "is linked from another file: make it local first"
    if thing.override_library is not None:
        return "is an override of a linked object: make it local first"
    return ""


class Export:
    """The temporary data of one export."""

    def __init__(self, context: bpy.types.Context, settings: Settings, folder: Path) -> None:
        """Prepares an export of the scene of a context."""
        self.context, self.settings = context, settings
        self.snapshot = Snapshot(folder)
        self.lamps = lights.Lamps()
        self.scene = bpy.data.scenes.new("azulejo export")
        self.objects: list[bpy.types.Object] = []
        self.meshes: list[bpy.types.Mesh] = []
        self.materials: dict = {}
        self.kept = {material.name_full for material in bpy.data.materials}
        self.shared: dict = {}

    def note(self, words: str) -> None:
        """Keeps a message for the user."""
        if words not in self.snapshot.notes:
            self.snapshot.notes.append(words)

    def run(self) -> Snapshot:
        """Exports; removes all temporary data whatever happens."""
        try:
            self.gather()
            if not self.snapshot.receivers:
                reasons = "; ".join(self.snapshot.notes)
                raise SnapshotError(f"Nothing to bake: select mesh objects. {reasons}".strip())
            self.write()
            self.snapshot.options += self.lamps.options
            self.snapshot.options += lights.write_world(self.context.scene.world, self.snapshot.folder)
            return self.snapshot
        finally:
            self.clean()

    def gather(self) -> None:
        """Copies what is visible into the temporary scene."""
        scene, selected = self.context.scene, set()
        for thing in self.context.selected_objects:
            why = can_receive(thing) if thing.type in SURFACES else ""
            if why:
                self.note(f"{thing.name} {why}; it only casts light and shadow")
            elif thing.type in SURFACES:
                selected.add(thing.name_full)
        # Asked for once: asking again would compute the scene anew while its instances are being listed.
        depsgraph = self.context.evaluated_depsgraph_get()
        for instance in depsgraph.object_instances:
            thing = instance.object
            source = instance.parent.original if instance.is_instance and instance.parent else thing.original
            if not instance.show_self or source.hide_render or thing.original.hide_render:
                continue
            is_receiver = not instance.is_instance and thing.original.name_full in selected
            if thing.type == "LIGHT":
                lights.add_lamp(
                    self.lamps, thing.data, instance.matrix_world.copy(), self.settings.lamp_shapes, scene, depsgraph
                )
            elif thing.type == "MESH":
                # Curves, texts and metaballs are listed twice: as themselves, and as instances that are meshes.
                self.add_surface(thing, instance.matrix_world.copy(), is_receiver, depsgraph)
            elif thing.type in {"CURVES", "POINTCLOUD", "VOLUME", "GPENCIL", "GREASEPENCIL"}:
                self.note(f"{thing.name} is left out: it has no surface")
        lights.finish_suns(self.lamps)
        for mesh, matrix in self.lamps.meshes:
            self.meshes.append(mesh)
            self.add_object(mesh, matrix, OTHER)
        for words in self.lamps.notes:
            self.note(words)

    def add_surface(
        self, thing: bpy.types.Object, matrix: Matrix, is_receiver: bool, depsgraph: bpy.types.Depsgraph
    ) -> None:
        """Adds one surface, or one instance of it."""
        original = thing.original
        if not is_receiver and not original.visible_shadow:
            # What casts no shadow is not there for light.
            return
        # Instances share their mesh, unless objects give materials of their own.
        slots = [(slot.link, slot.material.name_full if slot.material else None) for slot in thing.material_slots]
        key = (thing.data.as_pointer() if thing.data else 0, str(slots))
        mesh = None if is_receiver else self.shared.get(key)
        if mesh is None:
            if is_receiver:
                mesh = bpy.data.meshes.new_from_object(thing, preserve_all_data_layers=True, depsgraph=depsgraph)
            else:
                # Instances may exist for the length of the list only; Blender 4.2 must not look them up elsewhere.
                mesh = bpy.data.meshes.new_from_object(thing)
            self.meshes.append(mesh)
            self.give_materials(mesh, thing)
            if is_receiver:
                self.prepare(mesh, original)
            else:
                self.shared[key] = mesh
        if not mesh.polygons:
            if is_receiver:
                self.note(f"{original.name} has no faces")
            return
        copy = self.add_object(mesh, matrix, "azulejo_bake" if is_receiver else OTHER)
        if is_receiver:
            self.snapshot.receivers.append(Receiver(original.name, copy.name, int(mesh["azulejo_loops"])))

    def add_object(self, mesh: bpy.types.Mesh, matrix: Matrix, name: str) -> bpy.types.Object:
        """Adds a temporary object."""
        thing = bpy.data.objects.new(f"{name}_{len(self.objects):05}", mesh)
        thing.matrix_world = matrix
        self.scene.collection.objects.link(thing)
        self.objects.append(thing)
        self.snapshot.has_others |= name == OTHER
        return thing

    def give_materials(self, mesh: bpy.types.Mesh, thing: bpy.types.Object) -> None:
        """Gives a mesh the materials that its object shows, as they are to be exported."""
        found = list(mesh.materials)
        for index, slot in enumerate(thing.material_slots):
            if slot.link == "OBJECT" and index < len(found):
                found[index] = slot.material
        originals = [material.original if material else None for material in found or [None]]
        ready = [materials.for_export(material, self.materials, self.snapshot.notes) for material in originals]
        places = numpy.zeros(len(mesh.polygons), numpy.int32)
        mesh.polygons.foreach_get("material_index", places)
        # Clearing the slots sets all faces to the first.
        mesh.materials.clear()
        for material in ready:
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", numpy.clip(places, 0, len(ready) - 1))

    def prepare(self, mesh: bpy.types.Mesh, original: bpy.types.Object) -> None:
        """Makes a mesh that gets light one of triangles, whose corners know which corners they were."""
        if MARK in mesh.uv_layers:
            mesh.uv_layers.remove(mesh.uv_layers[MARK])
        if len(mesh.uv_layers) >= MOST_UV_MAPS:
            raise SnapshotError(f"{original.name} has {MOST_UV_MAPS} UV maps already, and one more is needed")
        self.snapshot.uv_set = max(self.snapshot.uv_set, len(mesh.uv_layers))
        number_corners(mesh)
        mesh["azulejo_loops"] = len(mesh.loops)
        triangulate(mesh)

    def write(self) -> None:
        """Exports the temporary scene, and adds the lamps."""
        path = self.snapshot.folder / MODEL
        # The exporter itself goes from scene to scene of the window, and returns to that of the context, so that an
        # override of the context alone would leave the user in the temporary scene.
        window = self.context.window
        scene, layer = window.scene, window.view_layer
        views = list(camera_views())
        window.scene = self.scene
        try:
            bpy.ops.export_scene.gltf(
                filepath=str(path),
                export_format="GLTF_SEPARATE",
                use_active_scene=True,
                use_visible=False,
                use_selection=False,
                export_yup=True,
                export_apply=False,
                export_attributes=True,
                export_texcoords=True,
                export_normals=True,
                export_tangents=False,
                export_materials="EXPORT",
                export_image_format="AUTO",
                export_lights=False,
                export_cameras=False,
                export_extras=False,
                export_animations=False,
                export_skins=False,
                export_morph=False,
            )
        except (AttributeError, RuntimeError) as error:
            raise SnapshotError(f"Blender's add-on 'glTF 2.0 format' is not enabled, or has failed: {error}") from error
        finally:
            window.scene = scene
            window.view_layer = layer
            # Viewports leave the camera when the scene has none.
            for space, camera, regions in views:
                if space.use_local_camera:
                    space.camera = camera
                for region in regions:
                    region.view_perspective = "CAMERA"
        document = json.loads(path.read_text("utf-8"))
        lights.write_punctual(document, self.lamps.points)
        # Blender's light is in watts, not in lumens.
        document["asset"].setdefault("extras", {})["azulejo"] = {"photometric": False}
        path.write_text(json.dumps(document), "utf-8")

    def clean(self) -> None:
        """Removes all temporary data."""
        bpy.data.scenes.remove(self.scene)
        for thing in self.objects:
            bpy.data.objects.remove(thing)
        for mesh, _matrix in self.lamps.meshes:
            if mesh not in self.meshes:
                self.meshes.append(mesh)
        ours = {material for mesh in self.meshes for material in mesh.materials}
        for mesh in self.meshes:
            bpy.data.meshes.remove(mesh)
        for material in [*ours, *self.materials.values()]:
            with contextlib.suppress(ReferenceError):
                if material and material.name_full not in self.kept:
                    bpy.data.materials.remove(material)


def camera_views() -> Iterator[tuple[bpy.types.SpaceView3D, bpy.types.Object, list[bpy.types.RegionView3D]]]:
    """The viewports that look through a camera: their cameras, and the regions that do."""
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    regions = {space.region_3d, *space.region_quadviews}
                    looking = [region for region in regions if region and region.view_perspective == "CAMERA"]
                    if looking or space.use_local_camera:
                        yield space, space.camera, looking


def number_corners(mesh: bpy.types.Mesh) -> None:
    """Stores the number of each corner with it."""
    old = mesh.attributes.get(LOOP)
    if old:
        mesh.attributes.remove(old)
    layer = mesh.attributes.new(LOOP, "FLOAT", "CORNER")
    # Single precision is exact up to sixteen million corners.
    layer.data.foreach_set("value", numpy.arange(len(mesh.loops), dtype=numpy.float32))


def corner_numbers(mesh: bpy.types.Mesh) -> numpy.ndarray:
    """The stored numbers."""
    numbers = numpy.zeros(len(mesh.loops), numpy.float32)
    mesh.attributes[LOOP].data.foreach_get("value", numbers)
    return numpy.rint(numbers).astype(numpy.int64)


def triangulate(mesh: bpy.types.Mesh, chosen: set[int] | None = None) -> None:
    """Cuts faces into triangles, all or the chosen ones. Corners must be numbered; they keep their normals."""
    normals = None
    if mesh.has_custom_normals:
        normals = numpy.zeros((len(mesh.loops), 3), numpy.float32)
        mesh.corner_normals.foreach_get("vector", normals.ravel())
    solid = bmesh.new()
    solid.from_mesh(mesh)
    faces = [face for face in solid.faces if len(face.verts) > 3 and (chosen is None or face.index in chosen)]
    if faces:
        bmesh.ops.triangulate(solid, faces=faces, quad_method="FIXED", ngon_method="BEAUTY")
        solid.to_mesh(mesh)
    solid.free()
    if faces and normals is not None:
        mesh.normals_split_custom_set(normals[corner_numbers(mesh)])
