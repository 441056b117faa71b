"""Whether a file can be written."""

from __future__ import annotations

import os
from pathlib import Path

from pcsmooth.errors import CloudFileError


def check_target(path: str, overwrite: bool) -> None:
    """Raise `CloudFileError` if a file cannot be, or must not be, written there."""
    from pcsmooth.formats.link_target import link_target
    from pcsmooth.formats.system_errors import named_system_errors

    with named_system_errors(path):
        target = Path(link_target(path))
        exists = target.exists()  # which a folder that must not be entered does not say
    if target.is_dir():
        raise CloudFileError(path, "is a folder", "name a file in it")
    if exists and not overwrite:
        raise CloudFileError(path, "exists already", "pass --overwrite to replace it")
    folder = target.parent
    if not folder.is_dir():
        raise CloudFileError(path, f"there is no folder {folder}", "create it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise CloudFileError(path, f"folder {folder} cannot be written", "choose another folder")
