"""What programs call the coordinates of a normal in their files."""

from __future__ import annotations

from collections.abc import Iterable

from pcsmooth.cloud import NORMALS

#: Names that belong together, in small letters.
_SPELLINGS = (
    NORMALS,
    ("normal_x", "normal_y", "normal_z"),  # PCL
    ("normalx", "normaly", "normalz"),  # PDAL, CloudCompare
    ("nor:normalx", "nor:normaly", "nor:normalz"),  # E57
    ("n_x", "n_y", "n_z"),
    ("normals:0", "normals:1", "normals:2"),  # ParaView
    ("normals_0", "normals_1", "normals_2"),
)


def normals_among(names: Iterable[str]) -> dict[str, str]:
    """Find the names of a normal's coordinates, in letters of either case.

    Parameters
    ----------
    names : iterable of str
        What a file calls its columns.

    Returns
    -------
    dict of str to str
        ``nx``, ``ny`` and ``nz``, as far as they are there, by the names in the file; empty if it
        has no normals, or if other columns are called so.

    Examples
    --------
    >>> normals_among(["x", "Normal_X", "Normal_Y", "Normal_Z"])
    {'Normal_X': 'nx', 'Normal_Y': 'ny', 'Normal_Z': 'nz'}
    """
    names = list(names)
    spelled = {name.lower(): name for name in names} | {name: name for name in names}
    candidates = (
        {
            spelled[name]: normal
            for name, normal in zip(spelling, NORMALS, strict=True)
            if name in spelled
        }
        for spelling in _SPELLINGS
    )
    found = max(candidates, key=len)
    return {} if set(found.values()) & (set(names) - found.keys()) else found
