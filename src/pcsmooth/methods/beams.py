"""Points that move along the beams that saw them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pcsmooth.methods.ends import end_elsewhere
from pcsmooth.methods.method import Moved
from pcsmooth.parts.part import Parts

Floats = npt.NDArray[np.float64]

#: Error of a point across its beam, in units of that along it. Of 0, 0.05, 0.1, 0.2 and 0.3 on
#: simulated scans with a tripod and a car: 0.05 leaves the least error of the first, 0.1 of the
#: second, whose ground is seen at a grazing angle.
_ACROSS = 0.07


def go_along_beams(parts: Parts, moved: Moved, origin: Floats, longest: float = math.inf) -> Moved:
    """Send points along their beams to where these meet the surface that a method moved them to.

    The surface at a point is the plane through its end, across its way: a method that moves along
    normals ends so. Of a way h along the normal n, a beam b takes the point
    t = h (n.b) / ((n.b)^2 + e^2), where e is the error across the beam over that along it: the
    most likely place on the beam of a point that errs both ways. Where the beam grazes the surface,
    that is next to nothing.

    Parameters
    ----------
    parts : Parts
        The cloud.
    moved : Moved
        Where the method has taken it, along normals.
    origin : ndarray, shape (d,)
        Where the beams come from, L, seen from the origin of the cloud.
    longest : float
        Most that a point may move, L.

    Returns
    -------
    Moved
        What is left of the errors along the normals is that of these ways, too.
    """
    rule = _AlongBeams(tuple(origin.tolist()), longest)
    return end_elsewhere(parts, moved, rule, "along the beams")


@dataclass(frozen=True)
class _AlongBeams:
    origin: tuple[float, ...]
    longest: float

    def __call__(self, start: Floats, way: Floats) -> tuple[Floats, Floats]:
        beams = _units(start - np.array(self.origin))
        heights = np.linalg.norm(way, axis=1)
        cosines = np.einsum("ij,ij->i", _units(way), beams)
        shares = cosines**2 / (cosines**2 + _ACROSS**2)
        ways = heights * cosines / (cosines**2 + _ACROSS**2)
        kept = np.minimum(1.0, self.longest / np.maximum(np.abs(ways), 1e-300))
        return (kept * ways)[:, np.newaxis] * beams, kept * shares


def _units(vectors: Floats) -> Floats:
    """Divide vectors by their lengths; those of none stay 0."""
    lengths = np.linalg.norm(vectors, axis=1)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)[:, np.newaxis]
