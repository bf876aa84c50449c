"""Matrices: closed forms, balances, buffers, and the bytes of the command."""

from __future__ import annotations

import pickle
import subprocess
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from conftest import OPPOSITE, ROOT, faces_of_cube

import pyazulejo as az

scipy_sparse = pytest.importorskip("scipy.sparse")


def test_the_faces_of_a_cube(cube: az.Scene) -> None:
    f = az.form_factors(cube, by="object", patch_size=0)
    assert f.names == tuple(faces_of_cube())
    assert abs(f["floor", "lid"] - OPPOSITE) < 1e-9
    assert abs(f["x0", "lid"] - (1 - OPPOSITE) / 4) < 1e-9
    assert f[4, 5] == f[-2, -1] == f["floor", "lid"]
    assert 0 <= f["floor", "lid"].std_error < 1e-6
    copied = pickle.loads(pickle.dumps(f["floor", "lid"]))
    assert copied == f["floor", "lid"] and copied.std_error == f["floor", "lid"].std_error
    assert f.is_closed and f.engine == "analytic" and len(f.notes) > 0
    assert np.allclose(f @ np.ones(6), 1, atol=1e-9)
    assert f.areas.tolist() == [1] * 6
    assert not (f.sky.any() or f.ground.any() or f.hidden.any() or f.cut.any() or f.lost.any())


def test_reciprocity_and_rows_of_rays(cube: az.Scene) -> None:
    f = az.form_factors(cube, patches=150, rays=256, closure=False)
    assert f.engine == "rays" and f.rays >= 256 * len(f)
    s = f.matrix.multiply(f.areas[:, None]).toarray()
    assert np.allclose(s, s.T, rtol=1e-14, atol=0)
    sums = f @ np.ones(len(f))
    assert abs(sums - 1).max() > 1e-6, "there is no noise to close"
    closed = f.close()
    assert closed.closed is not None and f.closed is None
    assert np.allclose(closed @ np.ones(len(f)), 1, atol=1e-8)
    assert (f.row_error > 0).all() and (f.row_error < 0.5).all()


def test_errors_tell_the_truth(cube: az.Scene) -> None:
    f = az.form_factors(cube, by="object", patches=24, rays=1024, formulas=False)
    off = abs(f["floor", "lid"] - OPPOSITE)
    assert 0 < off < 4 * f["floor", "lid"].std_error < 0.1


def test_open_scenes_have_sky_and_ground() -> None:
    meshes = faces_of_cube()
    del meshes["lid"]
    f = az.form_factors(az.Scene(meshes), by="object", patch_size=0, tolerance=1e-9)
    assert not f.is_closed
    assert abs(f.sky[4] - OPPOSITE) < 1e-6 and f.ground[4] == 0
    turned = az.form_factors(az.Scene(meshes, up="y"), by="object", patch_size=0)
    assert abs(turned.sky[4] - turned.ground[4]) < 0.01, "half of it is above the horizon"


def test_mirrors_are_in_the_factors() -> None:
    """By symmetry a perfect mirror doubles the room."""
    meshes = faces_of_cube()
    scene = az.Scene(meshes, {"lid": az.Material(mirror=1.0), "*": az.Material()})
    f = az.form_factors(scene, by="object", patches=600, rays=2048, separate=True)
    a, b, c = 1.0, 1.0, 2.0
    x, y = a / c, b / c
    opposite = (2 / (np.pi * x * y)) * (
        0.5 * np.log((1 + x * x) * (1 + y * y) / (1 + x * x + y * y))
        + x * np.sqrt(1 + y * y) * np.arctan(x / np.sqrt(1 + y * y))
        + y * np.sqrt(1 + x * x) * np.arctan(y / np.sqrt(1 + x * x))
        - x * np.arctan(x)
        - y * np.arctan(y)
    )
    assert abs(f["floor", "floor"] - opposite) < 0.003
    direct, by_one, more = f.orders
    assert abs(direct[4, 4]) == 0 and abs(by_one[4, 4] - opposite) < 0.003
    total = (direct + by_one + more).toarray()
    assert np.allclose(total, f.matrix.toarray(), atol=1e-12)
    assert f.ends.tolist() == [1, 1, 1, 1, 1, 0]
    assert np.allclose(f @ f.ends + f.cut, 1, atol=0.01)


