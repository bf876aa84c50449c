"""Matrices in blocks, against whole ones and with SciPy."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import pyazulejo as az

linalg = pytest.importorskip("scipy.sparse.linalg")

ROWS = ("areas", "sky", "ground", "hidden", "ends", "object", "material", "centroids", "normals")


@pytest.fixture
def blocks(cube: az.Scene) -> az.CompressedFactors:
    """By formulas, of the whole matrix."""
    return az.form_factors(cube, patches=600, engine="analytic", compress=1e-4)


@pytest.fixture
def whole(cube: az.Scene) -> az.FormFactors:
    return az.form_factors(cube, patches=600, engine="analytic")


def test_products_are_those_of_the_matrix(
    blocks: az.CompressedFactors, whole: az.FormFactors
) -> None:
    n = len(whole)
    x = np.random.default_rng(1).random((n, 5))
    X = whole.matrix.toarray()
    close = {"rtol": 1e-3, "atol": 1e-9}
    assert blocks.shape == (n, n) and blocks.dtype == np.float64
    for f in (blocks, blocks.operator):
        assert np.allclose(f @ x[:, 0], X @ x[:, 0], **close)
        assert np.allclose(f.matvec(x[:, 0]), X @ x[:, 0], **close)
        assert np.allclose(f.rmatvec(x[:, 0]), X.T @ x[:, 0], **close)
        assert np.allclose(f.matmat(x), X @ x, **close)
        assert np.allclose(f.rmatmat(x), X.T @ x, **close)
        # Each column has the bits that it has alone, however it lies in memory.
        assert (f.matmat(np.asfortranarray(x))[:, 3] == f.matvec(x[:, 3].copy())).all()
    assert np.allclose(x.T @ blocks, x.T @ X, **close)
    assert np.allclose(blocks @ (1j * x[:, 0]), 1j * (X @ x[:, 0]), **close)
    assert isinstance(blocks.operator, linalg.LinearOperator)
    assert isinstance(linalg.aslinearoperator(blocks), linalg.LinearOperator)
    for name in ROWS:
        assert np.array_equal(getattr(blocks, name), getattr(whole, name)), name
    assert blocks.nbytes < blocks.whole_nbytes and blocks.traced_again == 0
    assert 0 < blocks.product_error < 1e-4 and blocks.product_error.std_error == 0
    assert sum(blocks.blocks.values()) > 0 and blocks.is_closed and blocks.tolerance == 1e-4
    assert np.allclose(blocks @ np.ones(n), 1, atol=1e-6) and blocks.row_sum_error < 1e-6


def test_scipy_solves_with_blocks(blocks: az.CompressedFactors, whole: az.FormFactors) -> None:
    """B = M + ρ X B: by GMRES, and in its symmetric form by conjugate gradients."""
    n, rho = len(whole), 0.7
    emitted = np.where(whole.object == 0, 1.0, 0.0)
    exact = np.linalg.solve(np.eye(n) - rho * whole.matrix.toarray(), emitted)
    system = linalg.LinearOperator((n, n), lambda b: b - rho * (blocks.operator @ b), dtype=float)
    found, failed = linalg.gmres(system, emitted, rtol=1e-10)
    assert failed == 0 and np.allclose(found, exact, rtol=1e-3)
    A = blocks.areas
    symmetric = linalg.LinearOperator((n, n), lambda b: A * (b - rho * (blocks @ b)), dtype=float)
    found, failed = linalg.cg(symmetric, A * emitted, rtol=1e-10)
    assert failed == 0 and np.allclose(found, exact, rtol=1e-3)


def test_rays_state_their_errors(cube: az.Scene, tmp_path: Path) -> None:
    f = az.form_factors(cube, patches=1500, rays=512, compress=1e-2, threads=1)
    again = az.form_factors(cube, patches=1500, rays=512, compress=1e-2, threads=2)
    exact = az.form_factors(cube, patches=1500, engine="analytic", compress=1e-6)
    x = np.random.default_rng(2).random(len(f))
    assert (f @ x == again @ x).all()
    found, errors = f.product_with_errors(x)
    off = found - exact @ x
    assert (abs(off) <= 2 * errors).mean() > 0.9
    norm = lambda y: np.sqrt((f.areas * y**2).sum())  # noqa: E731
    relative, stated = norm(off) / norm(found), f.product_error
    assert abs(relative - stated) < 4 * stated.std_error + 0.1 * relative
    assert f.traced_again == 1024 and f.rays >= 512 * len(f) and f.engine == "rays"
    f.save(tmp_path / "f.npz")
    back = az.CompressedFactors.load(tmp_path / "f.npz")
    assert (back @ x == found).all() and repr(back) == repr(f)
    assert back.product_error == stated and back.blocks == f.blocks
    with np.load(tmp_path / "f.npz") as z:
        assert z["format"] == b"blocks" and (np.sort(z["order"]) == np.arange(len(f))).all()


def test_groups_and_exchange(blocks: az.CompressedFactors, whole: az.FormFactors) -> None:
    a, b = blocks.group("object"), whole.group("object")
    assert a.names == b.names and np.allclose(a.matrix.toarray(), b.matrix.toarray(), atol=1e-6)
    labels = [None if k == 0 else k % 2 for k in whole.object.tolist()]
    a, b = blocks.group(labels), whole.group(labels)
    assert np.allclose(a.hidden, b.hidden, atol=1e-6)
    x, y = (az.exchange(f, 0.7)["floor", "lid"] for f in (blocks, whole))
    assert abs(x - y) < 1e-4 * y
    x, y = (az.radiosity(f, 0.7, T={"floor": 900, "lid": 300}, q={"*": 0}) for f in (blocks, whole))
    assert abs(x["floor"].Q - y["floor"].Q) < 1e-3 * y["floor"].Q


def test_what_makes_no_sense_is_refused(
    cube: az.Scene,
    blocks: az.CompressedFactors,
    tmp_path: Path,
    refuses: Callable[..., None],
) -> None:
    compute = az.form_factors
    refuses("compress is 2.0, expected", lambda: compute(cube, compress=2))
    refuses("compress", lambda: compute(cube, compress="x"), TypeError)  # type: ignore[call-overload]
    refuses("group() the result", lambda: compute(cube, "object", compress=1e-3))
    refuses("sum of all orders", lambda: compute(cube, separate=True, compress=1e-3))
    refuses("expected (", lambda: blocks @ np.ones(3))
    refuses("expected (", lambda: blocks.product_with_errors([1.0]))
    refuses("expected form_factors", lambda: az.CompressedFactors(3), TypeError)  # type: ignore[arg-type]
    small = {"patches": 1500, "engine": "analytic", "compress": 1e-3, "memory": "4M"}
    refuses("memory", lambda: compute(cube, **small), MemoryError)
    blocks.save(tmp_path / "f.npz")
    load = az.CompressedFactors.load
    refuses("CompressedFactors.load", lambda: az.FormFactors.load(tmp_path / "f.npz"))
    compute(cube, patches=50).save(tmp_path / "whole.npz")
    refuses("FormFactors.load", lambda: load(tmp_path / "whole.npz"))
    (tmp_path / "cut.npz").write_bytes((tmp_path / "f.npz").read_bytes()[:-100])
    refuses("cut.npz", lambda: load(tmp_path / "cut.npz"))
    refuses("none.npz", lambda: load(tmp_path / "none.npz"), FileNotFoundError)


def test_the_command_writes_the_same_bytes(
    cube_file: Path, command: str, tmp_path: Path
) -> None:
    options = "--patches 600 --rays 256 --compress 1e-3 --json"
    run = subprocess.run(
        [command, "form-factors", str(cube_file), "-o", str(tmp_path / "c.npz"), *options.split()],
        capture_output=True,
        text=True,
        check=True,
    )
    f = az.form_factors(az.load(cube_file), patches=600, rays=256, compress=1e-3)
    f.save(tmp_path / "p.npz")
    assert (tmp_path / "c.npz").read_bytes() == (tmp_path / "p.npz").read_bytes()
    assert json.loads(run.stdout)["product_error"] == f.product_error
