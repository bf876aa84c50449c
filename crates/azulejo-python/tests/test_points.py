"""Form factors from points: closed forms, errors, mirrors, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import FACES, faces_of_cube

import pyazulejo as az

QUAD = [[0, 1, 2, 3]]


def rectangle(a: float, b: float, c: float, down: bool = True) -> tuple[np.ndarray, object]:
    """A rectangle above the origin as one of its corners."""
    corners = np.array([[0, 0, c], [0, b, c], [a, b, c], [a, 0, c]], dtype=float)
    return corners if down else corners[::-1], QUAD


def disk(radius: float, height: float, sides: int = 720) -> tuple[np.ndarray, np.ndarray]:
    """A disk that faces down."""
    angles = -2 * np.pi * np.arange(sides) / sides
    rim = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    vertices = np.concatenate([[[0, 0, height]], np.insert(rim, 2, height, axis=1)])
    k = np.arange(sides)
    return vertices, np.stack([0 * k, k + 1, (k + 1) % sides + 1], axis=1)


def parallel(a: float, b: float, c: float) -> float:
    """From an element to a parallel rectangle a × b at c, one corner of which is above it."""
    x, y = a / c, b / c
    return (
        x / np.hypot(1, x) * np.arctan(y / np.hypot(1, x))
        + y / np.hypot(1, y) * np.arctan(x / np.hypot(1, y))
    ) / (2 * np.pi)


def upright(a: float, b: float, c: float) -> float:
    """From an element to a rectangle of height a and width b at distance c that stands on its plane,
    opposite one of its lower corners."""
    x, y = a / c, b / c
    return (np.arctan(y) - np.arctan(y / np.hypot(1, x)) / np.hypot(1, x)) / (2 * np.pi)


@pytest.fixture
def cube() -> az.Scene:
    return az.Scene(faces_of_cube())


@pytest.mark.parametrize("size", [(1, 1, 1), (1, 2, 0.5), (10, 10, 0.1), (0.2, 0.2, 3)])
def test_an_element_below_a_rectangle(size: tuple[float, float, float]) -> None:
    p = az.point_factors(az.Scene({"lid": rectangle(*size)}), [[0, 0, 0]], [0, 0, 1], rays=2**16)
    found = p[0, "lid"]
    assert abs(found - parallel(*size)) < 3 * found.std_error < 0.01
    assert np.isclose(p.sky[0], 1 - found, atol=1e-9) and p.ground[0] == 0


def test_an_element_beside_a_wall() -> None:
    wall = (np.array([[1.0, 0, 0], [1, 2, 0], [1, 2, 3], [1, 0, 3]])[::-1], QUAD)
    p = az.point_factors(az.Scene({"wall": wall}), [[0, 0, 0]], [0, 0, 1], rays=2**16)
    assert abs(p[0, 0] - upright(3, 2, 1)) < 3 * p[0, 0].std_error < 0.005


@pytest.mark.parametrize(("radius", "height"), [(1, 1), (2, 0.5), (0.3, 2)])
def test_elements_and_globes_below_a_disk(radius: float, height: float) -> None:
    scene = az.Scene({"disk": disk(radius, height)})
    element = az.point_factors(scene, [[0, 0, 0]], [0, 0, 5], rays=2**16)[0, "disk"]
    assert abs(element - radius**2 / (radius**2 + height**2)) < 3 * element.std_error + 1e-4
    globe = az.point_factors(scene, [[0, 0, 0]], rays=2**16)[0, "disk"]
    solid_angle = (1 - height / np.hypot(radius, height)) / 2
    assert abs(globe - solid_angle) < 3 * globe.std_error + 1e-4


def test_errors_tell_the_truth() -> None:
    """One point in many places of the list has random numbers of its own each time."""
    scene = az.Scene({"lid": rectangle(1, 1, 1)})
    for normals, truth in [([0, 0, 1], parallel(1, 1, 1)), (None, 1 / 24)]:
        p = az.point_factors(scene, np.zeros((400, 3)), normals, rays=256)
        values, errors = p.matrix.toarray()[:, 0], p.std_error.toarray()[:, 0]
        off = (values - truth) / errors
        # Rays are spread more evenly than by chance, of which errors take no advantage.
        assert 0.2 < off.std() < 1.2 and (abs(off) > 2).mean() < 0.05
        assert abs(values.mean() - truth) < 4 * errors.mean() / 20
        total = p.sky + p.ground + values
        assert np.allclose(total, 1, atol=1e-12) and (p.sky_error > 0).all()


def test_a_globe_in_a_cube(cube: az.Scene) -> None:
    p = az.point_factors(cube, np.full((1, 3), 0.5), rays=2**14)
    assert p.names == tuple(FACES) and p.shape == (1, 6) and len(p) == 1
    assert np.allclose(p.matrix.toarray(), 1 / 6, atol=1e-3)
    assert np.allclose(p @ np.ones(6), 1) and repr(p) == "PointFactors(1 points, 6 columns)"
    # The mean radiant temperature of walls of one temperature.
    assert np.isclose((p @ np.full(6, 300.0) ** 4)[0] ** 0.25, 300)


def test_elements_on_rows_see_what_rows_see(cube: az.Scene) -> None:
    f = az.form_factors(cube, patches=24, rays=2**14, closure=False, formulas=False)
    p = az.point_factors(cube, f.centroids, f.normals, "patch", patches=24, rays=2**14)
    assert p.names is None and p.shape == f.shape
    by_object = az.point_factors(cube, f.centroids, f.normals, rays=2**14)
    grouped = np.zeros((len(f), 6))
    np.add.at(grouped.T, f.object, p.matrix.toarray().T)
    assert np.allclose(grouped, by_object.matrix.toarray(), atol=1e-9)
    # Nearly the form factors of small patches.
    assert abs(p.matrix.toarray() - f.matrix.toarray()).max() < 0.05


def test_sky_ground_and_backs() -> None:
    scene = az.Scene({"lid": rectangle(1, 1, 1)})
    above, below = [0.5, 0.5, 1.5], [0.5, 0.5, 0.5]
    p = az.point_factors(scene, [above, above, below, below], [[0, 0, 1], [0, 0, -1]] * 2)
    assert p.sky[0] == 1 and p.ground[3] == 1
    assert 0 < p.hidden[1] < 1 and np.isclose(p.hidden[1] + p.ground[1], 1)
    assert p[1, "lid"] == 0 == p[1, "lid"].std_error and p[2, "lid"] > 0 and not p.hidden[2]
    sides = az.point_factors(scene, [above, below], [[0, 0, -1], [0, 0, 1]], two_sided=True)
    assert sides.names == ("lid", "lid (back)") and not sides.hidden.any()
    assert sides[0, "lid (back)"] > 0 and sides[0, "lid"] == 0 == sides[1, "lid (back)"]
    turned = az.Scene({"lid": rectangle(1, 1, 1)}, up="y")
    up = az.point_factors(turned, [[0.5, 2, 1]], [[0, 1, 0]])
    assert up.sky[0] == 1 and not up.ground.any()


def test_mirrors_show_what_is_behind() -> None:
    """A mirror on the floor shows the lid below it."""
    meshes = {"lid": rectangle(1, 1, 1), "floor": rectangle(1, 1, 0, down=False)}
    scene = az.Scene(meshes, {"floor": az.Material(mirror=0.8), "lid": az.Material()})
    p = az.point_factors(scene, [[0, 0, 0.5]], [0, 0, -1], rays=2**16)
    seen = p[0, "lid"]
    assert abs(seen - 0.8 * parallel(1, 1, 1.5)) < 3 * seen.std_error
    assert abs(p[0, "floor"] - parallel(1, 1, 0.5)) < 3 * p[0, "floor"].std_error
    assert np.isclose(0.2 * p[0, "floor"] + seen + p.sky[0] + p.ground[0] + p.cut[0], 1, atol=1e-9)


def test_threads_do_not_matter_and_seeds_do(cube: az.Scene) -> None:
    points = np.random.default_rng(0).random((50, 3))
    one, two = (az.point_factors(cube, points, rays=64, threads=n) for n in (1, 2))
    assert one.matrix.data.tobytes() == two.matrix.data.tobytes()
    other = az.point_factors(cube, points, rays=64, seed=1)
    assert other.matrix.data.tobytes() != one.matrix.data.tobytes()


def test_numbers_of_all_kinds(cube: az.Scene) -> None:
    points = np.array([[0.25, 0.5, 0.5], [0.5, 0.5, 0.25]])
    plain = az.point_factors(cube, points, [0, 0, 1], rays=64).matrix.toarray().tobytes()
    read_only = points.astype(np.float32)
    read_only.flags.writeable = False
    kinds = [
        np.asfortranarray(points),
        points.tolist(),
        read_only,
        np.repeat(points, 2, axis=0)[::2],
    ]
    for same in kinds:
        for up in ([0, 0, 1], (0, 0, 1e300), np.array([0, 0, 1e-320]), [[0, 0, 3], [0, 0, 1]]):
            found = az.point_factors(cube, same, up, rays=64).matrix
            assert found.toarray().tobytes() == plain
    empty = az.point_factors(cube, np.empty((0, 3)), [0, 0, 1])
    assert empty.shape == (0, 6) and empty.matrix.shape == (0, 6) and empty.sky.shape == (0,)
    far = az.point_factors(cube, [[1e300, 0, 0]])
    assert np.allclose([far.sky[0], far.ground[0]], 0.5) and far.matrix.nnz == 0


def test_arrays_cannot_be_changed(cube: az.Scene) -> None:
    p = az.point_factors(cube, [[0.5, 0.5, 0.5]], rays=64)
    for array in (
        p.sky,
        p.sky_error,
        p.ground,
        p.ground_error,
        p.hidden,
        p.cut,
        p.lost,
        p.matrix.data,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_what_is_refused(cube: az.Scene, refuses) -> None:
    def call(points: object = ((0.5, 0.5, 0.5),), normals: object = None, **options: object):
        return lambda: az.point_factors(cube, points, normals, **options)

    refuses("points have the shape (3,), expected (n, 3)", call([0.5, 0.5, 0.5]))
    refuses("points have the shape (1, 2), expected (n, 3)", call([[1, 2]]))
    refuses("points: row 1 is not finite", call([[1, 2, 3], [0, np.nan, 0]]))
    refuses("points are of type <U", call([["a", "b", "c"]]))
    refuses("points are of type object", call([[None, 0, 0]]))
    refuses("points are lists of different lengths", call([[1, 2, 3], [4, 5]]))
    refuses("2 normals for 1 points", call(normals=[[0, 0, 1]] * 2))
    refuses("normal 0 is zero", call(normals=[0, 0, 0]))
    refuses("normals: row 0 is not finite", call(normals=[0, 0, np.inf]))
    refuses("normals have the shape (4,)", call(normals=[0, 0, 1, 0]))
    refuses("normals are lists of different lengths", call(normals=[[0, 0], [1]]))
    refuses('unknown group "row"', call(by="row"))
    refuses("rays is 0, expected 1 to", call(rays=0))
    refuses("patches and patch_size contradict", call(patches=3, patch_size=1))
    refuses("seed is -1", call(seed=-1))
    refuses(
        "scene is a str, expected a Scene", lambda: az.point_factors("a", [[0, 0, 0]]), TypeError
    )
    p = az.point_factors(cube, [[0.5, 0.5, 0.5]], rays=64)
    refuses('no column is named "roof"; there are "x0"', lambda: p[0, "roof"])
    refuses("the point is 1, expected -1 to 0", lambda: p[1, 0])
    refuses("the column is 6, expected -6 to 5", lambda: p[0, 6])
    refuses("expected a point and a column", lambda: p[0], TypeError)
    patches = az.point_factors(cube, [[0.5, 0.5, 0.5]], by="patch", patches=6, rays=64)
    refuses("columns are patches, which have no names", lambda: patches[0, "lid"])


def test_patches_of_the_sky(cube: az.Scene) -> None:
    """Shares of patches add up to those of sky and ground, and weigh a sky as it is: rows and points alike."""
    floor = az.Scene({"floor": (np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), QUAD)})
    f = az.form_factors(floor, by="object", sky_patches="tregenza")
    p = az.point_factors(floor, [[0, 0, 1]], [0, 0, 1], sky_patches="tregenza")
    for seen in (f.sky_patches, p.sky_patches):
        assert seen is not None and seen.division == "tregenza"
        assert seen.shares.shape == seen.std_error.shape == (1, 146)
        assert np.isclose(seen.shares[0, 1:].sum(), 1, atol=1e-6) and seen.shares[0, 0] == 0
        # By its solid angle and cosine; patches are small.
        expected = seen.directions[1:, 2] * seen.solid_angles[1:] / np.pi
        assert np.abs(seen.shares[0, 1:] / expected - 1).max() < 0.1
        assert not seen.shares.flags.writeable
    # The first patch is centred on north, which is +y, or +x if north is turned by 90 degrees.
    turned = az.form_factors(floor, sky_patches="reinhart:2", north=90)
    assert turned.sky_patches is not None
    assert turned.sky_patches.directions[1, 0] > 0.99 and f.sky_patches.directions[1, 1] > 0.99
    blocks = az.form_factors(cube, sky_patches="tregenza", compress=1e-2, patches=200)
    assert blocks.sky_patches is not None and len(blocks.sky_patches.shares) == len(blocks)
    assert az.form_factors(floor).sky_patches is None
    with pytest.raises(az.AzulejoError, match="sky_patches"):
        az.form_factors(floor, sky_patches="perez")
