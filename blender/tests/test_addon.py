# SPDX-License-Identifier: MIT OR Apache-2.0
"""What a bake changes and what it leaves, which objects it understands, and how it fails."""

import json
import math
import os
import stat
import subprocess
import sys
import time
import types
import zipfile
from pathlib import Path

import bpy
import numpy
import pytest
import scenes
from azulejo import job, operators, settings

FOLDER = Path(operators.__file__).parent


def state() -> dict:
    """All that could have changed: names of data, and what objects are made of."""
    bpy.context.view_layer.update()
    found = {
        name: sorted(item.name_full for item in getattr(bpy.data, name))
        for name in ("objects", "meshes", "materials", "images", "scenes", "node_groups", "worlds", "lights", "cameras")
    }
    found["scene"] = (bpy.context.scene.name, bpy.context.window.scene.name, bpy.context.view_layer.name)
    found["selected"] = sorted(thing.name for thing in bpy.context.selected_objects)
    for thing in bpy.context.scene.objects:
        mesh = thing.data if thing.type == "MESH" else None
        found[thing.name] = (
            thing.data.name if thing.data else None,
            [tuple(row) for row in thing.matrix_world],
            [(m.name, m.show_viewport, m.show_render) for m in thing.modifiers],
            [(slot.link, slot.material.name if slot.material else None) for slot in thing.material_slots],
            [layer.name for layer in mesh.uv_layers] if mesh else None,
            (mesh.uv_layers.active_index, len(mesh.polygons)) if mesh else None,
            sorted(a.name for a in mesh.attributes) if mesh else None,
            thing.azulejo.is_baked,
        )
    return found


def quick(scene: bpy.types.Scene) -> None:
    """Settings for a bake of seconds."""
    scene.azulejo.size, scene.azulejo.rays = 128, 16
    scenes.select_meshes()


def add_sun() -> None:
    """A sun from above."""
    light = bpy.data.lights.new("sun", "SUN")
    light.energy = math.pi
    scenes.add_object("sun", light)


def light_at(thing: bpy.types.Object, face: int) -> float:
    """The irradiance in the lightmap of an object at the middle of a face of the mesh that it shows."""
    mesh = thing.data
    loops = mesh.polygons[face].loop_indices
    place = numpy.mean([mesh.uv_layers["azulejo"].uv[i].vector for i in loops], axis=0)
    group = next(n for n in thing.material_slots[0].material.node_tree.nodes if n.type == "GROUP").node_tree
    image = next(n for n in group.nodes if n.type == "TEX_IMAGE").image
    width, height = image.size
    pixels = numpy.zeros(width * height * 4, numpy.float32)
    image.pixels.foreach_get(pixels)
    column, row = int(place[0] * width), int(place[1] * height)
    return float(pixels.reshape(height, width, 4)[row, column, :3].mean())


