"""The page on which clouds are turned, compared and measured: its data and the viewer, in one."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import astuple
from hashlib import sha256
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np
import numpy.typing as npt

from pcsmooth.files.colors import colors_of
from pcsmooth.plots.cloud_figure import LINE_COLORS, counts_in_words
from pcsmooth.plots.histogram import histograms
from pcsmooth.plots.page import table
from pcsmooth.plots.point_blocks import (
    Block,
    Numbers,
    bits_for,
    normal_numbers,
    packed,
    value_numbers,
    whole_numbers,
)
from pcsmooth.plots.rough_normals import rough_normals
from pcsmooth.plots.valued_clouds import ValuedClouds, magnitudes, with_values
from pcsmooth.plots.views import View, thinned
from pcsmooth.point_order import order_by_position
from pcsmooth.printable import printable

Floats = npt.NDArray[np.float64]

MOST_TURNED = 1_000_000
"""Points of a cloud beyond which only some are drawn."""

#: Parts of the viewer's program, in the order in which they are joined.
SCRIPTS = (
    "vectors.js", "point_data.js", "theme.js", "camera.js", "shaders.js", "renderer.js", "slab.js",
    "measure.js", "labels.js", "axes.js", "legend.js", "frames.js", "viewer.js", "gestures.js",
    "controls.js", "main.js",
)  # fmt: skip

#: Colors of a color map.
_SHADES = 256

#: Points from whose neighbours the spacing is taken, and how many neighbours.
_SAMPLES = 4000
_NEAREST = 6

#: Share of the points left out of the view on each side, if it is so many times larger with them,
#: and room beside the others, in units of their extent.
_OUTSIDE = 0.002
_FAR = 2.0
_BESIDE = 0.05

#: Spacing of points without extent, in units of the box.
_WIDE = 0.1


def interactive_page(
    shown: ValuedClouds,
    title: str,
    *,
    others: Sequence[ValuedClouds] = (),
    normals: Sequence[Floats | None] = (),
    view: View | None = None,
    starts_shaded: bool = False,
    colormap: str | None = None,
) -> str:
    """Make a page that needs no other file and no network.

    Parameters
    ----------
    shown : ValuedClouds
        Before and after, or one cloud. At most `MOST_TURNED` points of each are drawn, at regular
        ranks; the histograms and the table count all.
    title : str
        Title of the page, plain text.
    others : sequence of ValuedClouds
        Other values of the same clouds, which can be chosen, too.
    normals : sequence of ndarray, shape (n, 3), or None
        Of the rows of each cloud, zero or NaN where unknown; a cloud without is lit by planes
        through neighbouring points, so that noise is seen as roughness.
    view : View, optional
        From where clouds in space are seen at first.
    starts_shaded : bool
        Whether clouds in space are seen without colors at first.
    colormap : str, optional
        A color map of matplotlib; those that suit the values by default.

    Returns
    -------
    str
        HTML; the same input gives the same text.

    Raises
    ------
    PcsmoothError
        If matplotlib is not installed.
    """
    blocks: list[Block] = []
    view = view or View()
    if shown.dimension == 2:
        view = View(90.0, -90.0)
    scene = _scene(shown, others, normals, view, colormap, blocks)
    scene["column"] = -1 if starts_shaded and shown.dimension == 3 else 0
    rows = [
        [name, str(len(values)), *(f"{number:.6g}" for number in astuple(magnitudes(values)))]
        for name, values in shown.distributions.items()
    ]
    of = f" {shown.symbol}" if shown.symbol else ""
    header = ["", "points", f"mean{of}", f"median{of}", f"RMS{of}", f"max{of}"]
    script = "\n".join(_part(name) for name in SCRIPTS)
    style = _part("viewer.css")
    return _filled(
        _part("page.html"),
        {
            "title": escape(printable(title)),
            "policy": _policy(script, style),
            "style": style,
            "script": script,
            "label": escape(shown.label),
            "table": table(header, rows),
            "scene": json.dumps(scene).replace("<", "\\u003c"),
            "blocks": "\n".join(
                f'<script type="application/octet-stream" id="block-{number}">{block.text}</script>'
                for number, block in enumerate(blocks)
            ),
        },
    )


def _part(name: str) -> str:
    """Read a part of the viewer."""
    return (files("pcsmooth.plots") / "viewer" / name).read_text(encoding="utf-8")


def _filled(template: str, parts: Mapping[str, str]) -> str:
    """Put texts into the places of a template, which are not looked for in what was put in."""
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], template)


def _policy(script: str, style: str) -> str:
    """Allow this program and this style, and nothing else: no connection, no other script."""
    script_hash, style_hash = (
        b64encode(sha256(f"\n{text}\n".encode()).digest()).decode() for text in (script, style)
    )
    return (
        f"default-src 'none'; script-src 'sha256-{script_hash}'; "
        f"style-src 'sha256-{style_hash}'; base-uri 'none'; form-action 'none'"
    )


def _scene(
    shown: ValuedClouds,
    others: Sequence[ValuedClouds],
    normals: Sequence[Floats | None],
    view: View,
    colormap: str | None,
    blocks: list[Block],
) -> dict[str, Any]:
    """Describe what is shown; numbers of points are put into blocks, and named by their place."""
    low, high = shown.box
    origin = 0.5 * low + 0.5 * high
    scale = float((0.5 * high - 0.5 * low).max()) or 1.0
    chosen = [thinned(len(cloud.points), MOST_TURNED) for cloud in shown.clouds]
    places = [
        np.clip((cloud.points[rows] - origin) / scale, -1.0, 1.0)
        for cloud, rows in zip(shown.clouds, chosen, strict=True)
    ]
    # Along a curve, so that differences of rows are small; points that were paired stay so.
    orders = [order_by_position(points) for points in places[-1 if shown.is_paired else 0 :]]
    orders = orders * (len(places) // len(orders))
    places = [points[order] for points, order in zip(places, orders, strict=True)]
    chosen = [rows[order] for rows, order in zip(chosen, orders, strict=True)]
    spacing = _spacing(places[-1])
    bits = bits_for(spacing)

    def put(numbers: Numbers, bits: int, *, is_running: bool = False) -> int:
        blocks.append(packed(numbers, bits, is_running=is_running))
        return len(blocks) - 1

    positions = [whole_numbers(points, bits) for points in places]
    if shown.is_paired:  # the way from before to after is shorter than that from the origin
        positions[1] = positions[1] - positions[0]
    known = [*normals, *[None] * (len(places) - len(normals))]
    clouds = [
        {
            "title": printable(cloud.title),
            "count": len(points),
            "positions": put(numbers, bits, is_running=not (number and shown.is_paired)),
            "normals": put(normal_numbers(_normals(points, own, cloud.rows[rows])), 8)
            if shown.dimension == 3
            else None,
        }
        for number, (cloud, points, numbers, own, rows) in enumerate(
            zip(shown.clouds, places, positions, known, chosen, strict=True)
        )
    ]
    columns = []
    for column in (shown, *others):
        of_clouds = [
            value_numbers(cloud.values[rows], column.limits)
            for cloud, rows in zip(column.clouds, chosen, strict=True)
        ]
        numbers = [put(of_clouds[0], 16)]
        is_one = all(np.array_equal(of_clouds[0], values) for values in of_clouds)
        numbers += [numbers[0] if is_one else put(values, 16) for values in of_clouds[1:]]
        columns.append({**_described(column), "values": numbers})
    for axis, name in enumerate("xyz"[: shown.dimension]):
        heights = [cloud.points[:, axis] for cloud in shown.clouds]
        column = with_values(shown, f"{name}, coordinate units", heights, is_signed=False)
        columns.append({**_described(column), "is_signed": False, "axis": axis})
    return {
        "dimension": shown.dimension,
        "origin": origin.tolist(),
        "scale": scale,
        "spacing": spacing,
        "frame": _frame(places),
        "is_paired": shown.is_paired,
        "view": view.axes.tolist(),
        "line_colors": LINE_COLORS,
        "maps": [
            _shades(colormap or "viridis"),
            _shades(colormap or "coolwarm"),
        ],
        "blocks": [
            {"bits": block.bits, "columns": block.columns, "is_running": block.is_running}
            for block in blocks
        ],
        "clouds": clouds,
        "columns": columns,
    }


def _described(column: ValuedClouds) -> dict[str, Any]:
    """Describe values: what they are, of how many points, their scale and how they are spread."""
    counts, _ = histograms(column.distributions, column.limits)
    return {
        "label": printable(column.label),
        "limits": column.limits,
        "is_signed": column.is_signed,
        "notes": [counts_in_words(cloud, MOST_TURNED) for cloud in column.clouds],
        "counts": {name: bars.tolist() for name, bars in counts.items()},
    }


def _normals(places: Floats, own: Floats | None, rows: npt.NDArray[np.int64]) -> Floats:
    """Take the normals that are known, or those of planes through the nearest points."""
    return rough_normals(places) if own is None else own[rows]


def _frame(places: Sequence[Floats]) -> list[list[float]]:
    """Corners of the box that is looked at: of all points, or of nearly all if the rest is far."""
    together = np.concatenate(places)
    low, high = np.quantile(together, [_OUTSIDE, 1.0 - _OUTSIDE], axis=0)
    margin = _BESIDE * (high - low).max()
    lowest, highest = together.min(axis=0), together.max(axis=0)
    if (highest - lowest).max() <= _FAR * (high - low).max():
        low, high = lowest, highest
    else:
        low, high = np.maximum(low - margin, lowest), np.minimum(high + margin, highest)
    return [[*corner, 0.0][:3] for corner in (low.tolist(), high.tolist())]


def _spacing(places: Floats) -> float:
    """Estimate the distance of neighbours: of as many points on the area, or length, around."""
    from scipy.spatial import cKDTree

    n_points, dimension = places.shape
    nearest = min(_NEAREST, n_points - 1)
    if nearest == 0:
        return _WIDE
    sample = places[thinned(n_points, _SAMPLES)]
    reach = np.median(cKDTree(places).query(sample, [nearest + 1])[0])
    spacing = 2.0 * reach / nearest if dimension == 2 else reach * np.sqrt(np.pi / nearest)
    return float(spacing) or _WIDE


def _shades(colormap: str) -> list[list[int]]:
    """Colors of a color map, the first to the last."""
    shares = np.linspace(0.0, 1.0, _SHADES)
    return colors_of(shares, np.ones(_SHADES, np.bool_), colormap, (0.0, 1.0)).tolist()  # type: ignore[no-any-return]