def test_backs_are_rows_of_their_own() -> None:
    square = (np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2, 3]]))
    f = az.form_factors(az.Scene({"a": square}), by="object", patch_size=0, two_sided=True)
    assert f.names == ("a", "a (back)")
    assert np.allclose(f.sky, [1, 0]) and np.allclose(f.ground, [0, 1])
    patches = az.form_factors(az.Scene({"a": square}), patch_size=0, two_sided=True)
    assert patches.is_back.tolist() == [False, True]
    assert np.allclose(patches.normals, [[0, 0, 1], [0, 0, -1]])
    first, second = np.split(patches.corners, patches.corner_offsets[1:-1])
    assert np.allclose(first, second[::-1])


def test_patches_say_where_they_lie(cube: az.Scene) -> None:
    f = az.form_factors(cube, patches=100, rays=16)
    assert f.names is None and f.corner_offsets[-1] == len(f.corners)
    assert set(np.diff(f.corner_offsets)) <= {3, 4}
    quads = f.corners.reshape(len(f), 4, 3)
    assert np.allclose(quads.mean(axis=1), f.centroids)
    d = quads - quads[:, :1]
    area_vectors = (np.cross(d[:, 1], d[:, 2]) + np.cross(d[:, 2], d[:, 3])) / 2
    assert np.allclose(area_vectors, f.normals * f.areas[:, None])
    assert sorted(set(f.object)) == list(range(6)) and set(f.face) == {0}
    assert set(f.material) == {0}
    inside = (0.5 - f.centroids) * f.normals
    assert (inside.sum(axis=1) > 0).all(), "fronts face inwards"


def test_groups(cube: az.Scene) -> None:
    f = az.form_factors(cube, patches=54, rays=64)
    by_object = f.group("object")
    assert by_object.names == tuple(faces_of_cube())
    again = f.group(f.object)
    assert again.names == ("0", "1", "2", "3", "4", "5")
    assert (again.matrix != by_object.matrix).nnz == 0
    walls = by_object.group({**dict.fromkeys(faces_of_cube(), "walls"), "lid": "lid"})
    assert walls.names == ("walls", "lid") and np.allclose(walls.areas, [5, 1])
    assert abs(walls["lid", "walls"] - 1) < 1e-9 and abs(walls["walls", "lid"] - 0.2) < 1e-9
    part = by_object.group([None, None, None, None, "floor", "lid"])
    assert len(part) == 2 and np.allclose(part.hidden, 1 - OPPOSITE, atol=0.02)


def test_faces_that_overlap_or_have_no_area_are_named() -> None:
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    scene = az.Scene({"wall": (square, [[0, 1, 2, 3], [0, 1, 1]]), "window": (square, [[0, 1, 2, 3]])})
    with pytest.warns(UserWarning) as said:
        az.form_factors(scene, patch_size=0)
    words = [str(w.message) for w in said]
    assert any('face 0 of "window" on face 0 of "wall"' in w for w in words), words
    assert any('without area have no row: face 1 of "wall"' in w for w in words), words


def test_clusters(cube: az.Scene) -> None:
    f = az.form_factors(cube, patches=54, rays=64)
    halves = f.cluster(12)
    assert len(halves) == 12 and halves.names is not None
    assert set(halves.names) == {f"{face}/{k}" for face in faces_of_cube() for k in (0, 1)}
    by_object = halves.group([name.split("/")[0] for name in halves.names])
    assert np.allclose(by_object.matrix.toarray(), f.group("object").matrix.toarray())
    with pytest.warns(UserWarning, match="6 rows are left"):
        assert len(f.cluster(2, angle=180)) == 6


def test_truncation_keeps_rows(cube: az.Scene) -> None:
    f = az.form_factors(cube, patches=150, rays=256)
    small = f.truncate(0.005)
    assert small.matrix.nnz < f.matrix.nnz and small.truncated is not None
    assert np.allclose(small @ np.ones(len(f)), f @ np.ones(len(f)), atol=1e-9)


def test_the_matrix_is_not_a_copy(cube: az.Scene) -> None:
    f = az.form_factors(cube, patches=600, rays=256)
    data, error, columns, starts = f._buffers
    tracemalloc.start()
    matrix, std_error = f.matrix, f.std_error
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert data.nbytes > 1_000_000 and peak < 100_000, "something was copied"
    for mine, theirs in [(data, matrix.data), (columns, matrix.indices), (starts, matrix.indptr)]:
        assert np.shares_memory(mine, theirs) and not theirs.flags.writeable
    assert np.shares_memory(std_error.data, error) and std_error.dtype == np.float32
    assert np.shares_memory(std_error.indices, columns)
    assert f.matrix is matrix and matrix.has_sorted_indices
    with pytest.raises(ValueError, match="read-only"):
        f.areas[0] = 1
    x = np.arange(len(f), dtype=float)
    assert np.allclose(f @ x, matrix.toarray() @ x)
    assert np.allclose(x @ f, x @ matrix.toarray())


