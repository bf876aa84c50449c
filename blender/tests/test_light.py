# SPDX-License-Identifier: MIT OR Apache-2.0
"""What is shown after a bake, against Cycles."""

import re

import bpy
import numpy
import pytest
import scenes

BLOCK = 8
# Texels, target error in percent, sides.
CASES = {"cornell": (512, 1.0, "brighter"), "daylight": (256, 2.0, "front"), "lamps": (256, 2.0, "brighter")}


def blocks(image: numpy.ndarray) -> numpy.ndarray:
    """Means of squares of pixels."""
    rows, columns = image.shape[0] // BLOCK, image.shape[1] // BLOCK
    return image.reshape(rows, BLOCK, columns, BLOCK, 3).mean(axis=(1, 3))


@pytest.mark.parametrize("name", CASES)
def test_shown_light_is_that_of_cycles(name, empty, program, tmp_path, capfd):
    """Means of blocks of 8 × 8 pixels differ by no more than the errors of both."""
    getattr(scenes, name)()
    scenes.select_meshes()
    settings = empty.azulejo
    settings.size, settings.error, settings.sides = CASES[name]
    references = [blocks(scenes.picture(tmp_path / f"{seed}.exr", 256, seed)) for seed in (1, 2)]
    reference = (references[0] + references[1]) / 2
    mean = reference.mean()
    noise = numpy.sqrt(((references[0] - references[1]) ** 2).mean()) / 2 / mean

    assert bpy.ops.azulejo.bake() == {"FINISHED"}
    # The report is the only place that has the error that was reached.
    said = re.search(r"estimated error ([0-9.e-]+)%", capfd.readouterr().out)
    stated = float(said[1]) / 100 if said else settings.error / 100
    shown = blocks(scenes.picture(tmp_path / "shown.exr", 32, 3, bounces=0))

    # Where the lamp of the Cornell box hides the ceiling from it, light is missing by intent: see docs/blender.md.
    if name == "cornell":
        shown[-2:, 8:12], reference[-2:, 8:12] = 0, 0
    difference = numpy.sqrt(((shown - reference) ** 2).mean()) / mean
    whole = shown.mean() / reference.mean() - 1
    with capfd.disabled():
        print(
            f"\n{name}: blocks differ by {100 * difference:.2f}% (RMS of the mean), the whole by {100 * whole:+.2f}%; "
            f"stated by azulejo {100 * stated:.2f}%, noise of Cycles {100 * noise:.2f}%"
        )
    assert noise < 0.01
    # What is stated holds for texels; the means of blocks are better.
    assert difference < min(1.5 * numpy.hypot(stated, noise), 0.015)
    assert abs(whole) < 0.01
