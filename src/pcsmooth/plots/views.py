"""From where a cloud is looked at, and which of its points are drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

#: Length of the mean normal from which a surface has been seen from one side, and degrees of
#: elevation from which it is looked at along the z axis.
_ONE_SIDED = 0.5
_STEEP = 45.0


@dataclass(frozen=True)
class View:
    """A direction to look from, without perspective.

    Attributes
    ----------
    elevation : float
        Degrees above the plane of x and y, -90 to 90.
    azimuth : float
        Degrees from the x axis towards the y axis.
    """

    elevation: float = 30.0
    azimuth: float = -60.0

    @property
    def axes(self) -> npt.NDArray[np.float64]:
        """Unit vectors to the right, up and towards the viewer, rows of (3, 3).

        Examples
        --------
        >>> View(90, -90).axes.round(9).tolist()
        [[1.0, 0.0, 0.0], [-0.0, 1.0, 0.0], [0.0, -0.0, 1.0]]
        """
        tilt, turn = np.radians([self.elevation, self.azimuth])
        right = np.array([-np.sin(turn), np.cos(turn), 0.0])
        towards = np.array([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)])
        return np.stack([right, np.cross(towards, right), towards])


def facing(normals: npt.NDArray[np.float64] | None) -> View:
    """Choose a view: of a surface that has been seen from one side, from there.

    Parameters
    ----------
    normals : ndarray, shape (n, 3), optional
        Unit normals, 0 or NaN where unknown. If they point every way, as those of closed shapes,
        or there are none, the view is a common one.

    Returns
    -------
    View

    Examples
    --------
    >>> facing(np.array([[0.0, 0.1, -0.9], [0.0, -0.1, -0.9]]))
    View(elevation=-90.0, azimuth=-90.0)
    """
    known = np.empty((0, 3)) if normals is None else normals[np.isfinite(normals).all(axis=1)]
    mean = known[known.any(axis=1)].mean(axis=0) if known.any() else np.zeros(3)
    length = np.linalg.norm(mean)
    if length < _ONE_SIDED:
        return View()
    elevation = float(np.degrees(np.arcsin(mean[2] / length)))
    if abs(elevation) > _STEEP:  # as a map, or as a camera has it: x to the right
        return View(float(np.copysign(90.0, elevation)), -90.0)
    return View(elevation, float(np.degrees(np.arctan2(mean[1], mean[0]))))


def seen(
    points: npt.NDArray[np.float64], view: View
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Project points as they are seen, and tell in which order to draw them.

    Parameters
    ----------
    points : ndarray, shape (n, d)
        Positions; a plane curve is seen as it is.
    view : View
        From where.

    Returns
    -------
    projected : ndarray, shape (n, 2)
        To the right and up, L.
    order : ndarray of int, shape (n,)
        Numbers of the points, the farthest first.
    """
    if points.shape[1] == 2:
        return points, np.arange(len(points))
    turned = points @ view.axes.T
    return turned[:, :2], np.argsort(turned[:, 2], kind="stable")


def thinned(n_points: int, most: int) -> npt.NDArray[np.int64]:
    """Choose points at regular ranks, all if there are not too many.

    Parameters
    ----------
    n_points : int
        How many there are.
    most : int
        How many may be drawn.

    Returns
    -------
    ndarray of int
        Their numbers, increasing.

    Examples
    --------
    >>> thinned(10, 4).tolist(), thinned(3, 4).tolist()
    ([0, 2, 5, 7], [0, 1, 2])
    """
    if n_points <= most:
        return np.arange(n_points)
    return np.arange(most) * n_points // most
