"""Where compiled kernels are kept between runs.

numba looks at the date of one source file to tell whether what it has cached is still good, and
does not see that a kernel calls another file's. So the kernels of each state of the sources get
a folder of their own, in the user's cache, which also serves where the package is read-only.
"""

import hashlib
import tempfile
from pathlib import Path

import numba
from numba.misc.appdirs import AppDirs


def use_own_cache() -> None:
    """Set numba's cache folder, unless the user has set NUMBA_CACHE_DIR."""
    if not numba.config.CACHE_DIR:
        folder = Path(AppDirs("pcsmooth", appauthor=False).user_cache_dir)
        numba.config.CACHE_DIR = str(writable_folder(folder / sources_digest()))


def sources_digest() -> str:
    """Name for the present state of all kernel sources."""
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def writable_folder(wanted: Path) -> Path:
    """Make a folder, or a temporary one where that is impossible (compiled anew each run)."""
    try:
        wanted.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=wanted):
            return wanted
    except OSError:
        return Path(tempfile.mkdtemp(prefix="pcsmooth-"))
