"""A baked room in viewers, beside paths from the same camera: pictures, a sheet of them, and what they are off by.

What is missing is left out; playcanvas.png and godot.png are compared if they are in the folder. A radiance of 1 is white.
"""

import http.server
import json
import os
import pathlib
import shutil
import subprocess
import sys
import threading

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent))
import common
import numpy as np
import pages
from PIL import Image, ImageDraw

HERE = pathlib.Path(__file__).parent.resolve()
SCRIPTS = HERE.parents[2] / "crates/azulejo-bake/tests/viewers"
CAMERA = {"eye": [0.4, 1.7, 6.6], "target": [0, 1.45, 0], "up": [0, 1, 0], "vertical_fov": 36, "width": 400, "height": 300}
NAMES = {
    "paths": "azulejo render --reference", "render": "azulejo render", "page": "bake -o PAGE.html", "three": "three.js",
    "babylon": "Babylon.js", "bevy": "Bevy", "playcanvas": "PlayCanvas", "blender": "Blender, emissive",
    "model-viewer": "model-viewer, emissive", "f3d": "f3d, unlit", "godot": "Godot, shader",
}  # fmt: skip


def linear(path):
    """The picture without its encoding, which is x^(1/2.2) in some viewers."""
    x = np.asarray(Image.open(path).convert("RGB"), float) / 255
    return x**2.2 if path.stem in {"playcanvas", "f3d"} else np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def patches(numbers, n=5):
    """Means of 5 × 5 pixels."""
    rows, columns = numbers.shape[0] // n, numbers.shape[1] // n
    return numbers.reshape(rows, n, columns, n, -1).mean((1, 3)).reshape(rows * columns, -1)


def flat(picture):
    """Which patches show one matt surface: no edges nearby, neither white nor black."""
    around = np.pad(picture, ((3, 3), (3, 3), (0, 0)), "edge")
    around = np.lib.stride_tricks.sliding_window_view(around, (7, 7), (0, 1))
    most = picture.max(-1)
    smooth = (np.ptp(around, (-2, -1)) < 0.25 * most[..., None]).all(-1)
    return patches((smooth & (most < 0.97) & (most > 0.004)).astype(float))[:, 0] == 1


def run(name, command, out):
    done = subprocess.run([str(part) for part in command], cwd=out, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{name} is left out: {(done.stderr.strip().splitlines() or ['?'])[-1]}")


def main():
    out = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else common.folder()).resolve()
    for name in ("room.obj", "room.mtl", "cloth.png"):
        shutil.copy(HERE / name, out)
    ours = {"camera": {**CAMERA, "vfov_deg": CAMERA["vertical_fov"]}}
    (out / "camera.json").write_text(json.dumps(CAMERA | ours))
    unlit = ("unlit.glb", "--as", "unlit", "--exposure", 1)
    for file, *more in (("moz.glb",), ("page.html",), ("emissive.glb", "--as", "emissive"), unlit):
        common.azulejo("bake", out / "room.obj", "--size", 512, "--error", "1%", *more, "-o", out / file)
    rendered = ["render", out / "room.obj", "--camera", out / "camera.json", "--exposure", 0, "--tone", "linear"]
    common.azulejo(*rendered, "-o", out / "render.png")
    if not (out / "paths.png").exists():  # Minutes.
        common.azulejo(*rendered, "--reference", "--spp", 1024, "-o", out / "paths.png")
    modules = pathlib.Path(os.environ.get("AZULEJO_VIEWERS", out)) / "node_modules"
    (out / "modules").unlink(missing_ok=True)
    (out / "modules").symlink_to(modules.resolve())
    camera = json.dumps(CAMERA)
    (out / "model-viewer.html").write_text(pages.MODEL_VIEWER.replace("CAMERA", camera))
    quiet = type("Quiet", (http.server.SimpleHTTPRequestHandler,), {"log_message": lambda *_: None})
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), lambda *a: quiet(*a, directory=str(out)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    for name, ready in (("page", pages.OWN.replace("CAMERA", camera)), ("model-viewer", "window.ready")):
        url = f"http://127.0.0.1:{server.server_port}/{name}.html"
        run(name, ["node", HERE / "browse.mjs", url, ready, 400, 300, f"{name}.png"], out)
    for name in ("three", "babylon"):
        options = ["--picture", f"{name}.png", "--tone", "linear", "--exposure", 1]
        run(name, ["node", SCRIPTS / f"{name}.mjs", "moz.glb", "camera.json", *options], out)
    run("bevy", [os.environ.get("AZULEJO_BEVY", "false"), "moz.glb", "camera.json", "bevy.png"], out)
    run("blender", [os.environ.get("AZULEJO_BPY", sys.executable), "-c", pages.BLENDER.replace("CAMERA", camera)], out)
    run("f3d", [os.environ.get("AZULEJO_F3D", sys.executable), "-c", pages.F3D.replace("CAMERA", camera)], out)
    server.shutdown()
    truth, chosen = linear(out / "paths.png"), flat(linear(out / "page.png"))
    expected = patches(truth)[chosen]
    names = [name for name in NAMES if (out / f"{name}.png").exists()]
    sheet = Image.new("RGB", (4 * 276, -(-len(names) // 4) * 222), "white")
    for k, name in enumerate(names):
        off = (patches(linear(out / f"{name}.png"))[chosen] - expected) / expected.max(-1, keepdims=True)
        said = f"{NAMES[name]}: {100 * off.mean():+.1f}%, RMS {100 * np.sqrt((off**2).mean()):.1f}%"
        print(said, f"({100 * off.mean():+.2f}%)")
        place = (276 * (k % 4) + 2, 222 * (k // 4) + 2)
        sheet.paste(Image.open(out / f"{name}.png").convert("RGB").resize((272, 204), Image.LANCZOS), place)
        ImageDraw.Draw(sheet).text((place[0] + 2, place[1] + 206), said if k else NAMES[name], "black")
    palette = sheet.quantize(255, Image.Quantize.MAXCOVERAGE)
    sheet.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(out / "viewers.png", optimize=True)


main()