def test_one_thread_and_two_give_the_same_bits(cube: az.Scene) -> None:
    one, two = (az.form_factors(cube, patches=150, rays=256, threads=n) for n in (1, 2))
    assert one.matrix.data.tobytes() == two.matrix.data.tobytes()
    assert one.std_error.data.tobytes() == two.std_error.data.tobytes()
    other = az.form_factors(cube, patches=150, rays=256, seed=1)
    assert other.matrix.data.tobytes() != one.matrix.data.tobytes()


@pytest.mark.parametrize(
    ("model", "options", "arguments"),
    [
        ("cube", {"patch_size": 0}, ["--patch-size", "0"]),
        ("cube", {"patches": 150, "rays": 64}, ["--patches", "150", "--rays", "64"]),
        (
            "cube",
            {"patches": 150, "rays": 64, "by": "object", "two_sided": True, "closure": True},
            "--patches 150 --rays 64 --by object --two-sided --closure".split(),
        ),
        (
            "cube",
            {"patches": 60, "engine": "hemicube", "resolution": 32, "patch_points": 4},
            "--patches 60 --engine hemicube --resolution 32 --patch-points 4 --gpu off".split(),
        ),
        (
            "cornell-mirror",
            {"patches": 200, "rays": 64, "separate": True, "seed": 7},
            "--patches 200 --rays 64 --separate --seed 7".split(),
        ),
        (
            "shapes",
            {"patches": 200, "rays": 64, "by": "face", "formulas": False},
            "--patches 200 --rays 64 --by face --formulas never".split(),
        ),
    ],
)
def test_the_command_gives_the_same_bytes(
    command: str, cube_file: Path, tmp_path: Path, model: str, options: dict, arguments: list[str]
) -> None:
    path = cube_file if model == "cube" else ROOT / "examples" / f"{model}.grf"
    out = tmp_path / "f.npz"
    subprocess.run([command, "form-factors", path, "-o", out, "-q", *arguments], check=True)
    theirs = np.load(out)
    f = az.form_factors(az.load(path), **options)
    mine = {
        "data": f.matrix.data,
        "indices": f.matrix.indices,
        "indptr": f.matrix.indptr,
        "std_error": f.std_error.data,
        **{name: getattr(f, name) for name in ("areas", "row_error", "sky", "ground", "hidden")},
        "sky_error": f.sky_error,
        "cut": f.cut,
    }
    if f.names is not None:
        mine["names"] = np.array(f.names)
    else:
        faces = np.stack([f.object, f.face], axis=1)
        assert (theirs["patch_face"] == faces).all()
    if options.get("separate"):
        names = ("direct", "one_mirror", "more_mirrors")
        mine.update({name: m.data for name, m in zip(names, f.orders, strict=True)})
    for name, array in mine.items():
        assert theirs[name].dtype == array.dtype, name
        assert theirs[name].tobytes() == array.tobytes(), name


def test_what_is_refused(cube: az.Scene, refuses) -> None:
    def call(**options):
        return lambda: az.form_factors(cube, **options)

    refuses('unknown engine "ray", did you mean "rays"?', call(engine="ray"))
    refuses("that engine is for solve_light", call(engine="particles"))
    refuses('unknown group "objects", did you mean "object"?', call(by="objects"))
    refuses('unknown closure "yes"', call(closure="yes"))
    refuses("contradict each other", call(patches=10, patch_size=1))
    refuses("rays is 0, expected 1 to", call(rays=0))
    refuses("rays is -5, expected 1 to", call(rays=-5))
    refuses("rays is 18446744073709551616", call(rays=2**64))
    refuses("rays is a float", call(rays=2.5), TypeError)
    refuses("rays is a bool", call(rays=True), TypeError)
    refuses("patch_size is nan", call(patch_size=float("nan")))
    refuses("threads is 0", call(threads=0))
    refuses("resolution applies only to", call(resolution=64))
    refuses("expected an even number", call(engine="hemicube", resolution=63))
    refuses('memory is "lots"', call(memory="lots"))
    refuses("progress is a str", call(progress="yes"), TypeError)
    refuses("need about", call(patches=10**9, memory="1M"), MemoryError)
    refuses("scene is a str, expected a Scene", lambda: az.form_factors("a.obj"), TypeError)
    flat = (np.zeros((3, 3)), np.array([[0, 1, 2]]))
    refuses("no surface", lambda: az.form_factors(az.Scene({"a": flat})))


