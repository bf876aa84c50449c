"""Matrices of other programs, and files."""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import OPPOSITE, ROOT, faces_of_cube

import pyazulejo as az

sparse = pytest.importorskip("scipy.sparse")

PLATES = [[0, 1], [1, 0]]
ARRAYS = ("areas", "sky", "sky_error", "ground", "ground_error", "hidden", "hidden_error", "cut", "lost")


def triangle(**more: object) -> az.FormFactors:
    """A duct of sides 3, 4 and 5: F₁₂ = (A₁ + A₂ − A₃) / 2A₁."""
    F = np.array([[0, 2 / 6, 4 / 6], [2 / 8, 0, 6 / 8], [4 / 10, 6 / 10, 0]])
    return az.FormFactors(F, [3, 4, 5], ["a", "b", "c"], **more)


def test_a_matrix_of_another_program() -> None:
    f = triangle()
    assert f.names == ("a", "b", "c") and f.shape == (3, 3) and len(f) == 3
    assert np.isclose(f["a", "b"], 1 / 3) and f["a", "b"].std_error == 0 == f["a", "a"]
    assert f.areas.tolist() == [3, 4, 5] and f.asymmetry < 1e-15 and f.is_closed
    assert np.allclose(f @ np.ones(3), 1, atol=1e-15)
    x = np.array([1.0, 2, 3])
    assert np.allclose(f @ x, f.matrix.toarray() @ x)
    assert np.allclose(x @ f, x @ f.matrix.toarray())
    assert np.allclose(f @ np.eye(3), f.matrix.toarray())
    assert np.allclose((f @ sparse.csr_array(np.eye(3))).toarray(), f.matrix.toarray())
    assert f.engine == "given" and repr(f) == "FormFactors(3 groups, by given)"
    assert f.irradiance is None and f.closed is None and f.rays == 0
    assert az.FormFactors(PLATES, [1, 1]).names == ("0", "1")


def test_matrices_of_all_kinds() -> None:
    F = np.array([[0, 0.25, 0.5], [0.25, 0.5, 0], [0.5, 0, 0.25]])
    read_only = F.astype(np.float32)
    read_only.flags.writeable = False
    i, j = np.nonzero(F)
    halves = np.tile(F[i, j] / 2, 2)
    twice = sparse.coo_array((halves, (np.tile(i, 2), np.tile(j, 2))), shape=(3, 3))
    kinds = [
        F.tolist(),
        np.asfortranarray(F),
        F[::-1][::-1],
        read_only,
        sparse.csr_array(F),
        sparse.csc_matrix(F),
        sparse.lil_array(F),
        twice,
    ]
    for kind in kinds:
        f = az.FormFactors(kind, np.array([2, 2, 2]))
        assert f.matrix.toarray().tolist() == F.tolist() and f.matrix.nnz == 6
    whole = az.FormFactors(np.array([[0, 1], [1, 0]], dtype=np.uint8), (1, 1))
    assert whole.matrix.toarray().tolist() == PLATES
    columns = sparse.csr_array(([0.7, 0.3, 0.2, 0.7], [1, 0, 1, 0], [0, 2, 4]), shape=(2, 2))
    f = az.FormFactors(columns, [1, 1])
    assert f.matrix.indices.tolist() == [0, 1, 0, 1] and f.matrix.data.tolist() == [
        0.3,
        0.7,
        0.7,
        0.2,
    ]


def test_the_mean_of_both_directions_is_taken() -> None:
    with pytest.warns(UserWarning, match="differ by up to 0.1 of the smaller area") as caught:
        f = az.FormFactors([[0, 0.9], [0.5, 0]], [1, 2])
    assert caught[0].filename == __file__ and np.isclose(f.asymmetry, 0.1)
    assert np.allclose(f.matrix.toarray(), [[0, 0.95], [0.475, 0]])
    with pytest.warns(UserWarning, match="differ by up to 1 "):
        f = az.FormFactors([[0, 1], [0, 0]], [1, 1])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        az.FormFactors([[0, 1], [1 - 1e-6, 0]], [1, 1])


