"""Reflection models."""

from __future__ import annotations

import subprocess

import numpy as np

import pyazulejo as az


def test_lambert() -> None:
    wi, wo = az.directions([0, 30, 60]), az.directions(45, [0, 90, 180])
    assert np.allclose(az.brdf("diffuse kd=0.5", wi, wo), 0.5 / np.pi)
    assert az.brdf("diffuse kd=0.5", wi[:, None], wo).shape == (3, 3, 3)
    assert az.brdf("diffuse kd=0.5", wi[0], wo[0]).shape == (3,)
    assert np.allclose(az.brdf("diffuse kd=0.5", wi, quantity="albedo"), 0.5)
    assert (az.brdf("diffuse kd=0.5", [0, 0, 1], [0, 0, -1]) == 0).all()


def test_reciprocity_of_many_directions() -> None:
    random = np.random.default_rng(1)
    wi, wo = random.normal(size=(2, 10_000, 3))
    wi[:, 2], wo[:, 2] = abs(wi[:, 2]), abs(wo[:, 2])
    there = az.brdf("ward kd=0.2 ks=0.3 ax=0.2 ay=0.3", wi, wo, threads=2)
    assert np.allclose(there, az.brdf("ward kd=0.2 ks=0.3 ax=0.2 ay=0.3", wo, wi), rtol=1e-9)
    assert there.shape == (10_000, 3) and (there > 0).all()


def test_as_the_command(command: str) -> None:
    run = [
        command,
        "brdf",
        "eval",
        "ward",
        "kd=0.2",
        "ks=0.3",
        "ax=0.2",
        "ay=0.3",
        "--i",
        "30,0",
        "--o",
        "40,180",
        "-q",
    ]
    said = float(subprocess.run(run, check=True, capture_output=True, text=True).stdout.split()[0])
    mine = az.brdf("ward kd=0.2 ks=0.3 ax=0.2 ay=0.3", az.directions(30), az.directions(40, 180))
    assert np.allclose(mine, said, rtol=1e-11)


def test_what_is_refused(refuses) -> None:
    up = [0, 0, 1]
    refuses("no file of that name", lambda: az.brdf("wardd", up, up))
    refuses("parameter", lambda: az.brdf("ward kx=0.2", up, up))
    refuses('unknown quantity "f"', lambda: az.brdf("diffuse kd=0.5", up, up, quantity="f"))
    refuses("wo is missing", lambda: az.brdf("diffuse kd=0.5", up))
    refuses("zero or not finite", lambda: az.brdf("diffuse kd=0.5", up, [0, 0, 0]))
    refuses("expected (..., 3)", lambda: az.brdf("diffuse kd=0.5", up, [0, 1]))
    refuses("which do not fit", lambda: az.brdf("diffuse kd=0.5", [up] * 2, [up] * 3))
    refuses("", lambda: az.brdf("./missing.brdf", up, up), FileNotFoundError)
