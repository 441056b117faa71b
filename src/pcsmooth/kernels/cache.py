"""Where compiled kernels are kept between runs.

Each family of kernels has a folder of its own, whose name stands for all that goes into it: the
sources of the family and of those it calls, the versions of Python and numba, the level of the
processor. So a change compiles what depends on it, and no more; copies of the same sources,
wherever they lie, share what is kept.

There are two places: ``lib/pcsmooth`` in the environment that pcsmooth is installed in, which is
only read, and the user's cache, for what is not found there. So kernels that come with an
installation, as in the image of a container, serve all its users.

What is cached are pickles, which run whatever code their author wants. So nobody else can have
written a folder that is used: the first is root's or the user's, the second is the user's alone.
"""

import hashlib
import os
import re
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, partial
from pathlib import Path

import llvmlite
import numba
from numba.core.caching import UserProvidedCacheLocator
from numba.misc.appdirs import AppDirs

from pcsmooth.cleanup import at_end
from pcsmooth.errors import PcsmoothError
from pcsmooth.kernels.level import COMPILED_FOR
from pcsmooth.private_folder import private_folder, trusted_files
from pcsmooth.temporaries import folder_prefix, remove_abandoned

_CHOICE = "NUMBA_CACHE_DIR"

#: Days after which a folder that no run has used is removed.
_KEPT_DAYS = 90

#: Sources that decide how all kernels are compiled.
_COMMON = ("compiled.py", "inner_functions.py")

_why_not_kept = ""

#: Held while numba's settings, which all threads share, are those of a family.
_declaring = threading.RLock()


class FamilyLocator(UserProvidedCacheLocator):
    """Tells numba to take a family's folder as it is: its name vouches for all sources."""

    def __init__(self, py_func, py_file):
        super().__init__(py_func, py_file)
        self._cache_path = numba.config.CACHE_DIR

    def ensure_cache_path(self):
        """Take it unseen: one that comes with the installation need not be writable."""

    def get_source_stamp(self):
        """Return what is the same in every copy of the sources."""
        return os.path.basename(self._cache_path)


@contextmanager
def cache_of(family: str, name: str, count: int = 1) -> Iterator[None]:
    """Have numba look for a kernel that is declared in the block, and keep it, where it belongs.

    That is the installed folder of its family if it is there for so many signatures, or the user's.
    """
    config = numba.config
    with _declaring:
        is_installed = _is_among(installed_files(family), name, count)
        folder = installed_folder(family) if is_installed else folder_of(family)
        before = config.CACHE_DIR, config.CACHE_LOCATOR_CLASSES
        config.CACHE_DIR = str(folder)
        config.CACHE_LOCATOR_CLASSES = f"{FamilyLocator.__module__}.{FamilyLocator.__name__}"
        try:
            yield
        finally:
            config.CACHE_DIR, config.CACHE_LOCATOR_CLASSES = before


def installed_folder(family: str) -> Path:
    """Name the folder of a family of kernels that comes with the installation, if there is one."""
    return Path(sys.prefix, "lib", "pcsmooth", _folder_name(family))


@cache
def installed_files(family: str) -> frozenset[str]:
    """List the files of a family that come with the installation and can be trusted."""
    return trusted_files(installed_folder(family))


@cache
def folder_of(family: str) -> Path:
    """Find the folder of a family of kernels; it is this user's alone."""
    folder = cache_root() / _folder_name(family)
    if not folder.is_dir():
        _remove_old(folder.parent)
    folder = private_folder(folder)
    with suppress(OSError):
        os.utime(folder)
    return folder


def is_kept(family: str, name: str, count: int = 1) -> bool:
    """Whether a kernel is kept, by its name like ``grid.gather_points``, for so many signatures."""
    if _is_among(installed_files(family), name, count):
        return True
    try:
        return _is_among(os.listdir(folder_of(family)), name, count)
    except OSError:
        return False


def _is_among(files: Iterable[str], name: str, count: int) -> bool:
    return sum(file.startswith(f"{name}-") and file.endswith(".nbc") for file in files) >= count


def _folder_name(family: str) -> str:
    return f"{family}-{digest(family)}"


@cache
def cache_root() -> Path:
    """Find the folder for all families, within NUMBA_CACHE_DIR if the user has set it.

    Raises
    ------
    PcsmoothError
        There is no place for it, not even a temporary one.
    """
    global _why_not_kept
    chosen = numba.config.CACHE_DIR
    root = Path(os.path.abspath(chosen), "pcsmooth") if chosen else _users_cache()
    try:
        return private_folder(root)
    except OSError as error:
        _why_not_kept = f"{root}: {error.strerror}"
        return private_folder(_temporary_cache() / "pcsmooth")


def why_not_kept() -> str:
    """Say why no compiled kernel is kept for the next run; nothing if they are."""
    cache_root()
    return _why_not_kept


@cache
def digest(family: str) -> str:
    """Name for the sources of a family and of what it calls, and for what compiles them."""
    known = hashlib.sha256()
    here = Path(__file__).parent
    for member in sorted(_needed_by(family)):
        for source in sorted((here / member).glob("*.py")):
            known.update(source.read_bytes())
    for name in _COMMON:
        known.update((here / name).read_bytes())
    known.update(f"{sys.implementation.cache_tag} {numba.__version__} {COMPILED_FOR}".encode())
    config = numba.config
    for setting in (
        llvmlite.__version__, config.CPU_FEATURES, config.OPT, config.BOUNDSCHECK,
        config.LOOP_VECTORIZE, config.SLP_VECTORIZE, config.USING_SVML,
    ):  # fmt: skip
        known.update(f" {setting}".encode())
    return known.hexdigest()[:16]


def _needed_by(family: str) -> set[str]:
    """List a family and all those whose functions it calls, directly or not."""
    here = Path(__file__).parent
    needed: set[str] = set()
    left = {family}
    while left:
        member = left.pop()
        needed.add(member)
        for source in (here / member).glob("*.py"):
            named = re.findall(r"from pcsmooth\.kernels\.(\w+)", source.read_text("utf-8"))
            left |= {name for name in named if (here / name).is_dir()} - needed
    return needed


def _remove_old(root: Path) -> None:
    """Remove the folders that no run has used for long."""
    with suppress(OSError):
        for folder in root.iterdir():
            if time.time() - folder.stat().st_mtime > _KEPT_DAYS * 86400:
                shutil.rmtree(folder, ignore_errors=True)


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
    # numba would notice when it next compiles, and forget what else has been set.
    level = numba.config.CPU_NAME, numba.config.CPU_FEATURES
    numba.config.reload_config()
    numba.config.CPU_NAME, numba.config.CPU_FEATURES = level
    return Path(folder)


def _remove(folder: str, owner: int) -> None:
    if os.getpid() == owner:  # and not a process that was forked from it
        shutil.rmtree(folder, ignore_errors=True)