def test_what_rows_lack() -> None:
    F = np.array([[0, 0.5], [0.25, 0.5]])
    f = az.FormFactors(F, [1, 2])
    assert not f.sky.any() and f.is_closed
    closed = f.close()
    assert np.allclose(closed @ np.ones(2), 1, atol=1e-8)
    assert closed.closed is not None and closed.closed["most"] > 0.4
    s = closed.matrix.toarray() * [[1], [2]]
    assert np.allclose(s, s.T, rtol=1e-14)
    opened = az.FormFactors(F, [1, 2], open=True)
    assert opened.sky.tolist() == [0.5, 0.25] and not opened.is_closed
    assert np.allclose(opened.close().matrix.toarray(), F) and opened.close().closed["total"] < 1e-9
    some = az.FormFactors(F, [1, 2], open=[0.4, 0.25])
    assert np.allclose(some.close() @ np.ones(2) + some.close().sky, 1, atol=1e-8)


def test_extended_factors_of_mirrors() -> None:
    both = 1 / (1 - 0.06)
    f = az.FormFactors([[0.3 * both, both], [both, 0.2 * both]], [1, 1], rho_s=[0.2, 0.3])
    assert np.allclose(f.ends, [0.8, 0.7]) and np.allclose(f @ f.ends, 1)


def test_groups_and_truncation(refuses) -> None:
    f = triangle()
    two = f.group({"a": "walls", "b": "walls", "c": "floor"})
    assert two.names == ("walls", "floor") and np.isclose(two["floor", "walls"], 1)
    assert np.isclose(two["walls", "walls"], 2 / 7)
    assert f.group([7, 7, None]).names == ("7",)
    assert np.isclose(f.group([7, 7, None]).hidden[0], 5 / 7)
    small = az.FormFactors([[0.01, 0.99], [0.99, 0.01]], [1, 1]).truncate(0.05)
    assert small.matrix.nnz == 2 and np.allclose(small @ np.ones(2), 1)
    refuses("rows without geometry are of no face", lambda: f.group("object"))
    refuses('no label for "c"', lambda: f.group({"a": 1, "b": 2}))
    refuses("2 labels for 3 rows", lambda: f.group([1, 2]))
    refuses("unhashable", lambda: f.group([[1], [2], [3]]), TypeError)
    refuses("share is None", lambda: f.truncate(None), TypeError)
    refuses("share is 0.0, expected more than 0", lambda: f.truncate(0))
    refuses("share is nan", lambda: f.truncate(float("nan")))


def test_what_is_refused(refuses) -> None:
    def call(F: object = PLATES, areas: object = (1, 1), *more: object, **options: object):
        return lambda: az.FormFactors(F, areas, *more, **options)

    refuses("F has the shape (2, 2), expected (3, 3)", call(areas=[1, 1, 1]))
    refuses("F has the shape (2,), expected (2, 2)", call([1, 2]))
    refuses("F has the shape (2, 2, 2), expected (2, 2)", call(np.zeros((2, 2, 2))))
    refuses("F has the shape (2, 3), expected (2, 2)", call(sparse.csr_array((2, 3))))
    refuses("F are lists of different lengths", call([[1], [1, 2]]))
    refuses("F are of type bool", call(np.eye(2, dtype=bool)))
    refuses("F are of type complex", call(np.eye(2, dtype=complex)))
    refuses("F are of type <U", call("matrix"))
    refuses("F[0, 1] is nan, expected finite numbers", call([[0, np.nan], [1, 0]]))
    refuses("F[1, 0] is -0.1, expected finite numbers", call([[0, 1], [-0.1, 0]]))
    refuses("F[1, 1] is inf", call(sparse.csr_array([[0, 1], [0, np.inf]])))
    refuses("row 1 of F has the sum 1.5", call([[0, 1], [1, 0.5]]))
    refuses("is it transposed, or does it hold A F?", call([[0, 1], [4, 0]]))
    refuses("areas have the shape (0,)", call([], []))
    refuses("areas have the shape (1, 2)", call(areas=[[1, 1]]))
    refuses("areas: row 1 has nan", call(areas=[1, np.nan]))
    refuses("areas: row 0 has -1.0", call(areas=[-1, 1]))
    refuses("areas: row 1 has 0, expected more", call(areas=[1, 0]))
    refuses("areas: row 1 has inf", call(areas=[1, np.inf]))
    refuses('two rows are named "a"', call(PLATES, (1, 1), ["a", "a"]))
    refuses("1 names for 2 rows", call(PLATES, (1, 1), "ab"))
    refuses("a row is named 2, expected a text", call(PLATES, (1, 1), ["a", 2]), TypeError)
    refuses("open have the shape (1,), expected (2,)", call(open=0.5))
    refuses("open: row 1 has 2.0, expected 0 to 1", call(open=[0, 2]))
    refuses("rho_s: row 0 has -1.0, expected 0 to 1", call(rho_s=[-1, 0]))
    refuses('unknown unit "parsec"', call(unit="parsec"))
    for name, k, value in [
        ("indices", 0, 7),
        ("indptr", 1, 9),
        ("indptr", 0, -3),
        ("indptr", 2, 1),
    ]:
        damaged = sparse.csr_array(np.full((2, 2), 0.5))
        getattr(damaged, name)[k] = value
        refuses("F is a damaged matrix", call(damaged))
    f = triangle()
    refuses("the row is 3, expected -3 to 2", lambda: f[3, 0])
    refuses("the row is 18446744073709551616", lambda: f[2**64, 0])
    refuses("the row is a float", lambda: f[0.0, 0], TypeError)
    refuses('no row is named "d"; there are "a", "b", "c"', lambda: f["a", "d"])
    refuses("given without geometry, so its rows have no corners", lambda: f.centroids)


