"""Denoise a cloud in memory."""

from __future__ import annotations

from dataclasses import replace
from typing import Unpack

import numpy as np
import numpy.typing as npt

from pcsmooth.denoising import denoise_parts
from pcsmooth.errors import InvalidInputError
from pcsmooth.estimating import given_normals
from pcsmooth.files.report import DenoiseReport, PointFacts
from pcsmooth.files.selection import Selection
from pcsmooth.files.taking_part import PointCounts, TakingPart
from pcsmooth.kernels.threads import thread_limit
from pcsmooth.methods.estimate import Estimate
from pcsmooth.methods.keywords import Keywords, resolve_keywords
from pcsmooth.methods.method import Method
from pcsmooth.methods.motion import Direction, Motion
from pcsmooth.parts.whole_cloud import WholeCloud
from pcsmooth.positions import as_positions, usable_rows
from pcsmooth.progress import Callback, ignore
from pcsmooth.python.cloud_like import CloudLike, cloud_of
from pcsmooth.python.notebook_bar import notebook_bar
from pcsmooth.python.results import DenoiseResult
from pcsmooth.real_numbers import real_array


def denoise(
    points: CloudLike,
    method: Method | None = None,
    *,
    motion: Motion | Direction = "free",
    estimate: Estimate | None = None,
    fixed: npt.ArrayLike | None = None,
    selection: Selection | None = None,
    normals: npt.ArrayLike | None = None,
    threads: int | None = None,
    callback: Callback = ignore,
    progress: bool = False,
    **keywords: Unpack[Keywords],
) -> DenoiseResult:
    """Denoise a point cloud: by default filtered with parameters measured from the cloud.

    Flows are the other way: gradient descent on an energy of the union of balls around the
    points. With a convex polyhedron in place of the ball a flow is anisotropic: it turns the
    surface towards the polyhedron's facets.

    Parameters
    ----------
    points : array_like, shape (n, 2) or (n, 3), or a cloud
        Positions, L, or a cloud that has them: a `PointCloud`, or one of Open3D, PyVista or
        trimesh. Rows with a NaN, an infinity or a masked coordinate take no part and come
        back as they are, what is masked as NaN; so do those that a file calls noise.
    method : Filter, EulerFlow or ImplicitFlow, optional
        How; by default the filter.
    motion : Motion, "free", "normal" or "ray"
        How points may move.
    estimate : Estimate, optional
        How normals and curvatures are estimated at the new positions.
    fixed : array_like of bool, shape (n,), optional
        Points that stay, and act on the others; masked ones do not stay.
    selection : Selection, optional
        Which points may move; the others stay, and act on these or are ignored.
    normals : array_like, shape (n, d), optional
        Normals of the input, which those at the new positions may follow: see
        `estimate_curvature`.
    threads : int, optional
        Threads to use, all by default. The result does not depend on it.
    callback : callable, optional
        Called with a `Progress` when a stage begins and ends, and with its `record` set when a
        state is known.
    progress : bool
        Whether a progress bar is shown, in notebooks as their own.
    **keywords
        In place of objects, the words that they are made of, all optional, such as ``scheme``,
        ``noise`` and ``iterations`` of the method, ``keep_volume`` of the motion, ``orient`` of
        the estimate: see `Keywords` and `MethodKeywords`.

    Returns
    -------
    DenoiseResult
        points, history, normals, curvatures, displacement and what was chosen.

    Raises
    ------
    InvalidInputError
        Wrong shapes or option values, no finite point, a radius that cannot be derived, or an
        implicit step that cannot be solved.

    Notes
    -----
    Points are taken in the order of their positions (see `order_by_position`): permuted rows give
    the permuted result, to the last bit.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    >>> circle = np.c_[np.cos(angle), np.sin(angle)] * (1 + 0.01 * rng.normal(size=(200, 1)))
    >>> result = denoise(circle)
    >>> bool(np.linalg.norm(result.points, axis=1).std() < 0.005)
    True
    >>> from pcsmooth import Balls, EulerFlow
    >>> flow = EulerFlow(shapes=Balls(radius="3x", quantity="area"), iterations=10)
    >>> denoise(circle, flow).history[-1].iteration
    10
    """
    method, motion, estimate = resolve_keywords(method, motion, estimate, keywords)
    source = cloud_of(points)
    roles = TakingPart("the cloud", None, selection)
    selected = roles.selected(source)
    positions = as_positions(roles.positions(source, selected))
    given = given_normals(normals, positions.shape, estimate.orientation)
    finite = usable_rows(positions)
    marked = source
    if fixed is not None:
        marked = replace(source, fixed_marks=_as_marks(fixed, len(positions)))
    counts = PointCounts()
    counts.add(source, selected, roles.ignores_others)
    roles.check_selected(counts)
    stages = method.stages(motion)
    with thread_limit(threads), notebook_bar(stages, callback, shows=progress) as tell:
        cloud = WholeCloud.of(
            positions, finite, fixed=roles.fixed(marked, selected), given=given, callback=tell
        )
        denoised = denoise_parts(cloud, method, motion, estimate, tell)
        rows = denoised.result(
            source.points, finite, cloud.input_rows, denoised.read(0, cloud.count)
        )
        report = DenoiseReport.of(
            denoised, denoised.facts(), "half", input="", output="",
            points=PointFacts.of(source, len(source), cloud.count, counts, selection),
            tiles=None, shape=None, seconds=0.0,
        )  # fmt: skip
    return DenoiseResult.of(rows, source, report.provenance(estimate.orient) + roles.provenance)


def _as_marks(fixed: npt.ArrayLike, count: int) -> npt.NDArray[np.bool_]:
    """Take the marks of fixed points; masked ones are not set."""
    marks = np.nan_to_num(real_array(fixed, "fixed marks", may_be_bool=True)) != 0.0
    if marks.shape != (count,):
        raise InvalidInputError(
            f"fixed has shape {marks.shape}; it must have one value per point, ({count},)"
        )
    return np.asarray(marks)
