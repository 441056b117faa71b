"""Estimate normals and curvatures of a cloud in memory."""

from __future__ import annotations

import numpy.typing as npt

from pcsmooth.curvature.orientation import parse_orientation
from pcsmooth.curvature.single_gradient import Estimator
from pcsmooth.curvature.support import Support, check_support
from pcsmooth.energies.protocol import Quantity
from pcsmooth.errors import InvalidInputError
from pcsmooth.estimating import STAGES, estimate_parts, given_normals
from pcsmooth.files.report import CurvatureReport, PointFacts
from pcsmooth.files.selection import Selection
from pcsmooth.files.taking_part import PointCounts, TakingPart
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.lengths import check_radius
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import as_positions, usable_rows
from pcsmooth.progress import Callback, ignore
from pcsmooth.python.cloud_like import CloudLike, cloud_of
from pcsmooth.python.notebook_bar import notebook_bar
from pcsmooth.python.results import CurvatureResult


def estimate_curvature(
    points: CloudLike,
    *,
    radius: float | str = "auto",
    support: Support = "auto",
    estimator: Estimator = "cells",
    energy: Quantity = "volume",
    orient: str = "auto",
    selection: Selection | None = None,
    normals: npt.ArrayLike | None = None,
    threads: int | None = None,
    callback: Callback = ignore,
    progress: bool = False,
) -> CurvatureResult:
    """Estimate normals and curvatures of the surface under a cloud; no point moves.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3), or a cloud
        Positions, L, or a cloud that has them: a `PointCloud`, or one of Open3D, PyVista or
        trimesh. Rows with a NaN, an infinity or a masked coordinate take no part.
    radius : float or str
        Radius of the balls: a length, ``"3x"`` the spacing, ``"2%"`` of the bounding box's
        diagonal, ``"auto"``, twice the spacing, or for each ball its own: ``"local"``, twice the
        local spacing (see `local_spacings`), ``"local:3x"`` three times. ``"auto"`` is ``"local"``
        where that radius would be too small for much of a surface in space.
    support : int or "auto"
        Points of the neighbourhood to which normal and shape operator are fitted, >= 3, and of
        that whose cells give a normal, if it is less than 30 (2D: 5); chosen from the noise
        measured in the cloud by default (see `choose_supports`).
    estimator : {"cells", "gradient"}
        Fit to the normals of the cells, or, as in the thesis, gradient over visible boundary.
    energy : {"volume", "area"}
        Whose gradient, for the estimator ``gradient``.
    orient : str
        Where normals point: ``"auto"``, ``"outward"``, ``"propagate"``, ``"input"``,
        ``"viewpoint=X,Y,Z"`` or ``"direction=X,Y,Z"`` (see `find_oriented_normals`).
    selection : Selection, optional
        Which points get estimates, the others zeros; these take part in them or are ignored.
    normals : array_like, shape (n, d), optional
        Normals of the input, whose signs ``"input"`` and ``"auto"`` take over.
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.
    callback : callable, optional
        Called with a `Progress` when a stage begins and ends.
    progress : bool
        Whether a progress bar is shown, in notebooks as their own.

    Returns
    -------
    CurvatureResult

    Raises
    ------
    InvalidInputError
        Wrong shapes or option values, no finite point, or a radius that cannot be derived.

    Notes
    -----
    Permuted rows give the permuted result, to the last bit, as in `denoise`.

    Examples
    --------
    >>> import numpy as np
    >>> angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    >>> estimate = estimate_curvature(2 * np.c_[np.cos(angle), np.sin(angle)])
    >>> bool(np.allclose(estimate.mean_curvature, 0.5, rtol=0.01))
    True
    """
    source = cloud_of(points)
    roles = TakingPart("the cloud", None, selection, moves=False)
    selected = roles.selected(source)
    positions = as_positions(roles.positions(source, selected))
    check_radius(radius)
    check_support(support)
    if estimator not in ("cells", "gradient"):
        raise InvalidInputError(f"estimator is {estimator!r}; it must be cells or gradient")
    if energy not in ("volume", "area"):
        raise InvalidInputError(f"energy is {energy!r}; it must be volume or area")
    orientation = parse_orientation(orient)
    given = given_normals(normals, positions.shape, orientation)
    finite = usable_rows(positions)
    counts = PointCounts()
    counts.add(source, selected, roles.ignores_others)
    roles.check_selected(counts)
    fixed = roles.fixed(source, selected)
    with thread_limit(threads), notebook_bar(STAGES, callback, shows=progress) as tell:
        cloud = WholeCloud.of(positions, finite, fixed=fixed, given=given, callback=tell)
        found = estimate_parts(
            cloud, radius=radius, support=support, estimator=estimator, quantity=energy,
            orientation=orientation,
        )  # fmt: skip
        if selection is not None:
            found.fitted.clear_marked(cloud.fixed)
    report = CurvatureReport.of(
        found, "half", estimator, energy, input="", output="",
        points=PointFacts.of(source, len(source), cloud.count, counts, selection),
        tiles=None, seconds=0.0,
    )  # fmt: skip
    rows = found.of_rows(found.fitted.estimates.read(0, cloud.count), cloud.input_rows, finite)
    return CurvatureResult.of_rows(rows, source, report.provenance(orient) + roles.provenance)
