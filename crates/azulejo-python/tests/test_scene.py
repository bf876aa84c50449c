"""Scenes from arrays, other packages' meshes and files."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import FACES, OPPOSITE, ROOT

import pyazulejo as az

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
QUAD = np.array([[0, 1, 2, 3]])


def scene_of(vertices: object, faces: object) -> az.Scene:
    return az.Scene({"a": (vertices, faces)})


def test_what_a_scene_says_of_itself(cube: az.Scene) -> None:
    assert cube.names == tuple(FACES) and cube.areas.tolist() == [1] * 6
    assert cube.faces.tolist() == [1] * 6 and cube.up == "z" and cube.unit is None
    assert cube.bounds.tolist() == [[0, 0, 0], [1, 1, 1]]
    assert not cube.is_solved and cube.report is None and cube.warnings == ()
    mesh = cube.mesh("floor")
    assert mesh.vertices.tolist() == FACES["floor"] and mesh.corners.tolist() == [0, 1, 2, 3]
    assert mesh.corner_offsets.tolist() == [0, 4] and mesh.irradiance is None
    assert repr(cube) == "Scene(6 objects, 6 faces)"


@pytest.mark.parametrize(
    "faces",
    [
        QUAD,
        [[0, 1, 2, 3]],
        [[0, 1, 2], [0, 2, 3]],
        [(0, 1, 2, 3)],
        [[0, 1, 2], [2, 3, 0]],
        QUAD.astype(np.uint8),
        QUAD.astype(np.uint64),
        np.array([[0, 1, 2, 3], [0, 1, 2, 3]], order="F")[:1],
    ],
)
def test_faces_of_all_kinds(faces: object) -> None:
    assert scene_of(SQUARE, faces).areas.tolist() == [1]


def test_polygons_of_any_length() -> None:
    angles = np.linspace(0, 2 * np.pi, 6, endpoint=False)
    hexagon = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    scene = scene_of(hexagon, [[0, 1, 2, 3, 4, 5], [0, 1, 2], [0, 2, 4, 5]])
    assert scene.faces.tolist() == [3]
    assert scene.mesh("a").corner_offsets.tolist() == [0, 6, 9, 13]
    ragged = np.empty(2, dtype=object)
    ragged[:] = [[0, 1, 2], [0, 2, 3, 4]]
    assert scene_of(hexagon, ragged).faces.tolist() == [2]


@pytest.mark.parametrize(
    "vertices",
    [
        SQUARE,
        SQUARE.tolist(),
        SQUARE.astype(np.float32),
        SQUARE.astype(int),
        np.asfortranarray(SQUARE),
        np.repeat(SQUARE, 2, axis=0)[::2],
        SQUARE.astype(">f8"),
    ],
)
def test_vertices_of_all_kinds(vertices: object) -> None:
    assert scene_of(vertices, QUAD).mesh("a").vertices.tolist() == SQUARE.tolist()


def test_arrays_are_copied() -> None:
    vertices = SQUARE.copy()
    vertices.flags.writeable = False
    scene = scene_of(vertices, QUAD)
    vertices = SQUARE.copy()
    scene = scene_of(vertices, QUAD)
    vertices[:] = 7
    assert scene.areas.tolist() == [1]


def test_what_is_refused(refuses) -> None:
    def check(words: str, vertices: object, faces: object, kind: type = az.AzulejoError) -> None:
        refuses(words, lambda: scene_of(vertices, faces), kind)

    check('mesh "a": vertices have the shape (4, 2), expected (n, 3)', SQUARE[:, :2], QUAD)
    check("vertices have the shape (12,)", SQUARE.ravel(), QUAD)
    check("of type complex128, expected numbers", SQUARE + 1j, QUAD)
    check("of type <U1, expected numbers", [["a", "b", "c"]] * 4, QUAD)
    check("lists of different lengths", [[0, 0, 0], [1, 0]], QUAD)
    hole = SQUARE.copy()
    hole[2, 1] = np.nan
    check("vertex 2 is not finite: [1.0, nan, 0.0]", hole, QUAD)
    hole[2, 1] = -np.inf
    check("vertex 2 is not finite", hole, QUAD)
    check("face 0 has the index 4, but there are 4 vertices", SQUARE, [[0, 1, 2, 4]])
    check("face 1 has the index -1, but indices start at 0", SQUARE, [[0, 1, 2], [0, 2, -1]])
    check("face 1 has the index 9, but", SQUARE, [[0, 1, 2, 3], [0, 1, 9]])
    check(f"face 0 has the index {2**32}, but", SQUARE, [[0, 1, 2**32]])
    check(
        f"face 0 has the index {2**64 - 1}, but", SQUARE, np.array([[0, 1, 2**64 - 1]], np.uint64)
    )
    check("faces are of type float64, expected whole numbers", SQUARE, QUAD.astype(float))
    check("faces are of type bool", SQUARE, QUAD.astype(bool))
    check("faces have the shape (1, 2)", SQUARE, [[0, 1]])
    check("faces have the shape (4,)", SQUARE, [0, 1, 2, 3])
    check("face 1 is [0, 1], expected 3 indices or more", SQUARE, [[0, 1, 2], [0, 1]])
    check('mesh "a" has no faces', SQUARE, [])
    check('mesh "a" has no faces', SQUARE, np.empty((0, 3), int))
    check("but there are 0 vertices", np.empty((0, 3)), QUAD)
    refuses('mesh "a" is a str', lambda: az.Scene({"a": "cube"}), TypeError)
    refuses("there are no meshes", lambda: az.Scene({}))
    mesh = (SQUARE, QUAD)
    refuses('two meshes are named "a"', lambda: az.Scene([("a", mesh), ("a", mesh)]))
    refuses("a mesh is named 1, expected a text", lambda: az.Scene({1: mesh}), TypeError)
    refuses("item 0 is a int, expected a pair", lambda: az.Scene([3]), TypeError)
    refuses('unknown up axis "x"', lambda: az.Scene({"a": mesh}, up="x"))
    refuses('unknown unit "parsec"', lambda: az.Scene({"a": mesh}, unit="parsec"))
    refuses("unit is 0.0, expected more than 0", lambda: az.Scene({"a": mesh}, unit=0))


def test_materials(refuses) -> None:
    meshes = {name: (SQUARE, QUAD) for name in ("wall 1", "wall 2", "lamp")}
    grey, lamp = az.Material(diffuse=0.3), az.Material(diffuse=(0.1, 0.2, 0.3), emission=5)
    scene = az.Scene(meshes, {"wall *": grey, "lamp": lamp})
    assert [m.name for m in scene.materials] == ["wall *", "lamp"]
    assert scene.materials[1].diffuse == (0.1, 0.2, 0.3)
    assert scene.materials[1].emission == (5, 5, 5)
    # A name itself counts before a pattern.
    f = az.form_factors(az.Scene(meshes, {"*": grey, "lamp": lamp}), by="material", patch_size=0)
    assert f.names == ("*", "lamp") and f.areas.tolist() == [2, 1]
    refuses('no material for "lamp"', lambda: az.Scene(meshes, {"wall *": grey}))
    refuses('no mesh is named "door"', lambda: az.Scene(meshes, {"door": grey, "*": grey}))
    refuses("expected a Material", lambda: az.Scene(meshes, {"*": 0.5}), TypeError)
    too_much = az.Material(diffuse=0.5, mirror=0.6)
    refuses("exceed 1, which creates energy", lambda: az.Scene(meshes, too_much))
    refuses("expected 0..=1", lambda: az.Scene(meshes, az.Material(diffuse=2)))
    refuses("expected finite numbers", lambda: az.Scene(meshes, az.Material(mirror=-1)))
    refuses("one number or three", lambda: az.Scene(meshes, az.Material(diffuse=(1, 0))))
    model = az.Material(brdf="wardd kd=0.2")
    refuses("no file of that name", lambda: az.Scene(meshes, model))
    both = az.Material(brdf="diffuse kd=0.2", mirror=0.1)
    refuses("takes the place of", lambda: az.Scene(meshes, both))


def test_trimesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box()
    scene = az.Scene({"box": box})
    assert scene.areas.tolist() == [6] and scene.faces.tolist() == [12]
    assert az.Scene(box).names == ("mesh",)


def test_pyvista() -> None:
    pyvista = pytest.importorskip("pyvista")
    plane = pyvista.Plane(i_resolution=2, j_resolution=3)
    mixed = pyvista.PolyData.from_irregular_faces(
        np.vstack([SQUARE, [[0.5, 2, 0]]]), [[0, 1, 2, 3], [3, 2, 4]]
    )
    solid = pyvista.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid()
    flat = pyvista.UnstructuredGrid(
        [4, 0, 1, 2, 3, 3, 3, 2, 4, 1, 0],
        [pyvista.CellType.QUAD, pyvista.CellType.TRIANGLE, pyvista.CellType.VERTEX],
        np.vstack([SQUARE, [[0.5, 2, 0]]]),
    )
    scene = az.Scene({"plane": plane, "mixed": mixed, "solid": solid, "flat": flat})
    assert scene.faces.tolist() == [6, 2, 24, 2]
    assert np.allclose(scene.areas, [1, 1.5, 24, 1.5])
    cube = az.form_factors(az.Scene(solid), patch_size=0)
    assert np.allclose(cube.sky + cube.ground, 1), "its hull does not face outwards"


def test_meshio(refuses) -> None:
    meshio = pytest.importorskip("meshio")
    points = np.vstack([SQUARE, [[0.5, 2, 0]]])
    cells = [("line", [[0, 1]]), ("quad", [[0, 1, 2, 3]]), ("triangle", [[3, 2, 4]])]
    scene = az.Scene({"a": meshio.Mesh(points, cells)})
    assert scene.faces.tolist() == [2] and np.allclose(scene.areas, 1.5)
    groups = meshio.Mesh(
        points,
        cells,
        cell_data={"gmsh:physical": [np.array([1]), np.array([5]), np.array([6])]},
        field_data={"floor": np.array([5, 2]), "roof": np.array([6, 2])},
    )
    assert az.Scene(groups).names == ("floor", "roof")
    solid = meshio.Mesh(points, [("tetra", [[0, 1, 2, 4]])])
    refuses("has cells of type tetra", lambda: az.Scene({"a": solid}))


def test_files(cube_file: Path, tmp_path: Path, refuses) -> None:
    scene = az.load(cube_file)
    assert scene.names == tuple(FACES) and scene.areas.tolist() == [1] * 6
    f = az.form_factors(scene, by="object", patch_size=0)
    assert abs(f["floor", "lid"] - OPPOSITE) < 1e-9
    assert az.load(str(cube_file), up="z").up == "z"
    assert az.load(cube_file, unit="mm").unit == 0.001
    with pytest.raises(FileNotFoundError) as caught:
        az.load(tmp_path / "missing.obj")
    assert caught.value.filename == str(tmp_path / "missing.obj")
    with pytest.raises(IsADirectoryError):
        az.load(tmp_path)
    damaged = tmp_path / "damaged.obj"
    damaged.write_text("v 0 0\nf 1 2 3\n")
    with pytest.raises(az.AzulejoError, match="damaged.obj:1"):
        az.load(damaged)
    picture = tmp_path / "picture.obj"
    picture.write_bytes(b"\x89PNG")
    refuses("found a PNG picture", lambda: az.load(picture))
    refuses('unknown level of detail "best"', lambda: az.load(cube_file, lod="best"))


def test_what_was_skipped_is_a_warning(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("mtllib missing.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.warns(UserWarning, match="missing.mtl"):
        scene = az.load(path)
    assert len(scene.warnings) >= 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        az.load(ROOT / "examples" / "cornell.grf")


def test_objects_that_are_no_mesh(refuses) -> None:
    scene = az.load(ROOT / "examples" / "shapes.grf")
    exact = int(np.flatnonzero(scene.faces == 0)[0])
    refuses("it is exact", lambda: scene.mesh(exact))
    refuses("there is no object", lambda: scene.mesh(1000))
    refuses("no object is named", lambda: scene.mesh("unicorn"))
    assert (scene.areas > 0).all()


def test_two_objects_of_one_name_are_numbered(tmp_path: Path, refuses) -> None:
    path = tmp_path / "a.obj"
    square = "o a\nv 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf -3 -2 -1\no b\nf -3 -2 -1\n"
    path.write_text(square.format(z=0) + square.format(z=1))
    scene = az.load(path)
    assert scene.names == ("a", "b", "a", "b")
    refuses('2 objects are named "a"', lambda: scene.mesh("a"))
    f = az.form_factors(scene, by="object", patch_size=0)
    assert f.names == ("a #0", "b #1", "a #2", "b #3")
