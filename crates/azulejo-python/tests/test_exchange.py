"""Networks: closed forms, balances, bands, mirrors, files, and what is refused."""

from __future__ import annotations

import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import OPPOSITE, faces_of_cube

import pyazulejo as az

BANDS = {(0, 4): 0.2, (4, np.inf): 0.8}


def plates(**more: object) -> az.FormFactors:
    """Two large plates."""
    return az.FormFactors([[0, 1], [1, 0]], [2, 2], ["hot", "cold"], **more)


def shells(inner: float, outer: float) -> az.FormFactors:
    """Concentric spheres or cylinders of these areas."""
    share = inner / outer
    return az.FormFactors([[0, 1], [share, 1 - share]], [inner, outer], ["inner", "outer"])


def gebhart(F: np.ndarray, eps: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """B = (I − F D(ρ))⁻¹ F D(ε)."""
    return np.linalg.solve(np.eye(len(F)) - F * rho, F * eps)


@pytest.fixture
def furnace(cube: az.Scene) -> az.FormFactors:
    return az.form_factors(cube, patches=150, rays=64)


def of_cube() -> dict[str, float]:
    return dict(zip(faces_of_cube(), (0.9, 0.3, 0.05, 1.0, 0.6, 0.8), strict=True))


@pytest.mark.parametrize(("one", "two"), [(0.8, 0.5), (1.0, 1.0), (0.05, 0.9), (1e-6, 0.3)])
def test_large_plates(one: float, two: float) -> None:
    x = az.exchange(plates(), {"hot": one, "cold": two})
    assert x.names == ("hot", "cold") and len(x) == 2 and x.is_surface.all()
    expected = 2 / (1 / one + 1 / two - 1)
    assert np.isclose(x["hot", "cold"], expected, rtol=1e-12, atol=0)
    assert x[0, 1] == x["cold", "hot"] == x.GR[0, 1] and x["hot", "cold"].std_error == 0
    assert np.allclose(x.script_f * x.areas[:, None], x.GR, rtol=1e-15)
    assert np.allclose(x.emitting, [2 * one, 2 * two]) and x.areas.tolist() == [2, 2]
    assert not x.sky.any() and not x.ground.any() and repr(x) == "Exchange(2 nodes)"


@pytest.mark.parametrize(
    ("inner", "outer"), [(1, 4), (4 * np.pi, 9 * np.pi), (1, 1.0001), (1, 1e6)]
)
def test_one_body_inside_another(inner: float, outer: float) -> None:
    one, two = 0.7, 0.3
    x = az.exchange(shells(inner, outer), {"inner": one, "outer": two})
    expected = inner / (1 / one + inner / outer * (1 / two - 1))
    assert np.isclose(x["inner", "outer"], expected, rtol=1e-11, atol=0)


def test_published_enclosures() -> None:
    """Three surfaces by hand; a room of which EnergyPlus prints script F as 0.1565."""
    triangle = az.FormFactors((np.ones((3, 3)) - np.eye(3)) / 2, np.ones(3))
    x = az.exchange(triangle, {"0": 0.8, "1": 0.4, "2": 0.2})
    assert np.isclose(x.B[0, 1], 0.356234096692112, rtol=1e-13)
    wall = (1 - OPPOSITE) / 4
    F = [[0, OPPOSITE, 4 * wall], [OPPOSITE, 0, 4 * wall], [wall, wall, 1 - 2 * wall]]
    x = az.exchange(az.FormFactors(F, [1, 1, 4]), {"0": 0.9, "1": 0.5, "2": 0.1})
    assert np.isclose(x.B[0, 1], 0.319051333955934, rtol=1e-12)
    meshes = {name: (v * [4, 3, 2.5], f) for name, (v, f) in faces_of_cube().items()}
    f = az.form_factors(az.Scene(meshes), by="object", patch_size=0, tolerance=1e-10)
    script_f = az.exchange(f, 0.8).script_f[4, 2]
    assert abs(script_f - 0.156534400100001) < 1e-9


def test_mirrors_between_plates() -> None:
    """Each plate reflects as a mirror: the extended factors are geometric series."""
    one, two = 0.8, 0.5
    m, n = 1 - one, 1 - two
    both = 1 / (1 - m * n)
    f = az.FormFactors([[n * both, both], [both, m * both]], [1, 1], ["hot", "cold"], rho_s=[m, n])
    materials = {
        "hot": az.Material(eps=one, rho_s=m),
        "cold": {"eps": two, "rho_s": n},
    }
    x = az.exchange(f, materials)
    assert np.isclose(x["hot", "cold"], 1 / (1 / one + 1 / two - 1), rtol=1e-12)
    with pytest.raises(az.AzulejoError, match='mirror reflectance 0.2 of "hot", the materials'):
        az.exchange(f, 0.5)


def test_gebhart_factors_of_patches(furnace: az.FormFactors) -> None:
    eps = of_cube()
    f = furnace.close()
    x = az.exchange(f, eps, by="row")
    e = np.repeat(list(eps.values()), len(f) // 6)
    expected = gebhart(f.matrix.toarray(), e, 1 - e)
    assert len(x) == len(f) and abs(x.B - expected).max() < 1e-9
    assert abs(x.B.sum(axis=1) - 1).max() < 1e-8
    flow = (e * f.areas)[:, None] * x.B
    assert np.allclose(flow, flow.T, rtol=1e-9, atol=1e-15)
    assert (x.GR == x.GR.T).all() and np.allclose(x.GR, flow, rtol=1e-9, atol=1e-15)
    assert np.allclose(x.GR.sum(axis=1), x.emitting, rtol=1e-8) and x.asymmetry < 1e-10


def test_rows_of_a_node_have_their_own_radiosity(furnace: az.FormFactors) -> None:
    f, eps = furnace.close(), of_cube()
    fine, rows = az.exchange(f, eps), az.exchange(f, eps, by="row")
    assert fine.names == tuple(eps)
    node = f.object
    summed = np.zeros((6, 6))
    np.add.at(summed, (node[:, None], node[None, :]), rows.GR)
    assert np.allclose(fine.GR, summed, rtol=1e-9)
    lumped = az.exchange(f, eps, lump=True)
    e = np.array(list(eps.values()))
    expected = gebhart(f.group("object").matrix.toarray(), e, 1 - e)
    assert np.allclose(lumped.B, expected, rtol=1e-9)
    assert 1e-3 < abs(lumped.GR - fine.GR).max() < 0.05
    by_group = az.exchange(f.group("object"), eps)
    assert np.allclose(by_group.GR, lumped.GR, rtol=1e-12)
    material = az.exchange(f, 0.5, by="material")
    assert material.names == ("default",) and np.isclose(material.GR[0, 0], 3, rtol=1e-8)
    with pytest.raises(az.AzulejoError, match="cannot be lumped"):
        az.exchange(f, eps, by="material", lump=True)


def test_openings_are_black_nodes() -> None:
    meshes = faces_of_cube()
    del meshes["lid"]
    f = az.form_factors(az.Scene(meshes), by="object", patch_size=0, tolerance=1e-10)
    x = az.exchange(f, 0.4)
    assert x.names[:6] == (*meshes, "sky") and x.is_surface[4:6].tolist() == [True, False]
    assert (x.sky == x.B[:5, 5]).all() and (x.ground < 1e-6).all()
    assert np.allclose(x.B[:5].sum(axis=1), 1, atol=1e-7)
    assert x["sky", "floor"] == x["floor", "sky"] > 0
    # As if the opening had a black lid.
    whole = az.form_factors(az.Scene(faces_of_cube()), by="object", patch_size=0, tolerance=1e-10)
    closed = az.exchange(whole, {"lid": 1.0, "*": 0.4})
    assert np.allclose(x.GR[:5, 5], closed.GR[:5, 5], rtol=1e-5)
    upside_down = {n: (v * [1, 1, -1], f[:, ::-1]) for n, (v, f) in meshes.items()}
    f = az.form_factors(az.Scene(upside_down), by="object", patch_size=0, tolerance=1e-10)
    below = az.exchange(f, 0.4)
    assert below.names[-1] == "ground" and np.allclose(below.ground, x.sky, atol=1e-7)


def test_a_surface_called_sky() -> None:
    f = az.FormFactors([[0, 0.5], [0.5, 0]], [1, 1], ["sky", "sea"], open=True)
    x = az.exchange(f, 1.0)
    assert x.names == ("sky #0", "sea", "sky #2") and x.sky.tolist() == [0.5, 0.5]


def test_errors_follow_from_those_of_factors(cube: az.Scene) -> None:
    """The truth is that of the analytic engine; the noise that of few rays."""
    true = az.exchange(az.form_factors(cube, by="object", patch_size=0), of_cube())
    upper, ratios = np.triu_indices(6, 1), []
    for seed in range(12):
        noisy = {"formulas": False, "closure": False, "seed": seed}
        f = az.form_factors(cube, by="object", patches=6, rays=256, **noisy)
        x = az.exchange(f, of_cube())
        assert x["floor", "lid"].std_error == x.GR_error[4, 5] > 0
        ratios.append((x.GR - true.GR)[upper] / x.GR_error[upper])
        assert np.allclose(x.B_error * x.emitting[:, None], x.GR_error, rtol=1e-12)
        assert np.allclose(x.script_f_error * x.areas[:, None], x.GR_error, rtol=1e-12)
    # Neither too small nor by more than a factor too large: rays are spread more evenly than by chance.
    assert 0.4 < np.std(ratios) < 1 and (np.abs(ratios) > 2).mean() < 0.05


def test_bands_are_networks_of_their_own() -> None:
    materials = {
        "hot": az.Material(eps=BANDS, alpha=0.3),
        "cold": {"eps": {"0-4": 0.9, "4-inf": 0.4}, "alpha": 1},
    }
    x = az.exchange(plates(), materials)
    assert list(x.bands) == ["0-4", "4-inf"] and repr(x) == "Exchange(bands 0-4, 4-inf)"
    for band, hot, cold in [("0-4", 0.2, 0.9), ("4-inf", 0.8, 0.4)]:
        alone = az.exchange(plates(), {"hot": hot, "cold": cold})
        for name in ("GR", "B", "script_f", "GR_error"):
            mine, its = getattr(x.bands[band], name), getattr(alone, name)
            assert mine.tobytes() == its.tobytes(), name
    with pytest.raises(
        az.AzulejoError, match='several bands: choose one of .bands, "0-4", "4-inf"'
    ):
        _ = x.GR
    alone = az.exchange(plates(), 0.5)
    assert list(alone.bands) == [""] and (alone.bands[""].GR == alone.GR).all()


def test_bands_with_mirrors_of_their_own_take_their_matrix() -> None:
    both = 1 / (1 - 0.1 * 0.1)
    shiny = az.FormFactors(
        [[0.1 * both, both], [both, 0.1 * both]], [2, 2], ["hot", "cold"], rho_s=[0.1, 0.1]
    )
    material = az.Material(eps={"0-4": 0.9, "4-inf": 0.5}, rho_s={"0-4": 0.1, "4-inf": 0})
    x = az.exchange([plates(), shiny], material)
    assert np.isclose(x.bands["0-4"][0, 1], 2 / (2 / 0.9 - 1), rtol=1e-12)
    assert np.isclose(x.bands["4-inf"][0, 1], 2 / (2 / 0.5 - 1), rtol=1e-12)
    with pytest.raises(az.AzulejoError, match="in the band 0-4"):
        az.exchange(plates(), material)
    other = az.FormFactors([[0, 1], [1, 0]], [2, 2], ["hot", "warm"], rho_s=[0.1, 0.1])
    with pytest.raises(az.AzulejoError, match="its rows are not those of"):
        az.exchange([plates(), other], material)


def test_materials_of_the_scene_have_their_mirrors_in_the_factors() -> None:
    materials = {"lid": az.Material(eps=0.1, rho_s=0.9), "*": az.Material(eps=0.5)}
    scene = az.Scene(faces_of_cube(), materials)
    f = az.form_factors(scene, patches=54, rays=256)
    assert np.allclose(f.ends, np.where(f.object == 5, 0.1, 1.0))
    x = az.exchange(f)
    assert np.allclose(x.emitting, [0.5] * 5 + [0.1])
    assert (x.GR == az.exchange(f, materials).GR).all()
    for derived in (f.close(), f.truncate(0.001), f.group(f.object)):
        assert np.allclose(az.exchange(derived).emitting, x.emitting)


def test_materials_of_a_file(cube_file: Path, tmp_path: Path) -> None:
    table = tmp_path / "optics.csv"
    table.write_text("name,eps,rho_s\nlid,0.1,0.9\n*,0.5,\n")
    scene = az.load(cube_file, materials=table)
    f = az.form_factors(scene, patches=54, rays=256)
    same = az.Scene(faces_of_cube(), str(table), up=scene.up)
    g = az.form_factors(same, patches=54, rays=256)
    assert (az.exchange(f).GR == az.exchange(g, table).GR).all()
    table.write_text("name,eps\nlid,1.5\n")
    with pytest.raises(az.AzulejoError, match='optics.csv: line 2: eps of "lid" is 1.5'):
        az.load(cube_file, materials=table)
    table.write_bytes(b"name,eps\n\xff,1\n")
    with pytest.raises(az.AzulejoError, match="optics.csv: not a text in UTF-8"):
        az.exchange(f, table)
    with pytest.raises(FileNotFoundError):
        az.exchange(f, tmp_path / "none.csv")


def test_what_ends_on_backs_is_reported() -> None:
    floor = (np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [[0, 1, 2, 3]])
    lid = (floor[0] + [0, 0, 1], [[0, 1, 2, 3]])
    f = az.form_factors(az.Scene({"floor": floor, "lid": lid}), by="object", patch_size=0)
    with pytest.warns(UserWarning, match="19.98% of a row's light ends on backs.*lost_to_sky=True"):
        x = az.exchange(f, 1.0)
    assert np.isclose(x.B[0].sum(), 1 - OPPOSITE, atol=1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        x = az.exchange(f, 1.0, lost_to_sky=True)
    assert np.isclose(x.sky[0], 1, atol=1e-12)


def test_names_that_no_row_has_are_reported() -> None:
    with pytest.warns(UserWarning, match='no row has the name "nobody"') as caught:
        az.exchange(plates(), {"*": 0.5, "nobody": 0.1})
    assert caught[0].filename == __file__


def test_arrays_cannot_be_changed() -> None:
    x = az.exchange(plates(), 0.5)
    assert x.GR is x.GR and x.bands is x.bands
    for array in (x.GR, x.B, x.script_f, x.areas, x.emitting, x.is_surface, x.GR_error, x.sky):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_a_frame() -> None:
    x = az.exchange(plates(), 0.5)
    with pytest.raises(az.AzulejoError, match='unknown quantity "gr", expected "GR", "B"'):
        x.to_frame("gr")
    pytest.importorskip("pandas")
    assert x.to_frame("B").loc["hot", "cold"] == x.B[0, 1]


def test_files(tmp_path: Path, refuses) -> None:
    x = az.exchange(plates(), {"hot": az.Material(eps=BANDS), "cold": az.Material(eps=BANDS)})
    x.save(tmp_path / "gr.npz")
    arrays = np.load(tmp_path / "gr.npz")
    for band in x.bands:
        assert arrays[f"GR@{band}"].tobytes() == x.bands[band].GR.tobytes()
        assert arrays[f"B_error@{band}"].tobytes() == x.bands[band].B_error.tobytes()
        assert arrays[f"script_F@{band}"].tobytes() == x.bands[band].script_f.tobytes()
    assert arrays["names"].tolist() == ["hot", "cold"]
    x.save(tmp_path / "gr.csv")
    assert (tmp_path / "gr.csv").read_text().startswith("band_um,from,to,gr_m2,std_error\n0-4,hot,")
    refuses("its conductances are for one band", lambda: x.save(tmp_path / "gr.esatan"))
    x.bands["4-inf"].save(tmp_path / "gr.esatan", model="BOX")
    assert "GR(BOX:1, BOX:2)" in (tmp_path / "gr.esatan").read_text().replace("GR (", "GR(")
    x.bands["4-inf"].save(tmp_path / "gr.sinda", model="BOX", sigma=True, truncate=1e-6)
    refuses("unknown format, expected .npz", lambda: x.save(tmp_path / "gr.xls"))
    refuses("shows temperatures", lambda: x.save(tmp_path / "gr.vtu"))
    refuses("truncate is 2.0", lambda: x.save(tmp_path / "a.csv", truncate=2))
    refuses("No such file", lambda: x.save(tmp_path / "no" / "a.csv"), FileNotFoundError)
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "gr.csv",
        "gr.esatan",
        "gr.npz",
        "gr.sinda",
    ]


@pytest.mark.parametrize("of_model", [True, False])
@pytest.mark.parametrize("options", [{}, {"by": "row"}, {"by": "face", "lump": True}])
def test_the_command_gives_the_same_files(
    command: str, cube_file: Path, tmp_path: Path, options: dict, of_model: bool
) -> None:
    table = tmp_path / "optics.csv"
    table.write_text("name,eps,rho_s\nlid,0.1,0.9\n*,0.5,\n")
    f = az.form_factors(az.load(cube_file, materials=table), patches=54, rays=256)
    if of_model:
        arguments = ["exchange", cube_file, *"--patches 54 --rays 256".split()]
    else:
        f.save(tmp_path / "f.npz")
        arguments = ["exchange", tmp_path / "f.npz"]
        f = az.FormFactors.load(tmp_path / "f.npz")
    arguments += ["--materials", table, "-q"]
    for name, value in options.items():
        arguments += [f"--{name}"] if value is True else [f"--{name}", value]
    x = az.exchange(f, table, **options)
    for name in ("gr.npz", "gr.csv", "gr.esatan", "gr.sinda"):
        subprocess.run([command, *arguments, "-o", tmp_path / name], check=True)
        x.save(tmp_path / f"mine.{name}")
        assert (tmp_path / name).read_bytes() == (tmp_path / f"mine.{name}").read_bytes(), name


def test_what_is_refused(refuses) -> None:
    def call(materials: object, **options: object):
        return lambda: az.exchange(plates(), materials, **options)

    def both(**numbers: object):
        return call(az.Material(**numbers))

    refuses('eps of "*" is 1.5, expected 0 to 1', call(1.5))
    refuses('eps of "*" is -0.1, expected 0 to 1', call(-0.1))
    refuses("eps is nan", call(float("nan")))
    refuses("eps is inf", call({"*": np.inf}))
    refuses('nothing says the emissivity of "cold"', call({"hot": 0.5}))
    refuses("there are no materials", call({}))
    refuses("no emissivities are known", call(None))
    refuses("eps is 'high', expected a number", call(az.Material(eps="high")), TypeError)
    refuses('materials["*"] is a list', call([0.5, 0.5]), TypeError)
    refuses('materials["*"] is a bool', call(True), TypeError)
    refuses("a material is for 3, expected a name", call({3: 0.5}), TypeError)
    refuses("unexpected keyword argument 'epsilon'", call({"*": {"epsilon": 1}}), TypeError)
    refuses('eps + rho_s of "*" is 1.1', both(eps=0.8, rho_s=0.3))
    refuses('alpha of "*" is 7', both(eps=0.8, alpha=7))
    refuses("has no eps, the emissivity", both(alpha=0.5))
    refuses("has no eps, the emissivity", both(diffuse=0.5))
    refuses("leave a gap or overlap between 4 and 5", both(eps={(0, 4): 0.1, (5, np.inf): 0.1}))
    refuses("bands end at 4 µm", both(eps={(0, 4): 0.1}))
    refuses("is not a range of wavelengths", both(eps={(4, 0): 0.1}))
    refuses("a band of eps is 4, expected two wavelengths", both(eps={4: 0.1}), TypeError)
    refuses("leave a gap or overlap", both(eps=BANDS, rho_s={"0-2": 0.1}))
    refuses('unknown node "objects", did you mean "object"?', call(0.5, by="objects"))
    refuses("threads is 0", call(0.5, threads=0))
    refuses("factors is a int", lambda: az.exchange(3, 0.5), TypeError)
    refuses("factors has a int", lambda: az.exchange([plates(), 3], 0.5), TypeError)
    refuses("there are no form factors", lambda: az.exchange([], 0.5))
    x = az.exchange(plates(), 0.5)
    refuses('no node is named "tepid"; there are "hot", "cold"', lambda: x["hot", "tepid"])
    refuses("the node is 2, expected -2 to 1", lambda: x[0, 2])
    refuses("the node is a float", lambda: x[0, 0.5], TypeError)
    refuses("expected two nodes", lambda: x["hot"], TypeError)


def test_networks_that_do_not_fit_in_memory(furnace: az.FormFactors, refuses) -> None:
    def call(by: str, memory: str):
        return lambda: az.exchange(furnace, 0.5, by=by, memory=memory)

    refuses("a network of 150 nodes needs about 0.0 GiB", call("row", "1M"), MemoryError)
    assert len(call("object", "1M")()) == 6 and len(call("row", "8M")()) == 150


def test_materials_of_light_and_of_heat_do_not_mix(refuses) -> None:
    def scene(**numbers: object):
        return lambda: az.Scene(faces_of_cube(), az.Material(**numbers))

    refuses("eps takes the place of diffuse", scene(eps=0.5, diffuse=0.5))
    refuses("eps takes the place of diffuse", scene(eps=0.5, emission=1.0))
    refuses("rho_s and alpha stand beside eps", scene(rho_s=0.5))
    refuses("mirror reflectances differ from band to band", scene(eps=BANDS, rho_s={"0-4": 0.1}))


@pytest.mark.parametrize(
    ("product", "share"),
    [(1448, 0.01), (2897.771955, 0.250054547010999), (2898, 0.2501), (4107, 0.5), (5000, 0.6337)],
)
def test_band_fractions(product: float, share: float) -> None:
    """Howell, Mengüç, Daun, Siegel, Thermal Radiation Heat Transfer, appendix A."""
    digits = 1e-13 if share == 0.250054547010999 else 6e-5
    found = az.band_fraction(product)
    assert isinstance(found, float) and abs(found - share) < digits


def test_band_fractions_of_arrays(refuses) -> None:
    products = np.asfortranarray(np.linspace(0, 1e5, 12).reshape(3, 4))
    shares = az.band_fraction(products)
    assert shares.shape == (3, 4) and shares[0, 0] == 0 and (np.diff(shares.ravel()) > 0).all()
    assert shares[1, 2] == az.band_fraction(products[1, 2])
    assert az.band_fraction(np.inf) == 1 and az.band_fraction([]).shape == (0,)
    assert np.isnan(az.band_fraction([np.nan, 5000])).tolist() == [True, False]
    assert az.band_fraction(5000) == az.band_fraction(np.int64(5000)) == az.band_fraction(5e3)
    refuses("product is -1.0, expected 0 or more", lambda: az.band_fraction([3, -1]))
    refuses("product are of type", lambda: az.band_fraction("5000"))
    refuses("lists of different lengths", lambda: az.band_fraction([[1], [2, 3]]))
