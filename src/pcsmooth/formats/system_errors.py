"""Errors of the operating system, said in the words of pcsmooth."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Iterator

from pcsmooth.errors import CloudFileError


@contextlib.contextmanager
def named_system_errors(path: str) -> Iterator[None]:
    """Turn an ``OSError`` about a file into a `CloudFileError` that names it.

    ``BrokenPipeError`` passes: the reader of a pipe that leaves early is no fault of the file.

    Parameters
    ----------
    path : str
        The file, as the user named it.

    Raises
    ------
    CloudFileError
        Missing file or folder, a folder in place of a file, no permission, any other failure.
    """
    try:
        yield
    except BrokenPipeError:
        raise
    except FileNotFoundError as error:
        raise CloudFileError(path, "no such file or folder", "check the path") from error
    except (IsADirectoryError, NotADirectoryError) as error:
        raise CloudFileError(
            path,
            "a folder stands where a file should, or a file where a folder should",
            "name a file",
        ) from error
    except PermissionError as error:
        raise CloudFileError(
            path, "permission denied", "change its permissions or choose another path"
        ) from error
    except OSError as error:
        if error.errno == errno.EBADF:
            raise CloudFileError(path, "it is closed", "redirect it") from error
        raise CloudFileError(
            path, error.strerror or str(error), "check the disk and try again"
        ) from error
