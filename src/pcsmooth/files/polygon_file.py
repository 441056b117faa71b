"""Files of polygons: GeoJSON or WKT, as their first character tells."""

from __future__ import annotations

import os

from pcsmooth.errors import CloudFileError
from pcsmooth.files.geojson import areas_of_geojson
from pcsmooth.files.polygon import Polygon
from pcsmooth.files.wkt import areas_of_wkt


def read_polygon(path: str | os.PathLike[str]) -> Polygon:
    """Read an area from a file.

    Parameters
    ----------
    path : path
        GeoJSON or WKT, of which x and y count.

    Returns
    -------
    Polygon
        Without areas if the file holds an empty geometry.

    Raises
    ------
    CloudFileError
        It cannot be read, or holds anything but polygons.
    """
    from pcsmooth.bodies.small_files import read_small_file

    name = os.fspath(path)
    data = read_small_file(name)
    try:
        text = data.decode("utf-8-sig").strip()
    except UnicodeDecodeError:
        raise CloudFileError(
            name, "is neither GeoJSON nor WKT: it is no text", "export the polygon as GeoJSON"
        ) from None
    if not text:
        raise CloudFileError(name, "is empty", "export the polygon as GeoJSON or WKT")
    read = areas_of_geojson if text[0] in "{[" else areas_of_wkt
    return Polygon(name, read(name, text))
