"""Light: on all surfaces, at points, in images."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._checks import (
    division,
    facing,
    hemicubes,
    not_negative,
    optional_whole,
    positive,
    real,
    rows,
    share,
    vector,
    whole,
)
from ._checks import (
    memory as _memory,
)
from ._checks import (
    threads as _threads,
)
from ._progress import Progress, watching
from ._pyazulejo import AzulejoError, probe_irradiance, render_image
from ._pyazulejo import solve_light as _solve
from ._pyazulejo import tone_map as _tone_map
from ._scene import Scene


class Irradiance(NamedTuple):
    """Irradiance at points."""

    value: npt.NDArray[np.float64]
    """(n, 3), W/m², red, green and blue."""
    std_error: npt.NDArray[np.float64]
    """(n, 3), W/m²: the truth lies within two of them 95 times in 100."""
    report: Mapping[str, Any]
    """How it was computed: its method, error and energy balance."""


def solve_light(
    scene: Scene,
    *,
    error: float | None = None,
    rays: int | None = None,
    time: float | None = None,
    bounces: int | None = None,
    patches: int | None = None,
    patch_size: float | None = None,
    engine: str = "auto",
    sides: str = "auto",
    keep_mesh: bool = False,
    interpolate: bool = True,
    allow_imbalance: bool = False,
    resolution: int | None = None,
    patch_points: int | None = None,
    seed: int = 0,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Scene:
    """Solve the light of a scene for all viewpoints.

    Parameters
    ----------
    scene : Scene
        With something that emits: a :class:`Material`, lamps of a file, or a sky.
    error : float, optional
        Stop when the estimated error of the irradiance is below this share of its mean; by default
        0.03, with at most 2,048 rays for each vertex.
    rays : int, optional
        Rays from each patch, and at most as many from each vertex.
    time : float, optional
        Seconds after which refinement ends.
    bounces : int, optional
        Number of diffuse reflections; by default until they have died out.
    patches, patch_size
        How finely surfaces are divided, as for :func:`form_factors`.
    engine : {"auto", "rays", "hemicube", "hybrid", "analytic", "particles"}, optional
        How form factors between patches are computed.
    sides : {"auto", "front", "brighter", "split", "unturned"}, optional
        Which side's irradiance surfaces store.
    keep_mesh : bool, optional
        Whether irradiance is stored on the given vertices, in place of those of the patches.
    interpolate : bool, optional
        Whether indirect light is interpolated where there are thousands of vertices.
    allow_imbalance : bool, optional
        Whether light is returned of which more than a tenth is unaccounted for.
    resolution, patch_points, seed, memory, threads, progress
        As for :func:`form_factors`; of memory, half of the machine's by default.

    Returns
    -------
    Scene
        The scene with light: :meth:`Scene.mesh` has it, :func:`render` shows it, and
        :attr:`Scene.report` says how large its error is.
    """
    options = _options(locals())
    with watching(progress) as callback:
        lit, report = _solve(_native(scene), options, _threads(threads), callback)
    return Scene._of(lit, report, scene._table)


def probe(
    scene: Scene,
    points: npt.ArrayLike,
    normals: npt.ArrayLike,
    *,
    error: float | None = None,
    rays: int | None = None,
    time: float | None = None,
    bounces: int | None = None,
    patches: int | None = None,
    patch_size: float | None = None,
    engine: str = "auto",
    interpolate: bool = True,
    allow_imbalance: bool = False,
    resolution: int | None = None,
    patch_points: int | None = None,
    seed: int = 0,
    memory: int | str | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> Irradiance:
    """Irradiance at points, as light meters there would measure it.

    Parameters
    ----------
    scene : Scene
        As for :func:`solve_light`. Light that it carries is ignored.
    points : array_like (n, 3)
        Scene units.
    normals : array_like (n, 3) or (3,)
        Directions that the receivers face, of any length; one for all.
    error, rays, time, bounces, patches, patch_size, engine, interpolate, allow_imbalance, resolution, \
