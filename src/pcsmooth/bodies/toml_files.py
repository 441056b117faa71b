"""Files in TOML that somebody else may have written."""

from __future__ import annotations

import tomllib
from typing import Any

from pcsmooth.bodies.small_files import read_small_file
from pcsmooth.errors import CloudFileError


def read_toml(path: str) -> dict[str, Any]:
    """Read a file in TOML.

    Parameters
    ----------
    path : str
        The file.

    Returns
    -------
    dict
        Tables and values by their names.

    Raises
    ------
    CloudFileError
        It cannot be read, is no TOML, or is nested too deeply.
    """
    content = read_small_file(path)
    try:
        return tomllib.loads(content.decode())
    except ValueError as error:  # also of bytes that are no UTF-8, and of numbers without end
        raise CloudFileError(path, f"is not TOML ({error})", "correct it there") from error
    except RecursionError as error:
        raise CloudFileError(path, "is nested too deeply", "correct it there") from error