def fake_program(folder: Path, script: str) -> str:
    """A program that does something else than baking."""
    path = folder / "azulejo"
    path.write_text(f"#!{sys.executable}\n{script}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


posix = pytest.mark.skipif(os.name != "posix", reason="scripts as programs need a POSIX system")


def test_removal_restores_everything(empty, program):
    """Baking twice and removing leaves what was there, with modifiers, instances and materials at objects."""
    scenes.lamps()
    shared = scenes.matt("own", (0.2, 0.8, 0.2))
    slot = bpy.data.objects["second"].material_slots[0]
    slot.link, slot.material = "OBJECT", shared
    quick(empty)
    before = state()
    for _ in range(2):
        assert bpy.ops.azulejo.bake() == {"FINISHED"}
        baked = [t for t in empty.objects if t.azulejo.is_baked]
        assert len(baked) == 6
        assert all("azulejo" in t.data.uv_layers for t in baked)
        assert len([i for i in bpy.data.images if i.name.startswith("azulejo")]) == 1
    # Each instance has a mesh and materials of its own kind.
    first, second = bpy.data.objects["first"], bpy.data.objects["second"]
    assert first.data != second.data
    assert second.material_slots[0].link == "OBJECT"
    assert second.material_slots[0].material.azulejo.original == shared
    posts = bpy.data.objects["posts"]
    assert len(posts.data.polygons) == 4 * 6 and not posts.modifiers[0].show_render
    assert bpy.ops.azulejo.remove() == {"FINISHED"}
    assert state() == before


def test_objects_of_all_kinds(empty, program):
    """No coordinates, edges with three faces, loose parts, ngons, mirrored, curves, collections, deformations."""
    add_sun()
    white = scenes.matt("white", (0.5, 0.5, 0.5))
    scenes.add_mesh("floor", [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [(0, 1, 2, 3)], white)
    # Three faces at one edge, an edge and a vertex without faces.
    points = [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1), (1, -1, 1.5), (0, -1, 1.5), (0, 0, 2), (1, 0, 2), (5, 5, 5)]
    mesh = bpy.data.meshes.new("fins")
    mesh.from_pydata(points, [(7, 8)], [(0, 1, 2, 3), (0, 5, 4, 1), (0, 1, 7, 6)])
    scenes.add_object("fins", mesh)
    disc = [(3 + math.cos(i * math.pi / 4), math.sin(i * math.pi / 4), 0.5) for i in range(8)]
    scenes.add_mesh("ngon", disc, [tuple(range(8))]).scale = (-1, 1, 1)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=8, radius=0.5, location=(0, 4, 2))
    bpy.context.object.name = "ball"
    bpy.ops.mesh.primitive_cube_add(size=1, location=(-4, 0, 1))
    cube = bpy.context.object
    cube.name = "bent"
    cube.modifiers.new("bend", "SIMPLE_DEFORM").angle = 0.2
    cube.shape_key_add(name="Basis")
    curve = bpy.data.curves.new("curve", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.1
    curve.splines.new("POLY").points.add(3)
    for index, point in enumerate(curve.splines[0].points):
        point.co = (index, -4, 1, 1)
    scenes.add_object("curve", curve)
    group = bpy.data.collections.new("group")
    group.objects.link(scenes.box("inner", (-1, -1, 0), (1, 1, 1)))
    empty.collection.objects.unlink(bpy.data.objects["inner"])
    instance = scenes.add_object("instance", None)
    instance.instance_type, instance.instance_collection, instance.location = "COLLECTION", group, (-5, -5, 2)
    saddle = [(6, 0, 1), (7, 0, 2), (7, 1, 1), (6, 1, 2), (8, 0, 2), (8, 1, 1)]
    scenes.add_mesh("saddle", saddle, [(0, 1, 2, 3), (1, 4, 5, 2)], white)
    scenes.add_mesh("nothing", [(0, 0, 0)], [])
    quick(empty)
    bpy.data.objects["curve"].select_set(True)
    before = state()
    assert bpy.ops.azulejo.bake() == {"FINISHED"}
    baked = {t.name for t in empty.objects if t.azulejo.is_baked}
    assert baked == {"floor", "fins", "ngon", "ball", "bent", "saddle"}
    # The light is on the object's own mesh, unless a chart ends within a face, which is cut for it.
    assert bpy.data.objects["floor"].azulejo.mesh is None
    saddle = bpy.data.objects["saddle"]
    assert saddle.azulejo.mesh is not None
    assert sorted(len(face.vertices) for face in saddle.data.polygons) == [3, 3, 4]
    assert light_at(bpy.data.objects["ngon"], 0) == pytest.approx(math.pi, rel=0.1)
    assert light_at(bpy.data.objects["fins"], 0) == pytest.approx(math.pi, rel=0.1)
    # Every face has texels of its own.
    for mesh in (bpy.data.objects["ball"].data, saddle.data):
        uv = numpy.array([mesh.uv_layers["azulejo"].uv[i].vector for i in range(len(mesh.loops))])
        assert 0 <= uv.min() and uv.max() <= 1
        for face in mesh.polygons:
            a, b, c = (uv[i] for i in list(face.loop_indices)[:3])
            area = abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])
            assert 1e-8 < area < 0.02
    scenes.select_meshes()
    bpy.ops.azulejo.remove()
    bpy.data.objects["curve"].select_set(True)
    assert state() == before


