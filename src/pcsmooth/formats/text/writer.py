"""Write points as text."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import accumulate
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from pcsmooth.cloud import NORMALS, PointCloud
from pcsmooth.errors import CloudFileError
from pcsmooth.formats.cloud_file import check_alike
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.layout import lost_besides
from pcsmooth.formats.number_text import Exceptions, parsed, write_rows
from pcsmooth.formats.position_type import written_position_type
from pcsmooth.formats.text.dialect import COMMA_BLANK, WHITESPACE, plain_name
from pcsmooth.formats.text.encoding import encoded, readable
from pcsmooth.formats.text.layout import HEADERLESS, TextLayout

_HEADER_LABELS = {"x": "X", "y": "Y", "z": "Z", "nx": "Nx", "ny": "Ny", "nz": "Nz"}


def write_text(
    template: PointCloud,
    count: int,
    chunks: Iterable[PointCloud],
    file: BinaryIO,
    path: str,
    *,
    format_name: str,
) -> None:
    """Write a text file of points.

    Parameters
    ----------
    template, count, chunks, file, path
        See `WriteChunks`.
    format_name : str
        One of ``xyz``, ``xy``, ``txt``, ``asc``, ``csv``, ``pts``.

    Raises
    ------
    CloudFileError
        A 3D cloud as ``xy``, or a word that a space-separated file cannot hold.
    InvalidInputError
        The chunks hold something else than the template.
    """
    layout = template.layout if isinstance(template.layout, TextLayout) else None
    alike = layout if layout is not None and layout.format == format_name else None
    if format_name == "xy" and template.dimension == 3 and alike is None:
        raise CloudFileError(path, "an .xy file has no third coordinate", "write .xyz instead")

    delimiter = _delimiter(layout, format_name)
    names = written_names(template, format_name)
    head = _kept_comments(alike.comments, template) if alike else []
    head += _header(names, alike, delimiter, format_name)
    blocks = _blocks(count, alike, format_name)
    head += map(str, blocks[:1])
    _write_lines(file, head)
    first = 0
    for chunk in chunks:
        if chunk is not template:
            same = replace(chunk, layout=layout)
            check_alike(template, names, chunk, written_names(same, format_name))
        columns = _columns(chunk, names, written_position_type(template))
        if alike is None:
            columns = list(map(_as_utf8, columns))
        if layout is None or delimiter != layout.delimiter:
            columns = [
                _delimited(name, column, delimiter, path)
                for name, column in zip(names, columns, strict=True)
            ]
        exceptions = Exceptions(lines_above=_counts_above(blocks, range(first, first + len(chunk))))
        if alike and delimiter == alike.delimiter:
            exceptions = replace(
                exceptions,
                with_commas=_with_commas(names, columns, alike),
                words=_odd_rows(chunk, alike),
                columns=tuple(names.index(axis) for axis in "xyz"[: template.dimension]),
            )
        write_rows(file, columns, delimiter, chunk.fixed_marks, exceptions)
        first += len(chunk)
    if alike:
        # Above the rows they could be taken for a header.
        _write_lines(file, _kept_comments(alike.comments_below, template))


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


def _columns(
    cloud: PointCloud, names: Sequence[str], position_type: np.dtype[Any]
) -> list[npt.NDArray[Any]]:
    """Positions and other columns in the order of their names; what a plane lacks is zero."""
    positions = cloud.points.T.astype(position_type)
    flat = np.zeros_like(positions[0])
    values = {"z": flat, "nz": flat, **cloud.columns, **dict(zip("xyz", positions, strict=False))}
    return [values[name] for name in names]


def _kept_comments(comments: Sequence[tuple[str, str]], cloud: PointCloud) -> list[str]:
    kept = {*cloud.comments}
    return [line for text, line in comments if text in kept]


def _write_lines(file: BinaryIO, lines: Sequence[str]) -> None:
    file.write(encoded("".join(f"{line}\n" for line in lines)))


def _blocks(count: int, alike: TextLayout | None, format_name: str) -> tuple[int, ...]:
    """Numbers of rows below each count line; empty if there is to be none."""
    blocks = alike.blocks if alike else ()
    if sum(blocks) != count:
        blocks = blocks[:1]
    if len(blocks) > 1:
        return blocks
    return (count,) if blocks or format_name == "pts" else ()


def _counts_above(blocks: Sequence[int], rows: range) -> dict[int, str]:
    """Lines that count the blocks after the first, by the row, of some, above which they stand."""
    counts = zip(accumulate(blocks), blocks[1:], strict=False)
    return {first - rows.start: str(count) for first, count in counts if count and first in rows}


def _with_commas(
    names: Sequence[str], columns: Sequence[npt.NDArray[Any]], alike: TextLayout
) -> frozenset[int]:
    """Columns whose decimals get a comma: those that had one, and new numbers beside them."""
    has_commas = "x" in alike.decimal_commas
    old = {*alike.names}
    return frozenset(
        place
        for place, (name, column) in enumerate(zip(names, columns, strict=True))
        if name in alike.decimal_commas
        or (has_commas and column.dtype.kind == "f" and name not in old)
    )


def _odd_rows(cloud: PointCloud, alike: TextLayout) -> dict[int, tuple[str, ...]]:
    """Coordinates of rows that are not finite as they were spelled, where they still are that."""
    own = cloud.layout.odd_rows if isinstance(cloud.layout, TextLayout) else {}
    odd = {row: words for row, words in own.items() if row < len(cloud)}
    if not odd:
        return odd
    points = cloud.points[list(odd)]
    same = np.ones(len(odd), np.bool_)
    for tokens, values in zip(zip(*odd.values(), strict=True), points.T, strict=True):
        has_commas = "x" in alike.decimal_commas
        read = parsed([word.replace(",", ".") for word in tokens] if has_commas else tokens)
        same &= (read == values) | (np.isnan(read) & np.isnan(values))
    return {row: odd[row] for row, is_same in zip(odd, same.tolist(), strict=True) if is_same}


def _delimiter(layout: TextLayout | None, format_name: str) -> str:
    usual = "," if format_name == "csv" else WHITESPACE
    # Without decimal commas, a comma and a blank part columns as a comma does.
    if layout is None or (layout.delimiter == COMMA_BLANK and layout.format != format_name):
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
    # No label may fall into two, or make a comment of its line.
    unsafe = re.compile(
        r'^[#/%!;]+|[\s"]+' if delimiter == WHITESPACE else f'^[#/%!;]+|["{delimiter}]+'
    )
    if alike and delimiter != alike.delimiter:
        old = {name: unsafe.sub("_", plain_name(label)) for name, label in old.items()}
    labels = [
        old[name] if name in old else usual.get(name) or unsafe.sub("_", name) for name in names
    ]
    usual_mark = "" if format_name == "csv" else "//"
    mark = alike.header_mark if alike and old else usual_mark
    return [mark + delimiter.join(labels)]


def _as_utf8(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Spell words in UTF-8, which may have been in another encoding in their file."""
    if column.dtype.kind != "U":
        return column
    return np.array(list(map(readable, column.tolist())), np.str_)


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
