"""Long work: progress, Ctrl-C, threads, and an import that costs nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import pyazulejo as az

# Work of a minute or more.
LONG = {"patches": 3000, "rays": 100_000}


def test_progress_is_reported(cube: az.Scene) -> None:
    calls: list[tuple[float, float, str]] = []

    def progress(done: float, what: str) -> None:
        assert threading.current_thread() is threading.main_thread()
        calls.append((time.monotonic(), done, what))
        if len(calls) == 4:
            raise RuntimeError("seen enough")

    with pytest.raises(RuntimeError, match="seen enough"):
        az.form_factors(cube, **LONG, progress=progress)
    assert len(calls) == 4
    assert all(0 <= done <= 1 and what for _, done, what in calls)
    apart = np.diff([at for at, _, _ in calls])
    assert (apart > 0.095).all(), "more than ten calls a second"


def test_an_error_of_the_callback_ends_the_work(cube: az.Scene) -> None:
    class Enough(BaseException):
        pass

    def progress(done: float, what: str) -> None:
        raise Enough(what)

    start = time.monotonic()
    with pytest.raises(Enough):
        az.form_factors(cube, **LONG, progress=progress)
    assert time.monotonic() - start < 1.5


def test_a_bar(cube: az.Scene, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("tqdm")
    az.form_factors(cube, patches=600, rays=2048, progress=True)
    assert "%" in capsys.readouterr().err


def test_other_threads_go_on(cube: az.Scene) -> None:
    """The interpreter is free meanwhile, also for other work of ours."""
    results = []
    done = threading.Event()

    def work() -> None:
        results.append(az.form_factors(cube, patches=600, rays=1024))
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    turns = 0
    while not done.is_set():
        turns += 1
        time.sleep(0.005)
    thread.join()
    assert turns > 3 and len(results) == 1


CHILD = """
import sys, numpy as np, pyazulejo as az
sys.path.insert(0, sys.argv[1])
from conftest import faces_of_cube
scene = az.Scene(faces_of_cube(), az.Material(emission=1, diffuse=0.8), sky=1)
calls = {
    "form_factors": lambda: az.form_factors(scene, patches=3000, rays=100_000),
    "solve_light": lambda: az.solve_light(scene, patches=20_000, error=1e-4),
    "probe": lambda: az.probe(scene, np.full((3000, 3), 0.5), [0, 0, 1], error=1e-5),
    "render": lambda: az.render(scene, eye=(0.5, 0.5, 0.5), target=(0.5, 0.9, 0.5),
                                reference=True, samples=100_000),
    "point_factors": lambda: az.point_factors(scene, np.full((30_000, 3), 0.5), rays=100_000),
    "exchange": lambda: az.exchange(large, 0.01, by="row"),
    "radiosity": lambda: az.radiosity(large, 0.01, T=300, by="row"),
}
if sys.argv[2] in ("exchange", "radiosity"):
    large = az.FormFactors(np.full((4000, 4000), 1 / 4000), np.ones(4000))
print("ready", flush=True)
try:
    calls[sys.argv[2]]()
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize(
    "call",
    [
        "form_factors",
        "solve_light",
        "probe",
        "render",
        "point_factors",
        "exchange",
        "radiosity",
    ],
)
def test_ctrl_c(call: str) -> None:
    here = os.path.dirname(__file__)
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, here, call], stdout=subprocess.PIPE, text=True
    )
    assert child.stdout is not None and child.stdout.readline() == "ready\n"
    time.sleep(1.0)
    assert child.poll() is None, "it was over before it could be interrupted"
    start = time.monotonic()
    child.send_signal(signal.SIGINT)
    said = child.stdout.readline()
    took = time.monotonic() - start
    assert said == "interrupted\n" and took < 1.0, took
    assert child.wait(timeout=10) == 0


def test_import_brings_no_scipy() -> None:
    script = (
        "import sys, pyazulejo\n"
        "others = {'scipy', 'pandas', 'trimesh', 'meshio', 'pyvista', 'tqdm'} & set(sys.modules)\n"
        "assert not others, others\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