@pytest.mark.parametrize(
    "options",
    [{}, {"separate": True}, {"by": "object"}, {"two_sided": True}, {"closure": True}],
)
def test_round_trips(tmp_path: Path, options: dict) -> None:
    """Factors come back to the last bit but one, everything else to the last."""
    scene = az.load(ROOT / "examples" / "cornell-mirror.grf")
    f = az.form_factors(scene, patches=100, rays=64, **options)
    path = tmp_path / "f.npz"
    assert f.save(path) == (str(path),)
    g = az.FormFactors.load(path)
    assert np.allclose(g.matrix.data, f.matrix.data, rtol=1e-15, atol=0)
    assert np.allclose(g.std_error.data, f.std_error.data, rtol=1e-6, atol=0)
    assert np.allclose(g.ends, f.ends, rtol=1e-15, atol=1e-15)
    assert (g.matrix.indices == f.matrix.indices).all() and g.asymmetry < 1e-15
    arrays = [*ARRAYS, "row_error", "object", "face", "material", "is_back"]
    if f.names is None:
        arrays += ["corners", "corner_offsets", "centroids", "normals"]
    for name in arrays:
        assert getattr(g, name).tobytes() == getattr(f, name).tobytes(), name
    for name in ("names", "is_closed", "engine", "rays", "shape"):
        assert getattr(g, name) == getattr(f, name), name
    if options.get("separate"):
        for mine, theirs in zip(g.orders, f.orders, strict=True):
            assert np.allclose(mine.data, theirs.data, rtol=1e-15, atol=0)
    again = tmp_path / "again.npz"
    g.save(str(again))
    h = az.FormFactors.load(str(again))
    assert h.matrix.data.tobytes() == g.matrix.data.tobytes()
    assert (h.group("object").matrix != g.group("object").matrix).nnz == 0


def test_matrices_of_other_programs_come_back(tmp_path: Path) -> None:
    f = triangle(open=[0, 0.1, 0])
    f.save(tmp_path / "f.npz")
    g = az.FormFactors.load(tmp_path / "f.npz")
    assert g.names == f.names and g.engine == "given" and g.sky.tolist() == [0, 0.1, 0]
    assert g.matrix.data.tobytes() == f.matrix.data.tobytes()
    # As SciPy has them, with areas beside.
    m = sparse.csr_array(np.array([[0, 0.5], [0.25, 0]]))
    sparse.save_npz(tmp_path / "m.npz", m)
    parts = dict(np.load(tmp_path / "m.npz"))
    np.savez(tmp_path / "m.npz", **parts, areas=[1.0, 2.0])
    h = az.FormFactors.load(tmp_path / "m.npz")
    assert h.names == ("0", "1") and h.matrix.toarray().tolist() == m.toarray().tolist()
    assert repr(h) == "FormFactors(2 groups, by given)"
    np.savez(tmp_path / "m.npz", **{**parts, "areas": [1.0, 3.0]})
    with pytest.warns(UserWarning, match="differ by up to 0.25 of the smaller area"):
        assert az.FormFactors.load(tmp_path / "m.npz").asymmetry == 0.25


