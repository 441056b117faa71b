"""A radius as people give it: a length, multiples of the spacing, or part of the extent."""

from __future__ import annotations

import math
import re

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError

#: The radius of `auto`, in units of the mean spacing.
AUTO_SPACINGS = 2.0

_PATTERN = re.compile(r"(?P<number>[^x%]+?)\s*(?P<unit>x|%|)", re.IGNORECASE)


def check_radius(spec: float | str) -> None:
    """Raise `InvalidInputError` unless `resolve_radius` understands the value."""
    _parse(spec)


def resolve_radius(spec: float | str, points: npt.NDArray[np.float64], spacing: float) -> float:
    """Turn a radius as given into a length.

    Parameters
    ----------
    spec : float or str
        A length L; ``"3x"``, three times the spacing; ``"2%"`` of the diagonal of the bounding
        box; or ``"auto"``, twice the spacing.
    points : ndarray, shape (n, d)
        Finite positions, n >= 1.
    spacing : float
        Mean spacing of the points, L.

    Returns
    -------
    float
        The radius, L, finite and > 0.

    Raises
    ------
    InvalidInputError
        If the value is not understood, not finite or not positive, or relative to a spacing or
        extent that is zero.
    """
    number, unit = _parse(spec)
    if unit == "x":
        base = spacing
    elif unit == "%":
        base = float(np.linalg.norm(np.ptp(points, axis=0))) / 100.0
    else:
        base = 1.0
    radius = number * base
    if not (math.isfinite(radius) and radius > 0.0):
        raise InvalidInputError(
            f"radius {spec!r} is {radius:g} for this cloud; give the radius as a length"
        )
    return radius


def _parse(spec: float | str) -> tuple[float, str]:
    """Split a radius into number and unit ("", "x" or "%")."""
    text = str(spec).strip()
    if text.lower() == "auto":
        return AUTO_SPACINGS, "x"
    match = _PATTERN.fullmatch(text)
    try:
        number = float(match["number"]) if match else math.nan
    except ValueError:
        number = math.nan
    if match is None or not (math.isfinite(number) and number > 0.0):
        raise InvalidInputError(
            f"radius {text!r} is not a positive length; "
            "give a length (0.5), multiples of the spacing (3x), a share of the extent (2%) or auto"
        )
    return number, match["unit"].lower()
