"""What the viewers are told: pages and scripts with the camera C in place of CAMERA."""

# The page of `bake -o PAGE.html`: its numbers instead of its picture, which has controls before it.
OWN = """azulejo.ready.then(() => {
    const { eye, target, up, vertical_fov: verticalFov } = CAMERA, [width, height] = [3 * 400, 3 * 300];
    const seen = azulejo.render({ camera: { eye, target, up, verticalFov }, width, height });
    const canvas = Object.assign(document.createElement("canvas"), { width, height }), context = canvas.getContext("2d");
    const encoded = (x) => 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
    const bytes = seen.map((x, k) => (k % 4 === 3 ? 255 : encoded(x)));
    context.putImageData(new ImageData(new Uint8ClampedArray(bytes), width), 0, 0);
    document.documentElement.innerHTML = "<body style='margin: 0'>";
    canvas.style.width = "100vw";
    document.body.append(canvas);
})"""

MODEL_VIEWER = """<!doctype html><script type="module" src="/modules/@google/model-viewer/dist/model-viewer.min.js"></script>
<body style="margin: 0; background: black"><script>
const { eye, target, vertical_fov: fov, width, height } = CAMERA, d = eye.map((x, k) => x - target[k]), r = Math.hypot(...d);
const view = document.createElement("model-viewer");
const settings = { src: "emissive.glb", "tone-mapping": "none", exposure: 1, "shadow-intensity": 0,
    "interaction-prompt": "none", "max-field-of-view": "90deg", "min-camera-orbit": "auto auto 0m",
    "max-camera-orbit": "auto auto 99m", "camera-target": target.map((x) => x + "m").join(" "), "field-of-view": fov + "deg",
    "camera-orbit": `${Math.atan2(d[0], d[2])}rad ${Math.acos(d[1] / r)}rad ${r}m`,
    style: `width: ${width}px; height: ${height}px; background: black` };
Object.entries(settings).forEach(([name, value]) => view.setAttribute(name, value));
window.ready = new Promise((done) => view.addEventListener("load", () => (view.jumpCameraToGoal(), setTimeout(done, 1500))));
document.body.append(view);
</script>"""

BLENDER = """import bpy, math, os; from mathutils import Vector
c = CAMERA; bpy.ops.wm.read_factory_settings(use_empty=True); bpy.ops.import_scene.gltf(filepath="emissive.glb")
s = bpy.context.scene; view = bpy.data.cameras.new("view"); eye = bpy.data.objects.new("view", view); s.collection.objects.link(eye)
view.sensor_fit, view.angle, s.camera = "VERTICAL", math.radians(c["vertical_fov"]), eye
a, b = (Vector((p[0], -p[2], p[1])) for p in (c["eye"], c["target"])); eye.location = a
eye.rotation_euler = (b - a).to_track_quat("-Z", "Y").to_euler()
s.render.engine, s.cycles.samples, s.cycles.max_bounces, s.cycles.use_denoising = "CYCLES", 16, 0, False
s.render.resolution_x, s.render.resolution_y, s.view_settings.view_transform = c["width"], c["height"], "Standard"
s.render.filepath = os.path.abspath("blender.png"); bpy.ops.render.render(write_still=True)"""

F3D = """import f3d
c = CAMERA; engine = f3d.Engine.create(True); engine.window.size = c["width"], c["height"]
engine.options.update({"ui.axis": False, "render.grid.enable": False, "render.background.color": [0, 0, 0]})
engine.scene.add("unlit.glb"); v = engine.window.camera
v.position, v.focal_point, v.view_up, v.view_angle = c["eye"], c["target"], c["up"], c["vertical_fov"]
engine.window.render_to_image().save("f3d.png")"""
