"""Libraries that only some formats need."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from pcsmooth.errors import PcsmoothError


def optional_library(name: str, extra: str, files: str) -> ModuleType:
    """Import a library that is an extra.

    Parameters
    ----------
    name : str
        The library.
    extra : str
        The extra of pcsmooth that installs it.
    files : str
        The files that need it, for the error.

    Raises
    ------
    PcsmoothError
        If the library is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise PcsmoothError(
            f"{files} need {name}, which is not installed; pip install 'pcsmooth[{extra}]'"
        ) from error
