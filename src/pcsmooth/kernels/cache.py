"""Where compiled kernels are kept between runs.

numba looks at the date of one source file to tell whether what it has cached is still good, and
does not see that a kernel calls another file's. So the kernels of each state of the sources get
a folder of their own, in the user's cache, which also serves where the package is read-only.

What is cached are pickles, which run whatever code their author wants. So the folder must be one
that nobody else can have written.
"""

import hashlib
import os
import shutil
import tempfile
from functools import partial
from pathlib import Path

import numba
from numba.misc.appdirs import AppDirs

from pcsmooth.cleanup import at_end
from pcsmooth.errors import PcsmoothError
from pcsmooth.private_folder import private_folder
from pcsmooth.temporaries import folder_prefix, remove_abandoned

_CHOICE = "NUMBA_CACHE_DIR"

_why_not_kept = ""


def use_own_cache() -> None:
    """Set numba's cache folder, within NUMBA_CACHE_DIR if the user has set it.

    Raises
    ------
    PcsmoothError
        There is no place for it, not even a temporary one.
    """
    global _why_not_kept
    chosen = numba.config.CACHE_DIR
    cache = Path(os.path.abspath(chosen), "pcsmooth") if chosen else _users_cache()
    folder = cache / sources_digest()
    try:
        folder = private_folder(folder)
    except OSError as error:
        _why_not_kept = f"{cache}: {error.strerror}"
        folder = _temporary_cache() / "pcsmooth" / folder.name
    numba.config.CACHE_DIR = str(folder)


def why_not_kept() -> str:
    """Say why no compiled kernel is kept for the next run; nothing if they are."""
    return _why_not_kept


def sources_digest() -> str:
    """Name for the present state of all kernel sources."""
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _users_cache() -> Path:
    return Path(AppDirs("pcsmooth", appauthor=False).user_cache_dir)


def _temporary_cache() -> Path:
    """Make a folder that is removed in the end; processes that this one starts use it too."""
    try:
        remove_abandoned(tempfile.gettempdir())
        folder = tempfile.mkdtemp(prefix=folder_prefix("kernels"))
    except OSError as error:
        raise PcsmoothError(
            f"there is no place for compiled kernels ({_why_not_kept}; {error}); set {_CHOICE} to "
            "a folder that you alone may write"
        ) from error
    at_end(partial(_remove, folder, os.getpid()))
    os.environ[_CHOICE] = folder
    return Path(folder)


def _remove(folder: str, owner: int) -> None:
    if os.getpid() == owner:  # and not a process that was forked from it
        shutil.rmtree(folder, ignore_errors=True)
