# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the user can set, and what objects and materials remember of their state before a bake."""

import os

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .job import JobError, find_executable

# The name of everything that a bake adds: UV map, image, node group, ending of materials.
MARK = "azulejo"


class Preferences(bpy.types.AddonPreferences):
    """Preferences of the add-on: where the program is."""

    bl_idname = __package__

    executable: StringProperty(
        name="Executable",
        description="The program azulejo; if empty, it is looked for on the search path (PATH)",
        subtype="FILE_PATH",
    )

    def draw(self, context: bpy.types.Context) -> None:
        """Shows the one field, and which program is used."""
        self.layout.prop(self, "executable")
        try:
            words, icon = f"Uses {find_executable(executable(context))}", "CHECKMARK"
        except JobError as error:
            words, icon = str(error).split(": ")[0], "ERROR"
        self.layout.label(text=words, icon=icon)


class Settings(bpy.types.PropertyGroup):
    """Settings of a bake, which are saved with the scene."""

    size: IntProperty(
        name="Size",
        description="Width and height of the lightmap in texels",
        default=1024,
        min=16,
        max=16384,
    )
    error: FloatProperty(
        name="Error",
        description="Target error: RMS error of the irradiance as a share of its mean, in percent",
        default=3.0,
        min=0.05,
        max=50.0,
        precision=2,
        subtype="PERCENTAGE",
    )
    rays: IntProperty(
        name="Rays",
        description="Rays per texel instead of a target error; 0: work to the error",
        default=0,
        min=0,
        max=1 << 20,
    )
    light: EnumProperty(
        name="Light",
        items=(
            ("total", "All", "Direct and indirect light; lamps do not light the objects again"),
            ("indirect", "Indirect only", "For EEVEE, where lamps go on giving direct light"),
        ),
    )
    sides: EnumProperty(
        name="Sides",
        items=(
            ("brighter", "Brighter", "The back of a surface if it gets more than twice the light of the front"),
            ("front", "Front", "The side to which normals point"),
        ),
    )
    lamp_shapes: BoolProperty(
        name="Soft shadows",
        description="Point lamps with a radius are spheres; otherwise they are points, which is faster",
        default=True,
    )


class ModifierState(bpy.types.PropertyGroup):
    """Where a modifier was shown before the bake."""

    viewport: BoolProperty()
    render: BoolProperty()


class SlotState(bpy.types.PropertyGroup):
    """What a material slot held before the bake."""

    material: PointerProperty(type=bpy.types.Material)
    link: StringProperty()


class ObjectState(bpy.types.PropertyGroup):
    """What an object was before the bake."""

    is_baked: BoolProperty()
    # Only if the bake gave it a mesh of its own.
    mesh: PointerProperty(type=bpy.types.Mesh)
    modifiers: CollectionProperty(type=ModifierState)
    slots: CollectionProperty(type=SlotState)


class MaterialState(bpy.types.PropertyGroup):
    """The material of which a bake made this copy."""

    is_baked: BoolProperty()
    original: PointerProperty(type=bpy.types.Material)


CLASSES = (Preferences, Settings, ModifierState, SlotState, ObjectState, MaterialState)


def executable(context: bpy.types.Context) -> str:
    """The path of azulejo that the user has set, or an empty text."""
    addon = context.preferences.addons.get(__package__)
    preferences = addon.preferences if addon else None
    path = preferences.executable.strip() if preferences else ""
    return os.path.expanduser(bpy.path.abspath(path)) if path else ""


def uses_nodes(owner: bpy.types.Material | bpy.types.World) -> bool:
    """Whether nodes say what it is: always since Blender 5.0."""
    return owner.node_tree is not None and (bpy.app.version >= (5, 0, 0) or owner.use_nodes)


def original_material(material: bpy.types.Material | None) -> bpy.types.Material | None:
    """The material as it was before any bake."""
    if material is not None and material.azulejo.is_baked:
        return material.azulejo.original
    return material


def register() -> None:
    """Adds the properties to scenes, objects and materials."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.azulejo = PointerProperty(type=Settings)
    bpy.types.Object.azulejo = PointerProperty(type=ObjectState)
    bpy.types.Material.azulejo = PointerProperty(type=MaterialState)


def unregister() -> None:
    """Removes them; what is stored in files stays there."""
    del bpy.types.Material.azulejo
    del bpy.types.Object.azulejo
    del bpy.types.Scene.azulejo
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