def test_linked_meshes(empty, program, tmp_path):
    """A local object with a mesh of a library gets one of its own; a linked object is left alone."""
    scenes.box("cube", (-1, -1, 0), (1, 1, 1), scenes.matt("white", (0.5, 0.5, 0.5)))
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {bpy.data.objects["cube"]})
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, target):
        target.objects, target.meshes = ["cube"], ["cube"]
    linked = target.objects[0]
    bpy.context.scene.collection.objects.link(linked)
    local = scenes.add_object("local", target.meshes[0])
    local.location = (4, 0, 0)
    add_sun()
    quick(bpy.context.scene)
    before = state()
    assert bpy.ops.azulejo.bake() == {"FINISHED"}
    assert not linked.azulejo.is_baked and local.azulejo.is_baked
    assert local.data.library is None and light_at(local, 1) == pytest.approx(math.pi, rel=0.02)
    scenes.select_meshes()
    bpy.ops.azulejo.remove()
    assert state() == before


def test_worlds(empty, program):
    """A world of one colour, and one of nodes that only Cycles can draw: bright above +x of Blender."""
    scenes.add_mesh("up", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])
    scenes.add_mesh("toward", [(0, -9, 0), (0, -7, 0), (0, -7, 2), (0, -9, 2)], [(0, 1, 2, 3)])
    scenes.world((0.2, 0.2, 0.2), 2)
    quick(empty)
    empty.azulejo.sides, empty.azulejo.rays = "front", 256
    assert bpy.ops.azulejo.bake() == {"FINISHED"}
    # A uniform radiance of 0.4 on an open surface.
    assert light_at(bpy.data.objects["up"], 0) == pytest.approx(0.4 * math.pi, rel=0.03)
    nodes, links = empty.world.node_tree.nodes, empty.world.node_tree.links
    place, axes = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeSeparateXYZ")
    links.new(place.outputs["Generated"], axes.inputs[0])
    background = next(n for n in nodes if n.type == "BACKGROUND")
    # Radiance of max(x, 0): an irradiance of 2π/3 on what faces +x, and of 2/3 on what faces up.
    links.new(axes.outputs["X"], background.inputs["Strength"])
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    assert bpy.ops.azulejo.bake() == {"FINISHED"}
    assert light_at(bpy.data.objects["toward"], 0) == pytest.approx(2 * math.pi / 3, rel=0.05)
    assert light_at(bpy.data.objects["up"], 0) == pytest.approx(2 / 3, rel=0.05)


