"""Temperatures and fluxes: closed forms, balances, the sun, files, and what is refused."""

from __future__ import annotations

import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import OPPOSITE, faces_of_cube

import pyazulejo as az

SIGMA = 5.670374419e-8
NONE = np.nan
MIXED = {"x0": 0.9, "x1": 0.3, "y0": 0.05, "y1": 1.0, "floor": 0.6, "lid": 0.8}


def plates() -> az.FormFactors:
    return az.FormFactors([[0, 1], [1, 0]], [2, 2], ["hot", "cold"])


def triangle() -> az.FormFactors:
    return az.FormFactors((np.ones((3, 3)) - np.eye(3)) / 2, np.ones(3), ["a", "b", "c"])


def box() -> az.FormFactors:
    """Floor, lid and the walls of a cube as one."""
    wall = (1 - OPPOSITE) / 4
    F = [[0, OPPOSITE, 4 * wall], [OPPOSITE, 0, 4 * wall], [wall, wall, 1 - 2 * wall]]
    return az.FormFactors(F, [1, 1, 4], ["floor", "lid", "wall"])


@pytest.fixture
def room(cube: az.Scene) -> az.FormFactors:
    return az.form_factors(cube, patches=150, rays=64).close()


def test_plates_exchange_what_the_formula_says() -> None:
    heat = az.radiosity(plates(), {"hot": 0.8, "cold": 0.5}, T={"hot": 500, "cold": 300})
    q = SIGMA * (500**4 - 300**4) / (1 / 0.8 + 1 / 0.5 - 1)
    assert np.allclose(heat.q, [q, -q], rtol=1e-12) and heat.T.tolist() == [500, 300]
    assert np.allclose(heat.node_Q, [2 * q, -2 * q], rtol=1e-12)
    assert np.isclose(heat["hot"].Q, 2 * q) and heat["hot"].T == 500 == heat[0].T
    assert heat["hot"].Q.std_error == 0 and heat.names == ("hot", "cold") == heat.row_names
    assert np.allclose(
        heat.J,
        0.8 * SIGMA * 500**4 * np.array([1, 0]) + [0.2, 0.5] * heat.H + [0, 0.5 * SIGMA * 300**4],
    )
    assert heat.iterations == 0 and abs(heat.imbalance) < 1e-9
    assert heat.to_sky == heat.to_ground == 0 and not heat.solar.any()
    assert repr(heat) == "Radiosity(2 rows, 2 nodes)"
    assert heat.exchange["hot", "cold"] == az.exchange(plates(), {"hot": 0.8, "cold": 0.5})[0, 1]


