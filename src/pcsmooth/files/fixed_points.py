"""Which points stay: from a column of the file, or from the word `fixed` in its rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pcsmooth.errors import CloudFileError
from pcsmooth.formats.excerpt import excerpt
from pcsmooth.formats.number_text import is_whole, parsed
from pcsmooth.formats.text.encoding import readable
from pcsmooth.formats.text.layout import TextLayout

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from pcsmooth.cloud import PointCloud

_WORD = "fixed"


def fixed_points(
    cloud: PointCloud, column: str | None, path: str, first: int = 0
) -> npt.NDArray[np.bool_] | None:
    """Find the points that must not move.

    Parameters
    ----------
    cloud : PointCloud
        What was read.
    column : str, optional
        Name of a column, or its number in the file counted from 1; its non-zero values, or the
        word ``fixed``, mark points that stay (NaN does not). By default the rows that ended in
        that word.
    path : str
        The file, for messages.
    first : int
        Row of the file that is the first of these, for messages.

    Returns
    -------
    ndarray of bool, shape (n,), or None if no point is marked by default.

    Raises
    ------
    CloudFileError
        If there is no such column or a value is neither a number nor the word.
    """
    if column is None:
        return cloud.fixed_marks
    name, marks_name = column, _WORD
    if column not in cloud.columns and isinstance(cloud.layout, TextLayout):
        in_file = dict(enumerate(cloud.layout.names, 1))
        number = int(column) if is_whole(column) else None
        if number is not None:
            name, marks_name = in_file.get(number, column), str(len(in_file) + 1)
    if name in cloud.columns:
        return _marked(cloud.columns[name], name, path, first)
    if cloud.fixed_marks is not None and name == marks_name:
        return cloud.fixed_marks
    known = [*cloud.columns, *([_WORD] if cloud.fixed_marks is not None else [])]
    raise CloudFileError(
        path,
        f"there is no column '{column}' to fix points by",
        f"choose one of {', '.join(known)}" if known else "the file has nothing but positions",
    )


def _marked(values: npt.NDArray[Any], name: str, path: str, first: int) -> npt.NDArray[np.bool_]:
    import numpy as np

    if values.dtype.kind in "biuf":
        return np.asarray((values != 0) & ~np.isnan(values))
    numbers = np.empty(len(values))
    for row, value in enumerate(map(str, values)):
        try:
            numbers[row] = value.lower() == _WORD or parsed([value])[0]
        except ValueError:
            raise CloudFileError(
                path,
                f"column '{name}' of point {first + row + 1} is '{excerpt(readable(value))}', "
                f"neither a number nor '{_WORD}'",
                "choose a column of numbers",
            ) from None
    return np.asarray((numbers != 0) & ~np.isnan(numbers))