def test_materials(empty, program):
    """Diffuse BSDF, no material, a picture and a metal: what is exported, and what is shown of it."""
    add_sun()
    diffuse, metal, pictured = (scenes.matt(name, (0.1, 0.2, 0.3)) for name in ("diffuse", "metal", "pictured"))
    tree = diffuse.node_tree
    node = tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (0.3, 0.2, 0.1, 1)
    tree.links.new(node.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])
    next(n for n in metal.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Metallic"].default_value = 1
    image = bpy.data.images.new("picture", 4, 4)
    image.pack()
    texture = pictured.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    principled = next(n for n in pictured.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    pictured.node_tree.links.new(texture.outputs["Color"], principled.inputs["Base Color"])
    things = {}
    for index, material in enumerate((diffuse, metal, pictured, None)):
        points = [(x + 3 * index, y, 0) for x, y in ((0, 0), (2, 0), (2, 2), (0, 2))]
        name = material.name if material else "none"
        things[name] = scenes.add_mesh(name, points, [(0, 1, 2, 3)], *([material] if material else []))
        for _ in range(2):
            things[name].data.uv_layers.new()
    quick(empty)
    bake = operators.Bake(bpy.context)
    written = json.loads((bake.folder / "scene.gltf").read_text())
    bake.finish(bpy.context)
    surfaces = {}
    for node in written["nodes"]:
        for primitive in written["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            material = written["materials"][primitive["material"]]
            surfaces[material["name"].split(".")[0]] = material["pbrMetallicRoughness"]
    assert surfaces["diffuse"]["baseColorFactor"] == pytest.approx([0.3, 0.2, 0.1, 1])
    assert surfaces["diffuse"]["metallicFactor"] == 0
    assert surfaces["azulejo none"]["baseColorFactor"][0] == pytest.approx(0.8)
    assert "baseColorTexture" in surfaces["pictured"]
    # The coordinates of the lightmap come after those that were there.
    assert bake.snapshot.uv_set == 2

    def shown(name: str, what: str) -> bpy.types.NodeSocket:
        tree = things[name].material_slots[0].material.node_tree
        return next(n for n in tree.nodes if n.type == "GROUP").inputs[what]

    assert tuple(shown("diffuse", "Base Color").default_value)[:3] == pytest.approx((0.3, 0.2, 0.1))
    assert shown("metal", "Metallic").default_value == 1
    assert shown("pictured", "Base Color").is_linked
    assert shown("none", "Base Color").default_value[0] == pytest.approx(0.8)
    assert things["none"].data.uv_layers.active_index == 0
    assert light_at(things["pictured"], 0) == pytest.approx(math.pi, rel=0.02)


def test_indirect_light_is_added(empty, program):
    """With indirect light alone, the surface stays; an open floor has none."""
    add_sun()
    floor = scenes.add_mesh("floor", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])
    quick(empty)
    empty.azulejo.light = "indirect"
    assert bpy.ops.azulejo.bake() == {"FINISHED"}
    assert light_at(floor, 0) < 0.01
    tree = floor.material_slots[0].material.node_tree
    group = next(n for n in tree.nodes if n.type == "GROUP")
    assert group.inputs["Surface"].is_linked
    assert any(n.type == "ADD_SHADER" for n in group.node_tree.nodes)


def test_missing_program(empty, monkeypatch, tmp_path):
    """A message says what to do, and nothing has changed."""
    add_sun()
    scenes.box("cube", (-1, -1, 0), (1, 1, 1))
    quick(empty)
    before = state()
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(job, "PLACES", (str(tmp_path / "bin"),))
    with pytest.raises(RuntimeError, match="search path"):
        bpy.ops.azulejo.bake()
    monkeypatch.setattr(settings, "executable", lambda _context: "/nowhere/azulejo")
    with pytest.raises(RuntimeError, match="/nowhere/azulejo is not there"):
        bpy.ops.azulejo.bake()
    monkeypatch.setattr(settings, "executable", lambda _context: str(tmp_path))
    with pytest.raises(RuntimeError, match="is not a program that can be run"):
        bpy.ops.azulejo.bake()
    assert state() == before


@posix
def test_failing_program(empty, monkeypatch, tmp_path):
    """The last words of the program are shown, and nothing has changed."""
    add_sun()
    scenes.box("cube", (-1, -1, 0), (1, 1, 1))
    quick(empty)
    path = fake_program(tmp_path, "import sys; print('error: no room on the page', file=sys.stderr); sys.exit(3)")
    monkeypatch.setattr(settings, "executable", lambda _context: path)
    before = state()
    with pytest.raises(RuntimeError, match="exit code 3(.|\n)*no room on the page"):
        bpy.ops.azulejo.bake()
    assert state() == before


class Window:
    """Plays the part of Blender's window for a bake that goes on while Blender is used."""

    def __init__(self, scene: bpy.types.Scene) -> None:
        """Notes what the bake asks for in `calls`."""
        self.calls: list = []
        manager = types.SimpleNamespace(
            windows=[],
            event_timer_add=lambda step, window: self.calls.append("timer"),
            event_timer_remove=lambda timer: self.calls.append("no timer"),
            modal_handler_add=lambda operator: None,
        )
        self.context = types.SimpleNamespace(
            scene=scene,
            mode="OBJECT",
            window=bpy.context.window,
            preferences=bpy.context.preferences,
            selected_objects=bpy.context.selected_objects,
            evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
            window_manager=manager,
            workspace=types.SimpleNamespace(status_text_set=lambda words: self.calls.append(words)),
        )
        self.operator = types.SimpleNamespace(report=lambda kind, words: self.calls.append(words))
        for name in ("stop", "end", "cancel"):
            method = types.MethodType(getattr(operators.AZULEJO_OT_bake, name), self.operator)
            setattr(self.operator, name, method)

    def invoke(self) -> set[str]:
        """The click on the button."""
        return operators.AZULEJO_OT_bake.invoke(self.operator, self.context, None)

    def event(self, kind: str, value: str = "NOTHING") -> set[str]:
        """Something that happens in the window."""
        event = types.SimpleNamespace(type=kind, value=value)
        return operators.AZULEJO_OT_bake.modal(self.operator, self.context, event)


@posix
@pytest.mark.parametrize("way", ["Esc", "button", "quit", "disable"])
def test_cancel(empty, monkeypatch, tmp_path, way):
    """Esc, the button, the end of Blender and of the add-on end the program and leave the scene as it was."""
    add_sun()
    scenes.lamps()
    quick(empty)
    bar = "      irradiance [=====>     ]  42%  1/s, 3s left"
    script = f"import sys, time\nprint('{bar}', file=sys.stderr, flush=True)\ntime.sleep(60)"
    path = fake_program(tmp_path, script)
    monkeypatch.setattr(settings, "executable", lambda _context: path)
    before = state()
    window = Window(empty)
    calls = window.calls
    assert window.invoke() == {"RUNNING_MODAL"}
    folder, process = window.operator.bake.folder, window.operator.bake.job.process
    for _ in range(100):
        assert window.event("TIMER") == {"PASS_THROUGH"}
        if "irradiance 42%" in str(calls[-1]):
            break
        time.sleep(0.05)
    assert "irradiance 42%" in calls[-1]
    assert window.event("MOUSEMOVE") == {"PASS_THROUGH"}
    # A second click would start a second bake.
    assert not bpy.ops.azulejo.bake.poll()
    if way == "Esc":
        assert window.event("ESC", "PRESS") == {"CANCELLED"}
    elif way == "button":
        assert bpy.ops.azulejo.cancel() == {"FINISHED"}
        assert window.event("TIMER") == {"CANCELLED"}
    elif way == "quit":
        # What Blender calls then, and when it opens another file.
        window.operator.cancel(window.context)
    else:
        operators.unregister()
        operators.register()
    assert process.poll() is not None and not folder.exists()
    if way != "disable":
        # The status bar is Blender's again.
        assert None in calls
    assert state() == before
    assert bpy.ops.azulejo.bake.poll() and not bpy.ops.azulejo.cancel.poll()


def test_edit_mode(empty, program):
    """A bake that ends in Edit Mode waits: meshes that are being edited cannot get light."""
    add_sun()
    cube = scenes.box("cube", (-1, -1, 0), (1, 1, 1))
    quick(empty)
    window = Window(empty)
    assert window.invoke() == {"RUNNING_MODAL"}
    window.context.view_layer, window.context.mode = bpy.context.view_layer, "EDIT_MESH"
    window.operator.bake.job.process.wait()
    assert window.event("TIMER") == {"PASS_THROUGH"}
    assert "waits for Object Mode" in window.calls[-1]
    assert not cube.azulejo.is_baked
    window.context.mode = "OBJECT"
    assert window.event("TIMER") == {"FINISHED"}
    assert cube.azulejo.is_baked
    # The last report is the one that Blender shows.
    assert window.calls[-1].startswith("1 object has baked light")


@pytest.mark.parametrize("notes", [[], ["one"], ["one", "two"]])
@pytest.mark.parametrize("shading", ["SOLID", "MATERIAL"])
def test_last_report(notes, shading):
    """The last report, which is the one that Blender shows, says where light is seen and that there are warnings."""
    view = types.SimpleNamespace(shading=types.SimpleNamespace(type=shading))
    area = types.SimpleNamespace(type="VIEW_3D", spaces=types.SimpleNamespace(active=view))
    screen = types.SimpleNamespace(areas=[area, types.SimpleNamespace(type="OUTLINER")])
    manager = types.SimpleNamespace(windows=[types.SimpleNamespace(screen=screen)])
    reports: list = []
    operator = types.SimpleNamespace(
        bake=types.SimpleNamespace(finish=lambda _context: ["Light", *notes]),
        report=lambda kind, words: reports.append((*kind, words)),
    )
    context = types.SimpleNamespace(window_manager=manager)
    assert operators.AZULEJO_OT_bake.end(operator, context) == {"FINISHED"}
    words = "Light" + (". Material Preview and Rendered show it" if shading == "SOLID" else "")
    words += ["", "; one", "; 2 warnings: click here"][len(notes)]
    assert reports == [*(("WARNING", note) for note in notes), ("WARNING" if notes else "INFO", words)]


def test_camera_view_stays(empty, program):
    """Viewports that look through a camera, which may be their own, go on doing so."""
    bpy.ops.wm.read_factory_settings()
    space = next(area.spaces.active for area in bpy.context.window.screen.areas if area.type == "VIEW_3D")
    space.region_3d.view_perspective = "CAMERA"
    other = scenes.add_object("other", bpy.data.cameras.new("other"))
    quick(bpy.context.scene)
    for camera in (None, other):
        space.use_local_camera = camera is not None
        space.camera = camera or space.camera
        before = space.camera
        assert bpy.ops.azulejo.bake() == {"FINISHED"}
        assert (space.region_3d.view_perspective, space.camera) == ("CAMERA", before)


@posix
def test_program_off_the_search_path(monkeypatch, tmp_path):
    """What `cargo install` has put into the home folder is found by a Blender that was started from a menu."""
    folder = tmp_path / ".cargo" / "bin"
    folder.mkdir(parents=True)
    path = fake_program(folder, "")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    assert job.find_executable("") == path


def test_home_in_path(monkeypatch):
    """A tilde in the path of the program is the home folder, as in shells."""
    preferences = types.SimpleNamespace(executable=" ~/bin/azulejo")
    addons = {settings.__package__: types.SimpleNamespace(preferences=preferences)}
    context = types.SimpleNamespace(preferences=types.SimpleNamespace(addons=addons))
    monkeypatch.setenv("HOME", "/home/someone")
    monkeypatch.setenv("USERPROFILE", "/home/someone")
    assert Path(settings.executable(context)) == Path("/home/someone/bin/azulejo")


def test_numpy_is_missing(tmp_path):
    """A Blender without NumPy, as Debian's, says what to install."""
    script = (
        "import importlib.util, sys\n"
        "find = importlib.util.find_spec\n"
        "importlib.util.find_spec = lambda name, *rest: None if name == 'numpy' else find(name, *rest)\n"
        f"sys.path.insert(0, {str(FOLDER.parent)!r})\n"
        "import azulejo\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert "python3-numpy" in run.stderr.splitlines()[-1]


def test_nothing_selected(empty, program):
    """Without meshes there is nothing to bake."""
    add_sun()
    assert not bpy.ops.azulejo.bake.poll()


def test_progress_is_read():
    """Lines of the bar, as azulejo draws it."""
    bar = job.BAR.match("    shadow edges [===>                          ]  17%  120/s, 5s left")
    assert bar and (bar["stage"], bar["percent"]) == ("shadow edges", "17")


def test_installs_as_extension(tmp_path):
    """Blender itself takes the folder as an extension, and can enable it. In a process of its own."""
    archive = tmp_path / "azulejo.zip"
    with zipfile.ZipFile(archive, "w") as pack:
        for path in sorted(FOLDER.rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                pack.write(path, path.relative_to(FOLDER).as_posix())
    script = (
        "import sys, bpy\n"
        "bpy.ops.preferences.addon_enable(module='bl_pkg')\n"
        "bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo='user_default', enable_on_install=True)\n"
        "print('found', [k for k in bpy.context.preferences.addons.keys() if 'azulejo' in k])\n"
        "addon = bpy.context.preferences.addons['bl_ext.user_default.azulejo']\n"
        "addon.preferences.executable = '/x/azulejo'\n"
        "from bl_ext.user_default.azulejo import settings\n"
        "print('path', settings.executable(bpy.context), hasattr(bpy.types, 'AZULEJO_PT_bake'))\n"
    )
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path / "user")}
    run = subprocess.run(
        [sys.executable, "-c", script, str(archive)], capture_output=True, text=True, env=environment, timeout=120
    )
    assert "path /x/azulejo True" in run.stdout, run.stdout + run.stderr