def test_a_cube_of_known_temperatures(room: az.FormFactors) -> None:
    """Against the equations, solved densely."""
    temperatures = np.linspace(300, 900, len(room))
    heat = az.radiosity(room, MIXED, T=temperatures)
    e = np.repeat(list(MIXED.values()), len(room) // 6)
    F, E = room.matrix.toarray(), SIGMA * temperatures**4
    J = np.linalg.solve(np.eye(len(room)) - (1 - e)[:, None] * F, e * E)
    assert np.allclose(heat.J, J, rtol=1e-10) and np.allclose(heat.H, F @ J, rtol=1e-10)
    assert np.allclose(heat.q, e * (E - F @ J), rtol=1e-9, atol=1e-9)
    assert heat.names == tuple(MIXED) and (heat.row_node == room.object).all()
    sums = np.zeros(6)
    np.add.at(sums, room.object, heat.q * room.areas)
    assert np.allclose(heat.node_Q, sums, rtol=1e-12) and (heat.areas == room.areas).all()
    means = [np.mean(temperatures[room.object == k] ** 4) ** 0.25 for k in range(6)]
    assert np.allclose(heat.node_T, means, rtol=1e-12)
    assert (heat.node_Q_error > 0).all() and not heat.node_T_error.any()
    assert abs(heat.imbalance) < 1e-8 * abs(sums).max()


@pytest.mark.parametrize("seed", range(3))
def test_fluxes_give_the_temperatures_from_which_they_came(room: az.FormFactors, seed: int) -> None:
    random = np.random.default_rng(seed)
    true = random.uniform(200, 1500, len(room))
    q = az.radiosity(room, MIXED, T=true).q
    is_given = random.random(len(room)) < 0.3
    back = az.radiosity(
        room, MIXED, T=np.where(is_given, true, NONE), q=np.where(is_given, NONE, q)
    )
    assert np.allclose(back.T, true, rtol=1e-8, atol=0)
    assert np.allclose(back.q, q, rtol=1e-8, atol=1e-8 * abs(q).max())


def test_fluxes_give_temperatures_back_in_bands(room: az.FormFactors) -> None:
    material = az.Material(eps={(0, 3): 0.2, (3, 8): 0.5, (8, np.inf): 0.9})
    true = np.linspace(400, 1500, len(room))
    q = az.radiosity(room, material, T=true).q
    some = np.arange(len(room)) % 3 == 0
    back = az.radiosity(room, material, T=np.where(some, true, NONE), q=np.where(some, NONE, q))
    assert np.allclose(back.T, true, rtol=1e-8, atol=0) and back.iterations > 0


def test_published_temperatures() -> None:
    heat = az.radiosity(
        triangle(), {"a": 0.8, "b": 0.4, "c": 0.2}, T={"a": 1000, "b": 500}, q={"c": 0}
    )
    assert np.isclose(heat["c"].T, 921.566208889837, rtol=1e-12)
    walls = az.radiosity(
        box(), {"wall": 0.5, "*": 1.0}, T={"floor": 400, "lid": 300}, q={"wall": 0}
    )
    expected = (1 + OPPOSITE) / 2 * SIGMA * (400**4 - 300**4)
    assert np.isclose(walls["floor"].Q, expected, rtol=1e-12)
    # The emissivity of an adiabatic surface does not matter, even 0.
    mirror = az.radiosity(box(), {"wall": 0, "*": 1.0}, T={"floor": 400, "lid": 300}, q={"wall": 0})
    assert np.isclose(mirror["wall"].T, walls["wall"].T, rtol=1e-12)


def test_bands_of_given_temperatures() -> None:
    """Two plates whose bands are known to 14 digits, and each band by itself."""
    materials = {
        "hot": az.Material(eps={(0, 4): 0.9, (4, np.inf): 0.1}),
        "cold": az.Material(eps={(0, 4): 0.2, (4, np.inf): 0.8}),
    }
    heat = az.radiosity(plates(), materials, T={"hot": 1500, "cold": 300})
    assert np.isclose(heat.q[0], 48736.1256270328, rtol=1e-11)
    below = az.band_fraction([4 * 1500, 4 * 300])
    emission = SIGMA * np.array([1500.0, 300]) ** 4
    parts = 0
    for k, share in enumerate([below, 1 - below]):
        alone = az.exchange(plates(), {n: list(m.eps.values())[k] for n, m in materials.items()})
        parts += alone[0, 1] * (share * emission)[0] - alone[0, 1] * (share * emission)[1]
    assert np.isclose(heat["hot"].Q, parts, rtol=1e-12)
    assert list(heat.exchange.bands) == ["0-4", "4-inf"]


def test_equal_bands_are_grey() -> None:
    bands = az.Material(eps={(0, 2): 0.3, (2, 9): 0.3, (9, np.inf): 0.3})
    given = {"T": {"floor": 1000, "lid": 300}, "q": {"wall": 500.0}}
    heat, grey = az.radiosity(box(), bands, **given), az.radiosity(box(), 0.3, **given)
    for name in ("T", "q", "J", "H", "node_Q"):
        assert np.allclose(getattr(heat, name), getattr(grey, name), rtol=1e-9), name


def test_a_plate_in_space_under_the_sun() -> None:
    plate = az.FormFactors([[0]], [3.0], ["plate"], open=True)
    material = az.Material(eps=0.8, alpha=0.2)
    heat = az.radiosity(plate, material, q=0, solar=1361, space=3)
    expected = (0.2 * 1361 / 0.8 / SIGMA + 3**4) ** 0.25
    assert np.isclose(heat["plate"].T, expected, rtol=1e-12)
    assert np.isclose(heat.to_sky, 3 * 0.2 * 1361, rtol=1e-12) and heat.solar.tolist() == [
        0.2 * 1361
    ]
    assert abs(heat.imbalance) < 1e-9
    same = az.radiosity(plate, {"plate": material}, q={"plate": 0}, solar={"plate": 1361}, sky=3)
    assert same.T.tobytes() == heat.T.tobytes()
    assert (
        az.radiosity(plate, material, q=[0], solar=[1361.0], space=3).T.tolist() == heat.T.tolist()
    )
    warmer = az.radiosity(plate, material, q=0, solar=1361, space=100)
    assert np.isclose(warmer.T[0] ** 4 - heat.T[0] ** 4, 100**4 - 3**4)
    with pytest.warns(UserWarning, match="no temperature of the sky is given: 3 K") as caught:
        az.radiosity(plate, material, q=0)
    assert caught[0].filename == __file__
    with pytest.warns(UserWarning, match="sunlight has no effect, because no absorptance"):
        az.radiosity(plate, 0.8, q=0, solar=1361, space=3)


def test_a_crater() -> None:
    """The shadow of a spherical bowl (Ingersoll, Svitek, Murray 1992)."""
    share, albedo = 0.2, 0.12
    F = np.full((2, 2), share / 2)
    crater = az.FormFactors(F, [0.5, 0.5], ["lit", "shadow"], open=True)
    sun = 1361 * np.sin(np.radians(10)) * (1 - share) / 0.5
    material = az.Material(eps=0.95, alpha=1 - albedo)
    heat = az.radiosity(crater, material, q=0, solar={"lit": sun}, space=0)
    assert np.isclose(heat["shadow"].T, 169.608216345369, rtol=1e-12)


def test_the_sky_of_a_scene_shines_on_its_rows() -> None:
    square = (np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [[0, 1, 2, 3]])
    material = az.Material(eps=0.9, alpha=0.5)
    scene = az.Scene({"roof": square}, material, sky=100 / np.pi)
    f = az.form_factors(scene, patch_size=0)
    assert f.irradiance is not None and np.allclose(f.irradiance, 100, rtol=1e-9)
    assert f.irradiance_error is not None and np.allclose(f.irradiance_error, 0, atol=1e-9)
    heat = az.radiosity(f, q=0, space=250)
    assert np.isclose(heat.T[0], (50 / 0.9 / SIGMA + 250**4) ** 0.25, rtol=1e-9)
    assert az.form_factors(az.Scene({"roof": square}), patch_size=0).irradiance is None


def test_the_sun_of_a_scene(refuses) -> None:
    """Straight, in the shadow, and by a mirror."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    meshes = {
        "roof": (square, [[0, 1, 2, 3]]),
        "shade": (square + [5, 0, 1], [[3, 2, 1, 0]]),
        "below": (square + [5, 0, 0], [[0, 1, 2, 3]]),
    }
    sun = ([3, 0, 4], 1361)
    f = az.form_factors(az.Scene(meshes, sun=sun), by="object", patch_size=0.2, rays=256)
    assert f.irradiance is not None and f.irradiance_error is not None
    assert np.isclose(f.irradiance[0, 1], 0.8 * 1361, rtol=1e-3)
    assert f.irradiance[1].max() == 0, "the sun is behind it"
    # The shadow of the sheet above is moved by three quarters of its height.
    assert np.isclose(f.irradiance[2, 1], 0.75 * 0.8 * 1361, rtol=0.02)
    wall = {"roof": meshes["roof"], "wall": (square[:, [2, 1, 0]], [[3, 2, 1, 0]])}
    materials = {"roof": az.Material(mirror=0.9), "wall": az.Material()}
    scene = az.Scene(wall, materials, sun=([1, 0, 1], 100))
    both = az.form_factors(scene, by="object", patch_size=0.2, rays=256)
    assert both.irradiance is not None
    straight = 100 / np.sqrt(2)
    assert np.isclose(both.irradiance[1, 1], 1.9 * straight, rtol=0.03)
    flat = meshes["roof"]
    refuses("sun is 3, expected a direction", lambda: az.Scene({"a": flat}, sun=3), TypeError)
    refuses("its direction is zero", lambda: az.Scene({"a": flat}, sun=([0, 0, 0], 1)))
    refuses("three finite numbers", lambda: az.Scene({"a": flat}, sun=([0, 0, np.nan], 1)))
    refuses("irradiance of the sun is", lambda: az.Scene({"a": flat}, sun=([0, 0, 1], -1)))


def test_sky_and_ground_have_temperatures_of_their_own() -> None:
    square = (np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [[0, 1, 2, 3]])
    f = az.form_factors(az.Scene({"slab": square}), by="object", patch_size=0, two_sided=True)
    heat = az.radiosity(f, 1.0, q=0, sky=250, ground=290)
    assert np.allclose(heat.T, [250, 290]) and heat.names == ("slab", "slab (back)")
    half = az.radiosity(f, 1.0, q=0, space=200, ground=290)
    assert np.allclose(half.T, [200, 290])


def test_a_surface_may_be_called_ground() -> None:
    f = az.FormFactors([[0, 1], [1, 0]], [1, 1], ["ground", "sky"])
    heat = az.radiosity(f, 1.0, T={"ground": 300}, q={"sky": 0})
    assert np.allclose(heat.T, 300)


def test_units_are_metres() -> None:
    """A cube of 1000 mm has the heat of one of 1 m."""
    given = {"T": {"floor": 500, "lid": 300}, "q": {"?[01]": 0}}
    results = []
    for scale, unit in [(1, "m"), (1000, "mm")]:
        meshes = {name: (scale * v, f) for name, (v, f) in faces_of_cube().items()}
        f = az.form_factors(az.Scene(meshes, unit=unit), by="object", patch_size=0)
        results.append(az.radiosity(f, 0.5, **given))
    metres, millimetres = results
    assert np.allclose(metres.node_Q, millimetres.node_Q, rtol=1e-6, atol=1e-6)
    assert np.allclose(millimetres.areas, 1) and np.allclose(millimetres.exchange.areas, 1)


def test_errors_tell_the_truth(cube: az.Scene) -> None:
    given = {"T": {"floor": 500, "lid": 300}, "q": {"*": 0}}
    true = az.radiosity(az.form_factors(cube, by="object", patch_size=0), MIXED, **given)
    ratios = []
    for seed in range(12):
        noisy = {"formulas": False, "closure": False, "seed": seed}
        f = az.form_factors(cube, by="object", patches=6, rays=256, **noisy)
        heat = az.radiosity(f, MIXED, **given)
        assert heat["lid"].T.std_error == 0 < heat["x0"].T.std_error
        assert heat["x0"].Q.std_error == 0 < heat["lid"].Q.std_error
        assert heat["x0"].T.std_error == heat.node_T_error[0]
        ratios.append((heat.node_T - true.node_T)[:4] / heat.node_T_error[:4])
        ratios.append((heat.node_Q - true.node_Q)[4:] / heat.node_Q_error[4:])
    ratios = np.concatenate(ratios)
    # Too large by a few times: errors of pairs count as independent, but what a row gives to one other
    # it takes from the rest.
    assert 0.1 < np.std(ratios) < 1 and (abs(ratios) > 2).mean() < 0.06


def test_numbers_of_all_kinds() -> None:
    f = triangle()
    plain = az.radiosity(f, 0.5, T=[300.0, 400.0, 500.0])
    strided = np.array([[300, 0], [400, 0], [500, 0]])[:, 0]
    read_only = np.array([300, 400, 500], dtype=np.float32)
    read_only.flags.writeable = False
    fortran = np.asfortranarray(np.array([[300.0, 400, 500], [1, 2, 3]]))[0]
    for same in (
        strided,
        read_only,
        fortran,
        (300, 400, 500),
        np.array([300, 400, 500], dtype=np.uint16),
    ):
        assert az.radiosity(f, 0.5, T=same).q.tobytes() == plain.q.tobytes()
    names = {"a": np.float32(300), "b": 400, "c": np.array(500)}
    assert az.radiosity(f, 0.5, T=names).q.tobytes() == plain.q.tobytes()
    alike = az.radiosity(f, 0.5, T=np.array(300))
    assert alike.T.tolist() == [300] * 3 and not np.abs(alike.q).round(9).any()
    mixed = az.radiosity(f, 0.5, T=[300, NONE, NONE], q={"b": 0, "c": 0})
    assert np.allclose(mixed.T, 300)


def test_arrays_cannot_be_changed() -> None:
    heat = az.radiosity(plates(), 0.5, T=300)
    names = ("T", "q", "J", "H", "solar", "areas", "row_node", "node_T", "node_Q", "node_T_error")
    for name in (*names, "node_Q_error"):
        assert getattr(heat, name) is getattr(heat, name), name
        with pytest.raises(ValueError, match="read-only"):
            getattr(heat, name)[0] = 1


def test_files(room: az.FormFactors, tmp_path: Path, refuses) -> None:
    heat = az.radiosity(room, MIXED, T={"floor": 900, "lid": 300}, q={"*": 0})
    heat.save(tmp_path / "heat.npz")
    arrays = np.load(tmp_path / "heat.npz")
    for name in ("T", "q", "J", "H", "solar", "node_T", "node_Q", "node_Q_error"):
        assert arrays[name].tobytes() == getattr(heat, name).tobytes(), name
    assert arrays["row_node"].tolist() == heat.row_node.tolist()
    heat.save(tmp_path / "heat.csv")
    lines = (tmp_path / "heat.csv").read_text().splitlines()
    assert lines[0] == "name,area,T,T_error,Q,Q_error" and len(lines) == 7
    heat.exchange.save(tmp_path / "gr.csv")
    assert (tmp_path / "gr.csv").read_text().startswith("from,to,gr_m2,std_error")
    heat.exchange.save(tmp_path / "gr.npz")
    assert "T" not in np.load(tmp_path / "gr.npz").files
    given = az.radiosity(plates(), 0.5, T=300)
    refuses("the matrix has no polygons", lambda: given.save(tmp_path / "a.vtu"))
    refuses("given without geometry", given.to_pyvista)
    refuses("unknown format", lambda: given.save(tmp_path / "a.txt"))
    assert not (tmp_path / "a.vtu").exists()


def test_meshes(room: az.FormFactors, tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    heat = az.radiosity(room, MIXED, T={"floor": 900, "lid": 300}, q={"*": 0})
    heat.save(tmp_path / "heat.vtu")
    file, mesh = pyvista.read(tmp_path / "heat.vtu"), heat.to_pyvista()
    assert file.n_cells == mesh.n_cells == len(room)
    for name in ("T", "q", "J", "H", "solar"):
        assert file.cell_data[name].tolist() == mesh.cell_data[name].tolist(), name
        assert mesh.cell_data[name].tolist() == getattr(heat, name).tolist(), name
    assert np.isclose(mesh.area, 6) and (mesh.cell_data["node"] == room.object).all()
    assert np.allclose(mesh.cell_centers().points, room.centroids, atol=1e-6)
    # Rows that are groups have several cells.
    heat = az.radiosity(room.group("object"), MIXED, T=[300, 400, 500, 600, 700, 800])
    mesh = heat.to_pyvista()
    assert mesh.n_cells == len(room)
    assert (mesh.cell_data["T"] == heat.T[mesh.cell_data["row"]]).all()
    assert (mesh.cell_data["T"] == 300 + 100 * room.object).all()


@pytest.mark.parametrize("banded", [False, True])
def test_the_command_gives_the_same_files(
    command: str, cube_file: Path, tmp_path: Path, banded: bool
) -> None:
    optics, boundary = tmp_path / "optics.csv", tmp_path / "boundary.csv"
    bands = "name,eps@0-4,eps@4-inf,alpha\nlid,0.1,0.9,0.3\n*,0.5,0.4,0.2\n"
    optics.write_text(bands if banded else "name,eps\nlid,0.1\n*,0.5\n")
    boundary.write_text("name,T,q,solar\nfloor,900,,100\nlid,400,,\nx?,,250,\n*,,0,\n")
    az.form_factors(az.load(cube_file), patches=54, rays=256).save(tmp_path / "f.npz")
    f = az.FormFactors.load(tmp_path / "f.npz")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        heat = az.radiosity(
            f,
            optics,
            T={"floor": 900, "lid": 400},
            q={"x?": 250, "*": 0},
            solar={"floor": 100},
        )
    arguments = [
        "exchange",
        tmp_path / "f.npz",
        "--materials",
        optics,
        "--boundary",
        boundary,
        "-q",
    ]
    for name in ("heat.npz", "heat.csv", "heat.vtu"):
        subprocess.run([command, *arguments, "-o", tmp_path / name], check=True)
        heat.save(tmp_path / f"mine.{name}")
        assert (tmp_path / name).read_bytes() == (tmp_path / f"mine.{name}").read_bytes(), name


def test_what_is_refused(refuses) -> None:
    def call(f: az.FormFactors | None = None, materials: object = 0.5, **given: object):
        return lambda: az.radiosity(plates() if f is None else f, materials, **given)

    refuses("exchange heat among themselves alone", call(q=0))
    refuses("exchange heat among themselves alone", call(triangle(), q=[1, 0, -1]))
    refuses('nothing says temperature or flux (T, or q) of "cold", "hot"', call())
    refuses('nothing says temperature or flux (T, or q) of "cold"', call(T={"hot": 300}))
    refuses('T of "hot" is given beside q', call(T={"hot": 300}, q={"hot": 1, "cold": 0}))
    refuses('row 1 ("cold") has neither T nor q', call(T=[300, NONE]))
    refuses('row 0 ("hot") has T and q', call(T=[300, 300], q=[0, NONE]))
    refuses('T of "*" is -1, expected at least 0', call(T=-1))
    refuses('T of row 1 ("cold") is -1', call(T=[300, -1]))
    refuses("T is nan, expected a finite number", call(T=NONE))
    refuses("T is inf, expected finite numbers", call(T=[np.inf, 300]))
    refuses('T of "hot" is inf', call(T={"hot": np.inf}))
    refuses("T has the shape (3,), expected (2,)", call(T=[300] * 3))
    refuses("T has the shape (0,), expected (2,)", call(T=[]))
    refuses("T has the shape (1, 2), expected (2,)", call(T=[[300, 300]]))
    refuses("T are lists of different lengths", call(T=[[300], [300, 1]]))
    refuses("T are of type", call(T=["300", "400"]))
    refuses("T are of type complex", call(T=np.array([1j, 2])))
    refuses("T is 'hot', expected a number", call(T="hot"), TypeError)
    refuses("T has the key 1, expected a name", call(T={1: 300}), TypeError)
    refuses("solar is -5, expected 0 or more", call(T=300, solar={"hot": -5}))
    refuses(
        "solar has 3 values for 2 rows", lambda: az.radiosity([plates()], 0.5, 300, solar=[1, 2, 3])
    )
    refuses("space is -1.0, expected 0 K or more", call(T=300, space=-1))
    refuses("sky is inf", call(T=300, sky=np.inf))
    refuses("ground is 'warm', expected a number", call(T=300, ground="warm"), TypeError)
    refuses("too large to compute with", call(T=[1e200, 300]))
    refuses("colder than absolute zero", call(T={"hot": 300}, q={"cold": -1e6}))
    refuses("emissivity 0 and cannot give off heat", call(materials=0, T={"hot": 9}, q={"cold": 1}))
    heat = az.radiosity(plates(), 0.5, T=300)
    refuses('no node is named "warm"', lambda: heat["warm"])
    refuses("the node is -3, expected -2 to 1", lambda: heat[-3])
    with pytest.warns(UserWarning, match='T, q: no row has the name "warm"'):
        az.radiosity(plates(), 0.5, T={"*": 300, "warm": 400})
    with pytest.warns(UserWarning, match='solar: no row has the name "warm"'):
        az.radiosity(plates(), az.Material(eps=0.5, alpha=0.1), T=300, solar={"warm": 400})


def test_a_group_without_a_temperature_is_named() -> None:
    """Two pairs of plates that do not see each other."""
    F = np.kron(np.eye(2), [[0, 1], [1, 0]])
    f = az.FormFactors(F, np.ones(4), ["a", "b", "c", "d"])
    with pytest.raises(az.AzulejoError, match='"c" and 1 other'):
        az.radiosity(f, 0.5, T={"a": 300}, q={"b": 0, "c": 0, "d": 0})