def test_precision(tmp_path: Path) -> None:
    f = triangle()
    for precision, kind in [("auto", np.float64), ("double", np.float64), ("single", np.float32)]:
        f.save(tmp_path / "f.npz", precision=precision)
        assert np.load(tmp_path / "f.npz")["data"].dtype == kind
    close = az.FormFactors.load(tmp_path / "f.npz").matrix.data
    assert np.allclose(close, f.matrix.data, rtol=1e-7, atol=0)


def test_damaged_files(tmp_path: Path, refuses) -> None:
    whole, path = tmp_path / "whole.npz", tmp_path / "damaged.npz"
    triangle().save(whole)
    bytes_ = whole.read_bytes()
    for length in range(0, len(bytes_), 97):
        path.write_bytes(bytes_[:length])
        refuses("damaged.npz: ", lambda: az.FormFactors.load(path))
    arrays = dict(np.load(whole))

    def damaged(**changed: object):
        np.savez(path, **{k: v for k, v in {**arrays, **changed}.items() if v is not None})
        return lambda: az.FormFactors.load(path)

    refuses('there is no array "areas"', damaged(areas=None))
    refuses("areas: its shape is", damaged(areas=np.ones(2)))
    refuses("areas: inf, expected finite", damaged(areas=np.array([1, 2, np.inf])))
    refuses("areas: NaN, expected 0 or more", damaged(areas=np.array([1, 2, np.nan])))
    refuses("indices: beyond the 3 columns", damaged(indices=np.array([1, 2, 0, 2, 0, 3])))
    refuses("indices: beyond", damaged(indices=np.array([1, 2, 0, 2, 0, 2**40])))
    refuses("indices: beyond", damaged(indices=np.array([1, 2, 0, 2, 0, -1])))
    refuses("indptr: not the starts", damaged(indptr=np.array([0, 4, 2, 6])))
    refuses("indptr: not the starts", damaged(indptr=np.array([0, 2, 4, 2**62])))
    refuses("expected a square matrix", damaged(shape=np.array([3, 4])))
    refuses("expected a square matrix", damaged(shape=np.array([2**62, 2**62])))
    refuses("data, std_error: not one number", damaged(data=np.ones(5)))
    refuses("is NaN, expected a finite number", damaged(data=np.full(6, np.nan)))
    refuses('format: "coo", expected "csr"', damaged(format=np.array(b"coo")))
    refuses("rho_s[0] is 2, expected 0 to 1", damaged(rho_s=np.array([2.0, 0, 0])))
    refuses("names: 2, expected one for each", damaged(names=np.array(["a", "b"])))
    path.write_text("not a zip")
    refuses("damaged.npz: ", lambda: az.FormFactors.load(path))
    refuses("No such file", lambda: az.FormFactors.load(tmp_path / "none.npz"), FileNotFoundError)
    refuses("is a folder", lambda: az.FormFactors.load(tmp_path), IsADirectoryError)
    refuses("memory is 5, expected", lambda: az.FormFactors.load(whole, memory=5))


def test_a_file_that_does_not_fit_in_memory(tmp_path: Path, refuses) -> None:
    f = az.form_factors(az.Scene(faces_of_cube()), patches=600, rays=256)
    f.save(tmp_path / "f.npz")
    refuses("f.npz: ", lambda: az.FormFactors.load(tmp_path / "f.npz", memory="1M"))
    assert len(az.FormFactors.load(tmp_path / "f.npz", memory="1G")) == 600


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("f.npz", ""),
        ("f.csv", ""),
        ("f.txt", ""),
        ("f.vf", ""),
        ("f.vtu", ""),
        ("f.idf", ""),
        ("f.epjson", ""),
        ("f.vwf", ""),
        ("f.dat", ""),
        ("f.i", ""),
        ("f.mtx", ""),
        ("f.bdf", ""),
        ("vfsparse.inp.001", "--format udales"),
    ],
)
def test_the_command_writes_the_same_files(
    command: str, cube_file: Path, tmp_path: Path, name: str, arguments: str
) -> None:
    theirs, mine = tmp_path / "theirs", tmp_path / "mine"
    theirs.mkdir()
    mine.mkdir()
    how = "--by face --patches 54 --rays 64 -q".split()
    subprocess.run(
        [command, "form-factors", cube_file, "-o", theirs / name, *how, *arguments.split()],
        check=True,
        capture_output=True,
    )
    f = az.form_factors(az.load(cube_file), by="face", patches=54, rays=64)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        written = f.save(mine / name, *arguments.split()[1:])
    assert sorted(Path(p).name for p in written) == sorted(p.name for p in theirs.iterdir())
    for path in written:
        assert Path(path).read_bytes() == (theirs / Path(path).name).read_bytes(), path


