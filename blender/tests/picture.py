# SPDX-License-Identifier: MIT OR Apache-2.0
"""Draws docs/images/blender.jpg: Cycles above, what is shown after a bake below.

python blender/tests/picture.py docs/images/blender.jpg
"""

import sys
import tempfile
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent.parent), str(Path(__file__).parent)]
sys.dont_write_bytecode = True

import azulejo
import bpy
import numpy
import scenes

SIZE = (256, 192)
# Texels, error, sides, exposure.
SCENES = {
    "cornell": (512, 1.0, "brighter", 2.0),
    "daylight": (256, 2.0, "front", 1.6),
    "lamps": (512, 2.0, "brighter", 1.5),
}


def main(path: Path) -> None:
    """Draws all scenes."""
    azulejo.register()
    columns = []
    with tempfile.TemporaryDirectory() as folder:
        for name, (size, error, sides, exposure) in SCENES.items():
            bpy.ops.wm.read_factory_settings(use_empty=True)
            getattr(scenes, name)()
            scenes.select_meshes()
            settings = bpy.context.scene.azulejo
            settings.size, settings.error, settings.sides = size, error, sides
            cycles = scenes.picture(Path(folder) / "cycles.exr", 256, 1, size=SIZE)
            bpy.ops.azulejo.bake()
            ours = scenes.picture(Path(folder) / "ours.exr", 32, 1, bounces=0, size=SIZE)
            columns.append(exposure * numpy.concatenate([ours, cycles]))
    linear = numpy.clip(numpy.concatenate(columns, axis=1), 0, 1)
    encoded = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    height, width, _ = encoded.shape
    image = bpy.data.images.new("picture", width, height)
    image.pixels.foreach_set(numpy.dstack([encoded, numpy.ones((height, width))]).astype(numpy.float32).ravel())
    image.filepath_raw = str(path)
    image.file_format = "PNG" if path.suffix == ".png" else "JPEG"
    image.save(quality=90)
    azulejo.unregister()


main(Path(sys.argv[1]))
