# SPDX-License-Identifier: MIT OR Apache-2.0
"""The operators: bake, and remove what was baked."""

import json
import shutil
import tempfile
import time
from pathlib import Path
from typing import ClassVar

import bpy

from . import result, settings, snapshot
from .job import Job, JobError, find_executable

# Seconds between looks at the child process.
STEP = 0.2
FAILURES = (JobError, snapshot.SnapshotError, result.ResultError)


class Bake:
    """A bake from the export to the result. Until `finish` nothing of the scene changes."""

    def __init__(self, context: bpy.types.Context) -> None:
        """Exports the scene and starts azulejo."""
        self.settings = context.scene.azulejo
        self.is_cancelled = False
        self.is_indirect = self.settings.light == "indirect"
        executable = find_executable(settings.executable(context))
        self.scene = context.scene
        self.folder = Path(tempfile.mkdtemp(prefix="azulejo-", dir=bpy.app.tempdir or None))
        try:
            self.snapshot = snapshot.Export(context, self.settings, self.folder).run()
            self.job = Job(self.snapshot.command(executable, self.settings), self.folder)
        except BaseException:
            self.clean()
            raise

    def finish(self, context: bpy.types.Context) -> list[str]:
        """Brings the result into the scene; returns what there is to tell."""
        try:
            self.job.finish()
            things = result.apply(self.snapshot, self.is_indirect, context)
            report = json.loads(self.job.output.read_text("utf-8"))
            words = [f"{len(things)} objects have baked light" if len(things) != 1 else "1 object has baked light"]
            error = report.get("error")
            if isinstance(error, (int, float)):
                words[0] += f", estimated error {100 * error:.2g}%"
            warnings = [str(w.get("message")) for w in report.get("warnings", []) if isinstance(w, dict)]
            return [*words, *self.snapshot.notes, *warnings]
        finally:
            self.clean()

    def cancel(self) -> None:
        """Ends azulejo, and forgets what it has done."""
        self.job.cancel()
        self.clean()

    def clean(self) -> None:
        """Removes the temporary files."""
        shutil.rmtree(self.folder, ignore_errors=True)


class AZULEJO_OT_bake(bpy.types.Operator):
    """Bake the light of the selected objects into a lightmap with azulejo"""

    bl_idname = "azulejo.bake"
    bl_label = "Bake light with azulejo"
    # Without "REGISTER": "Repeat Last" would bake in `execute`, and Blender's window would not answer.
    bl_options = {"UNDO"}

    # The one bake that goes on while Blender is used.
    running: ClassVar[Bake | None] = None

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there is something to bake."""
        if cls.running:
            cls.poll_message_set("A bake is going on. Esc cancels it")
            return False
        if context.mode != "OBJECT":
            cls.poll_message_set("Needs Object Mode")
            return False
        if not any(thing.type == "MESH" for thing in context.selected_objects):
            cls.poll_message_set("Select mesh objects first")
            return False
        return True

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        """Starts a bake that goes on while Blender is used."""
        try:
            self.bake = Bake(context)
        except FAILURES as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        AZULEJO_OT_bake.running = self.bake
        manager = context.window_manager
        # Not `progress_begin`, which has a number instead of the pointer for minutes.
        self.timer = manager.event_timer_add(STEP, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Looks after the child process."""
        if self.bake.is_cancelled or (event.type == "ESC" and event.value == "PRESS"):
            self.cancel(context)
            self.report({"INFO"}, "The bake was cancelled")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        # Meshes that are being edited cannot get light.
        if self.bake.job.is_running() or context.mode != "OBJECT":
            context.workspace.status_text_set(f"azulejo: {self.bake.job.status()} — Esc cancels")
            redraw_panels(context)
            return {"PASS_THROUGH"}
        self.stop(context)
        return self.end(context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Ends the bake; Blender calls this, too, when it opens another file or quits."""
        self.bake.cancel()
        self.stop(context)

    def stop(self, context: bpy.types.Context) -> None:
        """Gives back the timer and the status bar."""
        AZULEJO_OT_bake.running = None
        redraw_panels(context)
        context.window_manager.event_timer_remove(self.timer)
        context.workspace.status_text_set(None)

    def end(self, context: bpy.types.Context) -> set[str]:
        """Brings in the result of a process that has ended."""
        try:
            words = self.bake.finish(context)
        except FAILURES as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        text, *notes = words
        if not shows_materials(context):
            text += ". Material Preview and Rendered show it"
        for line in notes:
            self.report({"WARNING"}, line)
        # The status bar has room for one report only: the last.
        if len(notes) == 1:
            text += f"; {notes[0]}"
        elif notes:
            text += f"; {len(notes)} warnings: click here"
        self.report({"WARNING" if notes else "INFO"}, text)
        return {"FINISHED"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Bakes and waits, for scripts."""
        try:
            self.bake = Bake(context)
        except FAILURES as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        while self.bake.job.is_running():
            time.sleep(STEP / 4)
        return self.end(context)


class AZULEJO_OT_cancel(bpy.types.Operator):
    """Cancel the bake that is going on; the scene stays as it is"""

    bl_idname = "azulejo.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """Whether there is something to cancel."""
        return AZULEJO_OT_bake.running is not None

    def execute(self, _context: bpy.types.Context) -> set[str]:
        """Tells the operator that looks after the bake."""
        AZULEJO_OT_bake.running.is_cancelled = True
        return {"FINISHED"}


class AZULEJO_OT_remove(bpy.types.Operator):
    """Remove the baked light of the selected objects: their meshes, modifiers and materials are what they were"""

    bl_idname = "azulejo.remove"
    bl_label = "Remove baked light"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Whether there is something to remove."""
        return context.mode == "OBJECT" and any(thing.azulejo.is_baked for thing in context.selected_objects)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Removes it."""
        count = sum(result.remove(thing) for thing in context.selected_objects)
        result.purge()
        self.report({"INFO"}, f"The baked light of {count} object{'s' if count != 1 else ''} was removed")
        return {"FINISHED"}


CLASSES = (AZULEJO_OT_bake, AZULEJO_OT_cancel, AZULEJO_OT_remove)


def viewports(context: bpy.types.Context) -> list[bpy.types.Area]:
    """The 3D viewports of all windows."""
    return [a for window in context.window_manager.windows for a in window.screen.areas if a.type == "VIEW_3D"]


def shows_materials(context: bpy.types.Context) -> bool:
    """Whether a viewport shows materials, and with them baked light; also if there are no viewports."""
    kinds = {area.spaces.active.shading.type for area in viewports(context)}
    return not kinds or bool(kinds & {"MATERIAL", "RENDERED"})


def redraw_panels(context: bpy.types.Context) -> None:
    """Has the sidebars of 3D viewports drawn again."""
    for area in viewports(context):
        for region in area.regions:
            if region.type == "UI":
                region.tag_redraw()


def register() -> None:
    """Registers the operators."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    """Withdraws them; a bake that is going on ends, as Blender forgets its operator."""
    if AZULEJO_OT_bake.running:
        AZULEJO_OT_bake.running.cancel()
        AZULEJO_OT_bake.running = None
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
