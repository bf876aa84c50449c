# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tests of the add-on inside Blender as a Python module (bpy). Without bpy, or without azulejo, they are skipped.

AZULEJO_COMMAND names the program; otherwise it is looked for on the search path.
"""

import os
import shutil
import sys
from pathlib import Path

import pytest

BLENDER = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(BLENDER), str(Path(__file__).parent)]
sys.dont_write_bytecode = True

try:
    import bpy
except ImportError:
    bpy = None

command = os.environ.get("AZULEJO_COMMAND")
if command:
    os.environ["PATH"] = os.pathsep.join([str(Path(command).resolve().parent), os.environ["PATH"]])

collect_ignore = [] if bpy else ["test_addon.py", "test_light.py"]


def pytest_collection_modifyitems(items: list) -> None:
    """Says what is missing."""
    why = None if shutil.which("azulejo") else "no azulejo: set AZULEJO_COMMAND"
    for item in items:
        if why and "program" in item.fixturenames:
            item.add_marker(pytest.mark.skip(reason=why))


def pytest_report_header() -> str:
    """Names the version, or what is missing."""
    return f"Blender {bpy.app.version_string}" if bpy else "no bpy: the Blender add-on is not tested"


if bpy:
    import azulejo

    azulejo.register()


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Without bpy there are no tests, which is no failure."""
    if not bpy and exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
        session.exitstatus = pytest.ExitCode.OK


def pytest_terminal_summary(terminalreporter) -> None:
    """Says it again where headers are not shown."""
    if not bpy:
        terminalreporter.write_line("no bpy: the Blender add-on is not tested")


def pytest_unconfigure() -> None:
    """Withdraws the add-on: bpy 4.5 does not end while classes are registered."""
    if bpy:
        azulejo.unregister()


@pytest.fixture
def empty():
    """A file without objects."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


@pytest.fixture
def program() -> str:
    """The path of azulejo."""
    return shutil.which("azulejo")
