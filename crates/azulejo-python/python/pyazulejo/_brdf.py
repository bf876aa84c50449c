"""Reflection models."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ._checks import numbers
from ._checks import threads as _threads
from ._pyazulejo import AzulejoError, evaluate_brdf


def directions(theta: npt.ArrayLike, phi: npt.ArrayLike = 0.0) -> npt.NDArray[np.float64]:
    """Unit vectors of angles.

    Parameters
    ----------
    theta : array_like
        Angles to the normal, degrees.
    phi : array_like, optional
        Angles about the normal from the x axis, degrees; broadcast with `theta`.

    Returns
    -------
    ndarray (..., 3)
        Vectors away from the surface, whose normal is z.
    """
    theta, phi = np.broadcast_arrays(np.radians(theta), np.radians(phi))
    sine = np.sin(theta)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), np.cos(theta)], axis=-1)


def brdf(
    model: str,
    wi: npt.ArrayLike,
    wo: npt.ArrayLike | None = None,
    *,
    quantity: str = "brdf",
    threads: int | None = None,
) -> npt.NDArray[np.float64]:
    """Evaluate a reflection model for many directions at once.

    Parameters
    ----------
    model : str
        As for ``azulejo brdf eval``: a name with parameters, ``"ward kd=0.2 ks=0.3 ax=0.2 ay=0.3"``, or a file.
    wi, wo : array_like (..., 3)
        Directions of light and of view away from the surface, whose normal is z; they are normalized,
        and broadcast with each other. :func:`directions` makes them of angles. `wo` may be left out
        where it does not matter.
    quantity : {"brdf", "mirror", "albedo"}, optional
        f_r in 1/sr; the reflectance of the perfect mirror at the angle of `wi`, which has no value in
        1/sr; or the share of light from `wi` that is reflected in any way.
    threads : int, optional
        Number of threads, by default as many as there are processors.

    Returns
    -------
    ndarray (..., 3)
        Red, green and blue.

    Examples
    --------
    >>> import pyazulejo as az
    >>> f = az.brdf("diffuse kd=0.5", az.directions(30), az.directions([0, 60, 80]))
    >>> f.shape
    (3, 3)
    """
    incident = _unit("wi", wi)
    if wo is None and quantity == "brdf":
        raise AzulejoError("wo is missing: a brdf depends on both directions")
    outgoing = incident if wo is None else _unit("wo", wo)
    try:
        incident, outgoing = np.broadcast_arrays(incident, outgoing)
    except ValueError:
        raise AzulejoError(
            f"wi and wo have the shapes {incident.shape} and {outgoing.shape}, which do not fit"
        ) from None
    pairs = [np.ascontiguousarray(w.reshape(-1, 3)) for w in (incident, outgoing)]
    values = evaluate_brdf(model, pairs[0], pairs[1], quantity, _threads(threads))
    return values.reshape(incident.shape)


def _unit(name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    array = numbers(name, value)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise AzulejoError(f"{name} has the shape {array.shape}, expected (..., 3)")
    length = np.linalg.norm(array, axis=-1, keepdims=True)
    if not (np.isfinite(length) & (length > 0)).all():
        raise AzulejoError(f"{name} has directions that are zero or not finite")
    unit: npt.NDArray[np.float64] = array / length
    return unit
