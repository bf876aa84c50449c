"""Light: furnaces, closed forms and images."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import FACES, ROOT, faces_of_cube

import pyazulejo as az


def furnace() -> az.Scene:
    """In a closed room all of whose walls emit M and reflect ρ, E = M / (1 − ρ)."""
    return az.Scene(faces_of_cube(), az.Material(diffuse=0.5, emission=1 / np.pi))


def test_a_furnace() -> None:
    lit = az.solve_light(furnace(), patches=100)
    assert lit.is_solved and lit.report is not None and lit.report["error"] < 0.03
    assert abs(lit.report["energy_error"]) < 0.01
    for name in FACES:
        mesh = lit.mesh(name)
        assert mesh.irradiance is not None and mesh.irradiance.shape == mesh.vertices.shape
        assert mesh.std_error is not None
        assert abs(mesh.irradiance.mean() - 2) < 0.05
        assert (abs(mesh.irradiance - 2) < 5 * mesh.std_error).all()
    image = az.render(lit, eye=(0.5, 0.5, 0.5), target=(0.5, 1, 0.5), size=(16, 12), samples=4)
    assert image.shape == (12, 16, 3) and image.dtype == np.float32
    assert np.allclose(image, 2 / np.pi, rtol=0.15)


def test_under_a_uniform_sky() -> None:
    square = (np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2, 3]]))
    scene = az.Scene({"ground": square}, sky=1 / np.pi)
    found = az.probe(scene, [[0.5, 0.5, 0.1], [0.5, 0.5, 5]], [0, 0, 2])
    assert found.value.shape == found.std_error.shape == (2, 3)
    assert np.allclose(found.value, 1, rtol=0.01)
    again = az.probe(scene, [[0.5, 0.5, 0.1], [0.5, 0.5, 5]], [[0, 0, 1], [0, 0, 1]], threads=1)
    assert again.value.tobytes() == found.value.tobytes()


def test_a_reference_needs_no_solution() -> None:
    view = {"eye": (0.5, 0.5, 0.5), "target": (0.5, 1, 0.5), "size": (8, 8)}
    image = az.render(furnace(), reference=True, samples=64, **view)
    assert np.allclose(image, 2 / np.pi, rtol=0.2)
    assert abs(image.mean() - 2 / np.pi) < 0.02


def test_a_file_is_lit_and_shown() -> None:
    scene = az.load(ROOT / "examples" / "cornell.grf")
    image = az.render(scene, size=(24, 24), samples=1)
    shown = az.tone_map(image)
    assert shown.shape == (24, 24, 3) and shown.dtype == np.uint8
    assert 40 < shown.mean() < 220
    darker = az.tone_map(image, exposure=-8, tone="linear")
    assert darker.mean() < shown.mean()


def test_what_is_refused(cube: az.Scene, refuses) -> None:
    refuses("nothing in the scene emits light", lambda: az.solve_light(cube))
    scene = furnace()
    refuses("points have the shape (3,)", lambda: az.probe(scene, [0, 0, 0], [0, 0, 1]))
    refuses("2 normals for 1 points", lambda: az.probe(scene, [[0, 0, 0]], [[0, 0, 1]] * 2))
    refuses("normal 0 is zero", lambda: az.probe(scene, [[0, 0, 0]], [[0, 0, 0]]))
    refuses("row 0 is not finite", lambda: az.probe(scene, [[0, np.nan, 0]], [0, 0, 1]))
    refuses("error is 2.0, expected at most 1", lambda: az.solve_light(scene, error=2))
    refuses('unknown sides "left"', lambda: az.solve_light(scene, sides="left"))
    refuses('unknown camera "door"', lambda: az.render(scene, camera="door", reference=True))
    same = {"eye": (0, 0, 0), "target": (0, 0, 0), "reference": True}
    refuses("the view has no direction", lambda: az.render(scene, **same))
    refuses("width is 0", lambda: az.render(scene, size=(0, 4)))
    refuses("size is 5", lambda: az.render(scene, size=5), TypeError)
    refuses("fov is 180.0", lambda: az.render(scene, fov=180))
    refuses("the shape (3,)", lambda: az.tone_map([0, 0, 0]))
    refuses('unknown tone curve "film"', lambda: az.tone_map(np.zeros((1, 1, 3)), tone="film"))
    with pytest.raises(az.AzulejoError):
        az.render(scene, size=(60_000, 60_000), reference=True)
