"""Types and examples in documentation."""

from __future__ import annotations

import doctest
import subprocess
import sys
from functools import cached_property
from pathlib import Path

import pytest
from conftest import ROOT

import pyazulejo
from pyazulejo import _brdf, _compressed, _exchange, _form_factors, _materials, _points, _radiosity

HERE = Path(__file__).resolve().parents[1]


def run(*arguments: str) -> None:
    found = subprocess.run(
        [sys.executable, "-m", *arguments], cwd=HERE, capture_output=True, text=True
    )
    assert found.returncode == 0, found.stdout + found.stderr


def test_the_package_is_typed() -> None:
    pytest.importorskip("mypy")
    examples = sorted(str(p) for p in (ROOT / "examples" / "python").glob("*.py"))
    run("mypy", "--config-file", "pyproject.toml", "-p", "pyazulejo")
    for example in examples:
        run("mypy", "--config-file", "pyproject.toml", example)


def test_stubs_agree_with_the_compiled_half() -> None:
    pytest.importorskip("mypy")
    run("mypy.stubtest", "pyazulejo._pyazulejo", "--mypy-config-file", "pyproject.toml")


@pytest.mark.parametrize(
    "module",
    [pyazulejo, _brdf, _compressed, _exchange, _form_factors, _materials, _points, _radiosity],
)
def test_examples_of_the_documentation(module: object) -> None:
    tried, failed = 0, 0
    result = doctest.testmod(module)  # type: ignore[arg-type]
    failed, tried = result.failed, result.attempted
    assert failed == 0 and tried > 0


def test_everything_has_a_docstring() -> None:
    for name in pyazulejo.__all__:
        thing = getattr(pyazulejo, name)
        if name.startswith("__"):
            continue
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else ():
            if not member.startswith("_") and (
                callable(value) or isinstance(value, (property, cached_property, classmethod))
            ):
                assert value.__doc__, f"{name}.{member}"
