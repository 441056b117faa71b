"""Write points as text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_text import write_rows
from pcsmooth.formats.position_type import written_position_type
from pcsmooth.formats.text_dialect import WHITESPACE, plain_name
from pcsmooth.formats.text_layout import HEADERLESS, TextLayout

_HEADER_LABELS = {"x": "X", "y": "Y", "z": "Z", "nx": "Nx", "ny": "Ny", "nz": "Nz"}


def write_text(cloud: PointCloud, file: BinaryIO, path: str, format_name: str) -> None:
    """Write a text file of points.

    Parameters
    ----------
    cloud : PointCloud
        What to write.
    file : binary file
        Open for writing.
    path : str
        Name of the file in errors.
    format_name : str
        One of ``xyz``, ``xy``, ``txt``, ``asc``, ``csv``, ``pts``.

    Raises
    ------
    CloudFileError
        A 3D cloud as ``xy``, or a word that a space-separated file cannot hold.
    """
    layout = cloud.layout if isinstance(cloud.layout, TextLayout) else None
    alike = layout if layout is not None and layout.format == format_name else None
    if format_name == "xy" and cloud.dimension == 3 and alike is None:
        raise CloudFileError(path, "an .xy file has no third coordinate", "write .xyz instead")

    delimiter = _delimiter(layout, format_name)
    names = written_names(cloud, format_name)
    positions = cloud.points.T.astype(written_position_type(cloud))
    flat = np.zeros_like(positions[0])
    values: dict[str, npt.NDArray[Any]] = {"z": flat, "nz": flat}
    values.update(cloud.columns)
    values.update(zip("xyz", positions, strict=False))
    columns = [values[name] for name in names]
    if layout is None or delimiter != layout.delimiter:
        columns = [
            _delimited(name, column, delimiter, path)
            for name, column in zip(names, columns, strict=True)
        ]

    head = _kept_comments(alike.comments, cloud) if alike else []
    head += _header(names, alike, delimiter, format_name)
    if format_name == "pts" or (alike is not None and alike.counted):
        head.append(str(len(cloud)))
    _write_lines(file, head)
    write_rows(file, columns, delimiter, cloud.fixed_marks)
    if alike:
        # Above the rows they could be taken for a header.
        _write_lines(file, _kept_comments(alike.comments_below, cloud))


def lost_in_text(cloud: PointCloud, format_name: str) -> list[str]:
    """Say what of a cloud a text file of this format would not keep."""
    lost = lost_besides(cloud, TextLayout)
    kept = written_names(cloud, format_name)
    for name, column in cloud.columns.items():
        if name not in kept:
            lost.append(f"{'lists' if column.dtype.kind == 'O' else 'column'} '{name}'")
    layout = cloud.layout if isinstance(cloud.layout, TextLayout) else None
    alike = layout is not None and layout.format == format_name
    if cloud.comments and not alike:
        lost.append("the comments")
    if format_name in HEADERLESS and not alike and layout is not None and layout.labels:
        lost.append("the column names")
    return lost


def written_names(cloud: PointCloud, format_name: str) -> list[str]:
    """Names of the columns that a text file of this format gets, in order.

    Parameters
    ----------
    cloud : PointCloud
        What is to be written.
    format_name : str
        One of ``xyz``, ``xy``, ``txt``, ``asc``, ``csv``, ``pts``.

    Returns
    -------
    list of str
        The columns of the file that the cloud came from, then new ones; no format gets lists.
        Formats without a header get no new ones but normals. There the positions come first,
        and a 2D cloud gets the third coordinate without which it would be misread, unless a
        file of the same format was otherwise.
    """
    axes = list("xyz"[: cloud.dimension])
    holdable = [name for name, column in cloud.columns.items() if column.dtype.kind != "O"]
    layout = cloud.layout if isinstance(cloud.layout, TextLayout) else None
    old = axes if layout is None else layout.names
    available = {*axes, *holdable}
    kept = [name for name in old if name in available]
    already = {*kept}
    new = [name for name in holdable if name not in already]
    if format_name not in HEADERLESS:
        return kept + new

    new = [name for name in NORMALS if name in new]
    if layout is not None and layout.format == format_name:
        return kept + new
    if len(axes) == 2 and format_name != "xy":
        axes.append("z")
        if "ny" in new and "nz" not in new:
            new.append("nz")
    return axes + [name for name in kept if name not in axes] + new


def _kept_comments(comments: Sequence[tuple[str, str]], cloud: PointCloud) -> list[str]:
    kept = {*cloud.comments}
    return [line for text, line in comments if text in kept]


def _write_lines(file: BinaryIO, lines: Sequence[str]) -> None:
    file.write("".join(f"{line}\n" for line in lines).encode())


def _delimiter(layout: TextLayout | None, format_name: str) -> str:
    usual = "," if format_name == "csv" else WHITESPACE
    if layout is None:
        return usual
    if format_name in HEADERLESS:
        return layout.delimiter if layout.format in HEADERLESS else usual
    if format_name == "csv" and layout.delimiter == WHITESPACE:
        return usual
    return layout.delimiter


def _header(
    names: Sequence[str], alike: TextLayout | None, delimiter: str, format_name: str
) -> list[str]:
    """Compose the header line, if there is to be one."""
    old = dict(zip(alike.names, alike.labels, strict=True)) if alike and alike.labels else {}
    if format_name in HEADERLESS and not old:
        return []
    usual = {} if format_name == "csv" else _HEADER_LABELS
    unsafe = re.compile(f'[\\s"{delimiter}]+' if delimiter == WHITESPACE else f'["{delimiter}]+')
    if alike and delimiter != alike.delimiter:
        unsafe = re.compile(f"^[#/]+|{unsafe.pattern}")
        old = {name: unsafe.sub("_", plain_name(label)) for name, label in old.items()}
    labels = [
        old[name] if name in old else usual.get(name) or unsafe.sub("_", name) for name in names
    ]
    usual_mark = "" if format_name == "csv" else "//"
    mark = alike.header_mark if alike and old else usual_mark
    return [mark + delimiter.join(labels)]


def _delimited(name: str, column: npt.NDArray[Any], delimiter: str, path: str) -> npt.NDArray[Any]:
    """Make a column of words fit for another delimiter than its file had."""
    if column.dtype.kind != "U":
        return column
    words = column.tolist()
    spaced = delimiter == WHITESPACE
    impossible = re.compile(r"\s|^$" if spaced else r"[\r\n]")
    found = next((word for word in words if impossible.search(word)), None)
    if found is not None:
        raise CloudFileError(
            path,
            f"column '{name}' holds '{excerpt(found)}', which a "
            f"{'space-separated' if spaced else 'text'} file cannot",
            "write .csv instead" if spaced else "remove the line break",
        )
    if spaced:
        return column
    unsafe = re.compile(f'^(?!"(?:[^"]|"")*"$).*["{delimiter}]')
    return np.array([_quoted(word) if unsafe.search(word) else word for word in words], np.str_)


def _quoted(word: str) -> str:
    doubled = word.replace('"', '""')
    return f'"{doubled}"'
