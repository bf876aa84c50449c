"""Lightmaps: a furnace, files, and what the command makes of the same model."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, faces_of_cube

import pyazulejo as az


def furnace() -> az.Scene:
    """In a closed room all of whose walls emit M and reflect ρ, E = M / (1 − ρ)."""
    return az.Scene(faces_of_cube(), az.Material(diffuse=0.5, emission=1 / np.pi))


def test_a_furnace() -> None:
    lightmap = az.bake(furnace(), size=64, error=0.02)
    (page,) = lightmap.pages
    assert page.irradiance.shape == page.std_error.shape == (64, 64, 3)
    assert page.irradiance.dtype == np.float32 and not page.irradiance.flags.writeable
    covered = page.area > 0
    assert covered.sum() == lightmap.report["texels"] > 1000
    assert abs(page.area.sum() - 6) < 1e-4
    assert np.allclose(page.irradiance[covered], 2, rtol=0.1)
    assert np.allclose(lightmap.mean, 2, rtol=0.01)
    assert 0 < lightmap.error < 0.02 and "texels, error" in repr(lightmap)
    assert abs(lightmap.report["energy_error"]) < 0.01


def test_texels_are_chosen_by_number_and_by_density() -> None:
    by_number = az.bake(furnace(), texels=600, error=0.1)
    assert 300 < by_number.report["texels"] < 1200
    by_density = az.bake(furnace(), texels_per_metre=10, error=0.1)
    assert 500 < by_density.report["texels"] < 1000
    direct = az.bake(furnace(), texels=600, light="direct")
    assert np.allclose(direct.mean, 1, rtol=0.02)


def test_a_solved_scene_is_baked_as_if_it_were_dark(tmp_path: Path) -> None:
    dark, lit = furnace(), az.solve_light(furnace(), patches=50, keep_mesh=True)
    files = []
    for name, scene in [("dark.glb", dark), ("lit.glb", lit)]:
        az.bake(scene, size=32, error=0.2).save(tmp_path / name)
        files.append((tmp_path / name).read_bytes())
    assert files[0] == files[1]


def glb(path: Path) -> tuple[dict, bytes]:
    """The JSON of a binary glTF file, and what follows it."""
    file = path.read_bytes()
    end = 20 + int.from_bytes(file[12:16], "little")
    return json.loads(file[20:end]), file[end:]


def test_files_are_those_of_the_command(tmp_path: Path, command: str) -> None:
    """The same glTF but for what the command notes to know a lightmap again; a page has another title."""
    model = ROOT / "examples" / "cornell.grf"
    lightmap = az.bake(az.load(model), size=64, error=0.1)
    for name in ("cornell.glb", "cornell.html"):
        lightmap.save(tmp_path / f"python-{name}")
        options = ["--size", "64", "--error", "10%"]
        subprocess.run(
            [command, "bake", model, "-o", name, *options],
            check=True,
            cwd=tmp_path,
            capture_output=True,
        )
    (mine, bytes_of_mine), (other, bytes_of_other) = (
        glb(tmp_path / name) for name in ("python-cornell.glb", "cornell.glb")
    )
    for file in (mine, other):
        mark = file["asset"]["extras"]["azulejo"]["lightmap"]
        # The hash of the file is that of one with the key of its contents, which only the command has.
        mark.pop("content", None)
        mark.pop("hash")
    assert mine == other and bytes_of_mine == bytes_of_other
    page, same = (
        (tmp_path / name).read_text(encoding="utf-8")
        for name in ("python-cornell.html", "cornell.html")
    )
    assert page.replace(repr(lightmap), "cornell") == same


def test_files_can_be_read_again(tmp_path: Path) -> None:
    lightmap = az.bake(furnace(), size=32, error=0.2)
    lightmap.save(tmp_path / "room.glb")
    again = az.load(tmp_path / "room.glb")
    assert again.is_solved and len(again.names) == 6
    # Its y axis is up.
    view = {"eye": (0.5, 0.5, -0.5), "target": (1, 0.5, -0.5), "size": (8, 8)}
    image = az.render(again, gather=0, **view)
    # Light of 2 is reflected, and the walls emit.
    assert np.allclose(image, (0.5 * 2 + 1) / np.pi, rtol=0.1)
    lightmap.save(tmp_path / "room.html")
    page = (tmp_path / "room.html").read_bytes()
    assert page.startswith(b"<!doctype html>") and b"% of its mean (one standard error)." in page


def test_what_is_refused(cube: az.Scene, tmp_path: Path, refuses) -> None:
    refuses("nothing in the scene emits light", lambda: az.bake(cube))
    scene = furnace()
    refuses("contradict each other", lambda: az.bake(scene, texels=100, texels_per_metre=5))
    refuses("size is 0, expected 1 to 8192", lambda: az.bake(scene, size=0))
    refuses("texels is -1.0, expected more than 0", lambda: az.bake(scene, texels=-1))
    refuses('unknown light "ao"', lambda: az.bake(scene, light="ao"))
    refuses('unknown sides "back"', lambda: az.bake(scene, sides="back"))
    refuses("expected a Scene", lambda: az.bake("room.obj"), TypeError)
    refuses("made by bake", az.Lightmap, TypeError)
    lightmap = az.bake(scene, size=16, error=0.5)
    refuses("is written to .html or .glb", lambda: lightmap.save("room.gltf"))
    for name in ("none/room.glb", "none/room.html"):
        with pytest.raises(FileNotFoundError):
            lightmap.save(tmp_path / name)
