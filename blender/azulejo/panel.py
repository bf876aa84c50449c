# SPDX-License-Identifier: MIT OR Apache-2.0
"""The panel in the sidebar of the 3D viewport, and entries of the menus Object and Render."""

import bpy

from .operators import AZULEJO_OT_bake, AZULEJO_OT_cancel, AZULEJO_OT_remove


class AZULEJO_PT_bake(bpy.types.Panel):
    """Settings and buttons."""

    bl_label = "Bake light with azulejo"
    bl_idname = "AZULEJO_PT_bake"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "azulejo"

    def draw(self, context: bpy.types.Context) -> None:
        """Draws the panel."""
        settings, layout = context.scene.azulejo, self.layout
        layout.use_property_split = True
        # Nothing here is for animation.
        layout.use_property_decorate = False
        layout.prop(settings, "size")
        error = layout.row()
        error.active = settings.rays == 0
        error.prop(settings, "error")
        for name in ("rays", "light", "sides", "lamp_shapes"):
            layout.prop(settings, name)
        bake = AZULEJO_OT_bake.running
        if bake:
            row = layout.row(align=True)
            factor = bake.job.percent / 100 if bake.job.is_running() else 1.0
            row.progress(factor=factor, text=bake.job.status())
            row.operator(AZULEJO_OT_cancel.bl_idname, text="", icon="CANCEL")
        else:
            # Buttons call `invoke`, so that Blender does not wait.
            layout.operator(AZULEJO_OT_bake.bl_idname, icon="LIGHT")
        layout.operator(AZULEJO_OT_remove.bl_idname, icon="X")


def draw_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    """Adds the operators to a menu."""
    self.layout.separator()
    column = self.layout.column()
    column.operator_context = "INVOKE_DEFAULT"
    column.operator(AZULEJO_OT_bake.bl_idname)
    column.operator(AZULEJO_OT_remove.bl_idname)


def menus() -> tuple[type[bpy.types.Menu], ...]:
    """The menus with entries. The end of Object is out of sight in windows of less than 900 pixels in height."""
    return bpy.types.VIEW3D_MT_object, bpy.types.TOPBAR_MT_render


def register() -> None:
    """Registers the panel and the entries."""
    bpy.utils.register_class(AZULEJO_PT_bake)
    for menu in menus():
        menu.append(draw_menu)


def unregister() -> None:
    """Withdraws them."""
    for menu in menus():
        menu.remove(draw_menu)
    bpy.utils.unregister_class(AZULEJO_PT_bake)
