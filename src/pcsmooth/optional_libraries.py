"""Libraries that only some formats and runners need."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from pcsmooth.errors import PcsmoothError


def optional_library(name: str, extra: str, what: str) -> ModuleType:
    """Import a library that is an extra.

    Parameters
    ----------
    name : str
        The library.
    extra : str
        The extra of pcsmooth that installs it.
    what : str
        What needs it, in the plural, for the error.

    Raises
    ------
    PcsmoothError
        If the library is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise PcsmoothError(
            f"{what} need {name}, which is not installed; pip install 'pcsmooth[{extra}]'"
        ) from error