def test_matrix_market(tmp_path: Path) -> None:
    f = triangle()
    f.save(tmp_path / "f.mtx")
    read = pytest.importorskip("scipy.io").mmread(tmp_path / "f.mtx")
    assert np.allclose(read.toarray(), f.matrix.toarray(), rtol=1e-8)


def test_meshes_for_paraview(cube: az.Scene, tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    f = az.form_factors(cube, patches=54, rays=256, closure=True)
    f.save(tmp_path / "f.vtu")
    mesh = pyvista.read(tmp_path / "f.vtu")
    assert mesh.n_cells == len(f) and np.isclose(mesh.area, 6)
    groups = f.group("object")
    groups.save(tmp_path / "g.vtu", rows="lid")
    mesh = pyvista.read(tmp_path / "g.vtu")
    seen = mesh.cell_data["F_from_lid"]
    assert mesh.n_cells == 54 and np.isclose(
        sorted(set(seen))[-1], groups.matrix.toarray()[5].max()
    )
    assert abs(seen.min()) == 0
    lower = mesh.cell_centers().points[:, 2] < 1e-9
    assert (
        np.allclose(seen[lower], groups["lid", "floor"]) and abs(seen[lower][0] - OPPOSITE) < 0.02
    )


def test_what_cannot_be_written(cube: az.Scene, tmp_path: Path, refuses) -> None:
    f = az.form_factors(cube, patch_size=0)

    def save(name: str, *more: object, **options: object):
        return lambda: f.save(tmp_path / name, *more, **options)

    refuses("f.xls: unknown matrix format, expected .npz", save("f.xls"))
    refuses("f.zarr: stores in chunks", save("f.zarr"))
    refuses("f.zarr: stores in chunks", lambda: az.FormFactors.load(tmp_path / "f.zarr"))
    refuses('format="openfoam" writes to the folder of a case', save(""))
    refuses('unknown format "npy", did you mean "npz"?', save("f.npz", "npy"))
    refuses('unknown precision "half"', save("f.npz", precision="half"))
    refuses("constant/polyMesh/boundary", save("", "openfoam"))
    refuses('unknown version of OpenFOAM "latest"', save("", "openfoam", version="latest"))
    refuses("No such file", save("no/f.npz"), FileNotFoundError)
    refuses("roof", save("f.vtu", rows=["roof"]))
    refuses("expected str", lambda: f.save(3), TypeError)
    given = triangle()
    refuses("the matrix has no polygons", lambda: given.save(tmp_path / "f.vtu"))
    assert list(tmp_path.iterdir()) == []
    with pytest.warns(UserWarning, match="the zone is named") as caught:
        f.save(tmp_path / "f.idf")
    assert caught[0].filename == __file__


def test_frames(monkeypatch: pytest.MonkeyPatch, refuses) -> None:
    f = triangle()
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "pandas", None)
        refuses("a frame needs pandas: pip install pandas", f.to_frame, ImportError)
        refuses("a frame needs pandas", az.exchange(f, 0.5).to_frame, ImportError)
    pytest.importorskip("pandas")
    frame = f.to_frame()
    assert frame.loc["a", "b"] == f["a", "b"] and frame.index.tolist() == ["a", "b", "c"]
    patches = az.form_factors(az.Scene(faces_of_cube()), patch_size=0).to_frame()
    assert patches.columns.tolist() == list(range(6)) and np.isclose(patches.loc[4, 5], OPPOSITE)


def test_missing_packages_are_named(monkeypatch: pytest.MonkeyPatch, refuses) -> None:
    f = az.form_factors(az.Scene(faces_of_cube()), patch_size=0)
    heat = az.radiosity(f, 0.5, T=300)
    for name in ("scipy.sparse", "pyvista"):
        monkeypatch.setitem(sys.modules, name, None)
    refuses("sparse matrices need SciPy: pip install scipy", lambda: f.matrix, ImportError)
    refuses("a mesh needs pyvista: pip install pyvista", heat.to_pyvista, ImportError)
    assert f[4, 5] > 0 and az.exchange(f, 0.5).GR.shape == (6, 6)