patch_points, seed, memory, threads, progress
        As for :func:`solve_light`.

    Returns
    -------
    Irradiance
        ``value`` and ``std_error`` (n, 3), W/m².
    """
    options = _options({**locals(), "sides": "auto", "keep_mesh": False})
    places = rows("points", points)
    directions = facing(normals, places)
    with watching(progress) as callback:
        found = probe_irradiance(
            _native(scene), places, directions, options, _threads(threads), callback
        )
    return Irradiance(*found)


def render(
    scene: Scene,
    *,
    camera: str | None = None,
    eye: npt.ArrayLike | None = None,
    target: npt.ArrayLike | None = None,
    up: npt.ArrayLike | None = None,
    fov: float | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    gather: int | None = None,
    clamp: float | None = None,
    reference: bool = False,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = None,
) -> npt.NDArray[np.float32]:
    """Render an image of a scene.

    Parameters
    ----------
    scene : Scene
        With light from :func:`solve_light`; otherwise that is called first.
    camera : str, optional
        Name of a camera of the scene; by default its first, or a view of all of it.
    eye, target, up : array_like (3,), optional
        Where the viewer is, what is in the middle of the image, and what points up in it.
    fov : float, optional
        Vertical field of view, degrees.
    size : (int, int), optional
        Width and height in pixels; by default 512 × 512.
    samples : int, optional
        Samples of a pixel, by default 16, or 256 of a reference.
    gather : int, optional
        Rays of a final gather at every point that is seen; 0 for none; by default 16 rays where light
        is uneven.
    clamp : float, optional
        Most radiance that one sample may add by reflections, against bright dots.
    reference : bool, optional
        Whether to trace paths, without the light that the scene carries: slow, and without bias.
    seed, threads, progress
        As for :func:`form_factors`.

    Returns
    -------
    ndarray (height, width, 3) of float32
        Linear radiance, W/(sr·m²), rows from the top. :func:`tone_map` makes it visible.
    """
    view = {
        "camera": camera,
        "eye": vector("eye", eye),
        "target": vector("target", target),
        "up": vector("up", up),
        "fov": _fov(fov),
        "size": _size(size),
    }
    how = {
        "samples": optional_whole("samples", samples),
        "gather": optional_whole("gather", gather, 0, 1_000_000),
        "clamp": positive("clamp", clamp),
        "seed": whole("seed", seed, 0, 2**64 - 1),
        "reference": bool(reference),
    }
    native = _native(scene)
    if not (native.is_solved or reference):
        native = solve_light(scene, seed=seed, threads=threads, progress=progress)._native
    with watching(progress) as callback:
        return render_image(native, view, how, _threads(threads), callback)


def tone_map(
    radiance: npt.ArrayLike, *, exposure: float | None = None, tone: str = "reinhard"
) -> npt.NDArray[np.uint8]:
    """Make radiance visible.

    Parameters
    ----------
    radiance : array_like (height, width, 3)
        Of :func:`render`.
    exposure : float, optional
        Stops by which it is brightened; by default what suits the image.
    tone : {"reinhard", "filmic", "linear"}, optional
        The curve that bright places follow.

    Returns
    -------
    ndarray (height, width, 3) of uint8
        sRGB.
    """
    image = np.ascontiguousarray(radiance, dtype=np.float32)
    if image.ndim != 3 or image.shape[2] != 3:
        raise AzulejoError(f"radiance has the shape {image.shape}, expected (height, width, 3)")
    return _tone_map(image, None if exposure is None else real("exposure", exposure), tone)


def _native(scene: Scene) -> Any:
    if not isinstance(scene, Scene):
        raise TypeError(f"scene is a {type(scene).__name__}, expected a Scene (see load)")
    return scene._native


def _options(given: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of the solver, checked."""
    return {
        "engine": given["engine"],
        **division(given["patches"], given["patch_size"]),
        "error": share("error", given["error"]),
        "rays": optional_whole("rays", given["rays"]),
        "bounces": optional_whole("bounces", given["bounces"], 0),
        "time": positive("time", given["time"]),
        "seed": whole("seed", given["seed"], 0, 2**64 - 1),
        "memory": _memory(given["memory"]),
        "sides": given["sides"],
        "keep_mesh": bool(given["keep_mesh"]),
        "interpolate": bool(given["interpolate"]),
        "allow_imbalance": bool(given["allow_imbalance"]),
        **hemicubes(given["resolution"], given["patch_points"]),
    }


def _fov(fov: float | None) -> float | None:
    angle = not_negative("fov", fov)
    if angle is not None and not 0 < angle < 180:
        raise AzulejoError(f"fov is {angle} degrees, expected between 0 and 180")
    return angle


def _size(size: tuple[int, int] | None) -> tuple[int, int] | None:
    if size is None:
        return None
    try:
        width, height = size
    except (TypeError, ValueError):
        raise TypeError(f"size is {size!r}, expected a width and a height") from None
    return whole("width", width, 1, 65_536), whole("height", height, 1, 65_536)
