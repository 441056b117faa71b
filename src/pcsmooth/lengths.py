"""Lengths as people give them: a number, multiples of the spacing, or part of the extent."""

from __future__ import annotations

import math
import re
from typing import Literal

import numpy as np
import numpy.typing as npt

from pcsmooth.errors import InvalidInputError
from pcsmooth.unit_of_length import LONGEST, SHORTEST, is_measurable

#: The radius of `auto`, in units of the mean spacing.
AUTO_SPACINGS = 2.0

_PATTERN = re.compile(r"(?P<number>[^x%]+?)\s*(?P<unit>x|%|)", re.IGNORECASE)

#: A radius of each ball by the spacing around its centre.
_LOCAL = re.compile(r"local(\s*:\s*(?P<multiple>[^x%:]+?)\s*x)?", re.IGNORECASE)

#: What messages offer last.
_OR_SHARE = " or a share of the extent (2%)"
_OR_AUTO = ", a share of the extent (2%), auto or local (or local:3x)"


def check_radius(spec: float | str) -> None:
    """Raise `InvalidInputError` unless `resolve_radius` understands the value."""
    if not is_auto(spec) and local_multiple(spec) is None:
        _parse(spec, "radius", _OR_AUTO)


def resolve_radius(
    spec: float | str, points: npt.NDArray[np.float64], spacing: float, unit: float = 1.0
) -> float:
    """Turn a radius as given into a length: like `resolve_length`, or "auto", twice the spacing.

    Of "local" radii it is what they would be if the spacing were the same everywhere.

    Raises
    ------
    InvalidInputError
        As there.
    """
    multiple = AUTO_SPACINGS if is_auto(spec) else local_multiple(spec)
    number, suffix = (multiple, "x") if multiple else _parse(spec, "radius", _OR_AUTO)
    return _measure(spec, number, suffix, points, spacing, "radius", unit)


def check_length(spec: float | str, name: str) -> None:
    """Raise `InvalidInputError` unless `resolve_length` understands the value."""
    _parse(spec, name)


def resolve_length(
    spec: float | str,
    points: npt.NDArray[np.float64],
    spacing: float,
    name: str,
    unit: float = 1.0,
) -> float:
    """Turn a length as given into a number.

    Parameters
    ----------
    spec : float or str
        A length L; ``"3x"``, three times the spacing; or ``"2%"`` of the diagonal of the bounding
        box.
    points : ndarray, shape (n, d)
        Finite positions, in the unit, n >= 1.
    spacing : float
        Mean spacing of the points, in the unit.
    name : str
        What it is the length of, for messages.
    unit : float
        What the positions and the result are multiples of, L.

    Returns
    -------
    float
        The length, in the unit, > 0.

    Raises
    ------
    InvalidInputError
        If the value is not understood, not positive, too long or too short to be measured, or
        relative to a spacing or extent that is zero.
    """
    number, suffix = _parse(spec, name)
    return _measure(spec, number, suffix, points, spacing, name, unit)


def step_in_unit(step: float | Literal["auto"], unit: float) -> float | None:
    """Turn a time step as given into multiples of a unit of time; None if it is left to be chosen.

    Raises
    ------
    InvalidInputError
        If it is so long or short for the cloud that floats do not hold what comes of it.
    """
    if step == "auto":
        return None
    scaled = float(step) / unit
    if not is_measurable(scaled):
        limits = " to ".join(f"{limit * unit:.3g}" for limit in (SHORTEST, LONGEST))
        raise InvalidInputError(
            f"step is {step:g}, and steps on this cloud go from {limits}; choose one of these"
        )
    return scaled


def is_auto(spec: float | str) -> bool:
    """Whether a radius is left to be chosen."""
    return str(spec).strip().lower() == "auto"


def local_multiple(spec: float | str) -> float | None:
    """How many local spacings a radius is, of "local" 2; None of one that is the same everywhere.

    Raises
    ------
    InvalidInputError
        If it is local, and no positive multiple.
    """
    match = _LOCAL.fullmatch(str(spec).strip())
    if match is None:
        return None
    if match["multiple"] is None:
        return AUTO_SPACINGS
    multiple = _positive(match["multiple"])
    return multiple if multiple is not None else _parse(spec, "radius", _OR_AUTO)[0]


def _measure(
    spec: float | str,
    number: float,
    suffix: str,
    points: npt.NDArray[np.float64],
    spacing: float,
    name: str,
    unit: float,
) -> float:
    """Multiply a number with what its suffix stands for."""
    if suffix == "x":
        base = spacing
    elif suffix == "%":
        base = float(np.linalg.norm(np.ptp(points, axis=0))) / 100.0
    else:
        base = 1.0 / unit
    if base == 0.0 and (points == points[0]).all():
        place = "there is only one point" if len(points) == 1 else "all points are at one place"
        has_none = is_auto(spec) or _LOCAL.fullmatch(str(spec).strip())
        wish = "has no spacing" if has_none else f"makes the {name} {spec!r} 0"
        raise InvalidInputError(f"{place}, which {wish}; give the {name} as a length")
    length = number * base
    if not is_measurable(length * unit):
        raise InvalidInputError(
            f"{name} {spec!r} is {length * unit:g} for this cloud; give a length from "
            f"{SHORTEST:g} to {LONGEST:g}"
        )
    return length


def _parse(spec: float | str, name: str, alternatives: str = _OR_SHARE) -> tuple[float, str]:
    """Split a length into number and unit ("", "x" or "%")."""
    text = str(spec).strip()
    match = _PATTERN.fullmatch(text)
    number = _positive(match["number"]) if match else None
    if match is None or number is None:
        raise InvalidInputError(
            f"{name} {text!r} is not a positive length; give a length (0.5), multiples of the "
            f"spacing (3x){alternatives}"
        )
    return number, match["unit"].lower()


def _positive(text: str) -> float | None:
    """Read a finite number > 0; None if it is none."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) and number > 0.0 else None