def test_entries_that_do_not_exist(cube: az.Scene, refuses) -> None:
    patches = az.form_factors(cube, patch_size=0)
    groups = patches.group("object")
    refuses('no row is named "roof"; there are "x0", "x1"', lambda: groups["roof", "lid"])
    refuses("rows are patches, which have no names", lambda: patches["floor", "lid"])
    refuses("the row is 6, expected -6 to 5", lambda: patches[6, 0])
    refuses("expected a row and a column", lambda: patches["floor"], TypeError)
    refuses("rows are groups, which have no corners", lambda: groups.corners)
    refuses("separate=True", lambda: patches.orders)
    refuses("5 labels for 6 rows", lambda: patches.group([1] * 5))
    refuses("no row has a label", lambda: patches.group([None] * 6))
    refuses("two labels are the same as text", lambda: patches.group([1, "1", 1, 1, 1, 1]))
    refuses('no label for "x0"', lambda: groups.group({"lid": "top"}))
    refuses("share is 2.0", lambda: patches.truncate(2))
    refuses("count is 0", lambda: patches.cluster(0))
    refuses("expected 0 to 180 degrees", lambda: patches.cluster(3, angle=200))
    refuses("found rows that are groups already", lambda: groups.cluster(3))


def street():
    """A street two wide between walls 1.5 high and roofs one wide: 3 × 3 in all."""
    return az.Scene(
        {
            "ground": ([[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]], [[0, 1, 2, 3]]),
            "east": ([[2, 0, 0], [2, 0, 1.5], [2, 3, 1.5], [2, 3, 0]], [[0, 1, 2, 3]]),
            "roof": ([[2, 0, 1.5], [3, 0, 1.5], [3, 3, 1.5], [2, 3, 1.5]], [[0, 1, 2, 3]]),
            "west": ([[3, 0, 0], [3, 3, 0], [3, 3, 1.5], [3, 0, 1.5]], [[0, 1, 2, 3]]),
        }
    )


def test_periodic_scenes_stand_for_endless_ones():
    f = az.form_factors(street(), by="object", rays=65_536, periodic="x,y")
    to_sky = np.hypot(1, 0.75) - 0.75  # Hottel's crossed strings
    assert abs(f.sky[0] - to_sky) < 1e-3
    assert abs(f["east", "west"] - (np.hypot(1, 4 / 3) - 4 / 3)) < 1e-3
    given = {"x": 3.0, "y": None}
    same = az.form_factors(street(), by="object", rays=65_536, periodic=given)
    assert np.array_equal(same.matrix.toarray(), f.matrix.toarray())
    middle = az.point_factors(street(), [[1.0, 1.5, 0.0]], [0, 0, 1], periodic="x,y", rays=16_384)
    assert abs(middle.sky[0] - np.sin(np.arctan(1 / 1.5))) < 3e-3


@pytest.mark.parametrize(
    ("periodic", "error", "words"),
    [
        ("q", az.AzulejoError, "not an axis"),
        ({"x": -1.0}, az.AzulejoError, "not a length above 0"),
        ({"x": 2.0}, az.AzulejoError, "the model is 3 long"),
        ({"x": float("nan")}, az.AzulejoError, "finite"),
        ({"x": "wide"}, TypeError, "expected a number"),
        (3.0, TypeError, "a mapping of axes"),
    ],
)
def test_wrong_periods_are_refused(periodic, error, words):
    with pytest.raises(error, match=words):
        az.form_factors(street(), periodic=periodic)


def test_notebooks_show_a_table() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    scene = az.Scene({"a <b>": (square, [[0, 1, 2, 3]])})
    text = az.form_factors(scene, by="object")._repr_html_()
    assert "a &lt;b&gt;" in text and "FormFactors(1 groups" in text and "more rows" not in text
    # Area, to rows, sky, ground, backs, lost, sum.
    assert "<td>1</td><td>0</td><td>1</td><td>0</td><td>0</td><td>0</td><td>1</td>" in text
    many = az.form_factors(scene, patches=100)
    assert f"and {len(many) - 20:,} more rows" in many._repr_html_()
