from __future__ import annotations

import os
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType

import llvmlite
import numba
import pytest

from pcsmooth import PcsmoothError
from pcsmooth.cli.messages import compiling
from pcsmooth.kernels import cache, level

SOURCES = {
    "compiled.py": "how",
    "inner_functions.py": "how",
    "grid/cells.py": "x = 1",
    "balls/facets.py": "from pcsmooth.kernels.grid.cells import x",
    "flows/steps.py": "y = 1",
}


@pytest.fixture(autouse=True)
def _as_before(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(cache, "_why_not_kept", "")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    forget()
    yield
    forget()


def forget() -> None:
    for function in (cache.cache_root, cache.folder_of, cache.digest, cache.installed_files):
        function.cache_clear()


class TestDigest:
    @pytest.fixture(autouse=True)
    def sources(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        for name, text in SOURCES.items():
            (tmp_path / name).parent.mkdir(exist_ok=True)
            (tmp_path / name).write_text(text)
        monkeypatch.setattr(cache, "__file__", str(tmp_path / "cache.py"))

    def digests(self) -> dict[str, str]:
        forget()
        return {family: cache.digest(family) for family in ("grid", "balls", "flows")}

    @pytest.mark.parametrize(
        ("changed", "families"),
        [
            ("grid/cells.py", {"grid", "balls"}),
            ("balls/facets.py", {"balls"}),
            ("flows/steps.py", {"flows"}),
            ("compiled.py", {"grid", "balls", "flows"}),
            ("inner_functions.py", {"grid", "balls", "flows"}),
        ],
    )
    def test_it_follows_every_source_that_a_family_needs(
        self, tmp_path: Path, changed: str, families: set[str]
    ) -> None:
        before = self.digests()
        assert self.digests() == before
        with (tmp_path / changed).open("a") as file:
            file.write("\n")
        after = self.digests()
        assert {family for family in before if before[family] != after[family]} == families

    @pytest.mark.parametrize("library", [numba, llvmlite])
    def test_it_follows_what_compiles(
        self, monkeypatch: pytest.MonkeyPatch, library: ModuleType
    ) -> None:
        before = self.digests()
        monkeypatch.setattr(library, "__version__", "0.0.0")
        assert not set(self.digests().values()) & set(before.values())


def chosen_folder() -> Path:
    forget()
    return cache.cache_root()


def test_the_users_choice_is_respected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "chosen"))
    assert chosen_folder() == tmp_path / "chosen" / "pcsmooth"
    assert cache.why_not_kept() == ""


def test_the_users_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert chosen_folder() == tmp_path / "pcsmooth"
    folder = cache.folder_of("grid")
    assert folder == tmp_path / "pcsmooth" / f"grid-{cache.digest('grid')}"
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_what_others_compile_is_kept_where_it_was(tmp_path: Path) -> None:
    vars(numba.config)["CACHE_DIR"] = str(tmp_path)
    before = {name: getattr(numba.config, name) for name in ("CACHE_DIR", "CACHE_LOCATOR_CLASSES")}
    with cache.cache_of("grid", "grid.gather"):
        assert vars(numba.config)["CACHE_DIR"] == str(cache.folder_of("grid"))
    assert before == {name: getattr(numba.config, name) for name in before}


def test_threads_that_declare_kernels_of_several_families_keep_them_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def declare(family: str) -> bool:
        with cache.cache_of(family, "any.kernel"):
            time.sleep(0.02)
            return str(vars(numba.config)["CACHE_DIR"]) == str(cache.folder_of(family))

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(declare, ["grid", "balls", "surface", "flows"] * 3))
    assert vars(numba.config)["CACHE_DIR"] == ""


def test_the_level_is_not_forgotten_where_nothing_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "nowhere")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(cache, "at_end", lambda _action: None)
    chosen_folder()
    numba.config.reload_config()
    assert vars(numba.config)["CPU_NAME"] == level.COMPILED_FOR


def test_folders_that_no_run_has_used_for_long_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    for name, days in (("grid-old", 91), ("grid-new", 89)):
        folder = tmp_path / "pcsmooth" / name
        folder.mkdir(parents=True)
        then = time.time() - days * 86400
        os.utime(folder, (then, then))
    (tmp_path / "pcsmooth").chmod(0o700)
    used = cache.folder_of("grid")
    assert {each.name for each in used.parent.iterdir()} == {"grid-new", used.name}
    os.utime(used, (0, 0))
    forget()
    cache.folder_of("grid")
    assert time.time() - used.stat().st_mtime < 1000


def test_what_is_kept_is_known_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    (cache.folder_of("grid") / "grid.gather-7.py311.1.nbc").touch()
    assert cache.is_kept("grid", "grid.gather")
    assert not cache.is_kept("grid", "grid.gather", 2)
    assert not cache.is_kept("grid", "grid.gather_points")
    assert not cache.is_kept("balls", "grid.gather")


class TestInstalled:
    """Kernels that come with the installation."""

    @pytest.fixture(autouse=True)
    def folder(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        """The installation's folder of a family, with one kernel for one signature."""
        monkeypatch.setattr(sys, "prefix", str(tmp_path / "installed"))
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "mine"))
        folder = tmp_path / "installed" / "lib" / "pcsmooth" / f"grid-{cache.digest('grid')}"
        folder.mkdir(parents=True)
        (folder / "grid.gather-7.py311.1.nbc").touch(0o644)
        return folder

    def test_they_are_found_before_the_users(self, tmp_path: Path, folder: Path) -> None:
        assert cache.is_kept("grid", "grid.gather")
        with cache.cache_of("grid", "grid.gather"):
            assert vars(numba.config)["CACHE_DIR"] == str(folder)
        assert not (tmp_path / "mine").exists()

    def test_those_for_fewer_signatures_are_kept_by_the_user(self, tmp_path: Path) -> None:
        assert not cache.is_kept("grid", "grid.gather", 2)
        with cache.cache_of("grid", "grid.gather", 2):
            assert vars(numba.config)["CACHE_DIR"] == str(cache.folder_of("grid"))
        assert tmp_path / "mine" in cache.folder_of("grid").parents

    def test_what_others_may_write_is_not_used(self, folder: Path) -> None:
        folder.chmod(0o777)
        assert not cache.is_kept("grid", "grid.gather")
        with cache.cache_of("grid", "grid.gather"):
            assert vars(numba.config)["CACHE_DIR"] == str(cache.folder_of("grid"))

    def test_others_than_these_are_found_in_the_users(self) -> None:
        (cache.folder_of("grid") / "grid.gather_points-9.py311.1.nbc").touch()
        assert cache.is_kept("grid", "grid.gather_points")


_INSTALLING = """
from pcsmooth.kernels.compiled import KERNELS
import pcsmooth.kernels.grid.grid
KERNELS["grid", "grid.gather_points"].make_ready(for_all=True)
"""
_USING = """
import sys
sys.prefix = sys.argv[1]
from pcsmooth.kernels.compiled import KERNELS
import pcsmooth.kernels.grid.grid
kernel = KERNELS["grid", "grid.gather_points"]
kernel.make_ready()
print(*kernel._compiled.stats.cache_hits.values())
"""


@pytest.mark.slow
def test_installed_kernels_are_loaded_and_their_folder_is_left_alone(tmp_path: Path) -> None:
    folder = str(tmp_path)
    environment = {**os.environ, "NUMBA_CACHE_DIR": f"{folder}/lib", "XDG_CACHE_HOME": "none"}
    subprocess.run([sys.executable, "-c", _INSTALLING], env=environment, check=True)
    subprocess.run(["chmod", "-R", "a=rX", f"{folder}/lib"], check=True)
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    environment.pop("NUMBA_CACHE_DIR")
    done = subprocess.run(
        [sys.executable, "-c", _USING, folder], env=environment, capture_output=True, text=True
    )
    assert (done.stdout, done.stderr) == ("1\n", "")
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before


class TestWhereNothingIsKept:
    @pytest.fixture(autouse=True)
    def temporary(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        """The folder of the system for what is temporary."""
        folder = tmp_path / "temporary"
        folder.mkdir()
        monkeypatch.setattr(tempfile, "tempdir", str(folder))
        monkeypatch.setattr(cache, "at_end", lambda _action: None)
        return folder

    @pytest.mark.parametrize("by", ["XDG_CACHE_HOME", "NUMBA_CACHE_DIR"])
    def test_others_may_write(
        self, tmp_path: Path, temporary: Path, monkeypatch: pytest.MonkeyPatch, by: str
    ) -> None:
        open_to_all = tmp_path / "open"
        open_to_all.mkdir()
        open_to_all.chmod(0o777)
        if by == "XDG_CACHE_HOME":
            monkeypatch.setenv(by, str(open_to_all))
        else:
            monkeypatch.setattr(numba.config, "CACHE_DIR", str(open_to_all))
        assert temporary in chosen_folder().parents
        assert cache.why_not_kept() == f"{open_to_all}/pcsmooth: others may write {open_to_all}"
        assert compiling(2, 30) == (
            f"compiling for this machine (in every run, as nothing is kept: {open_to_all}/pcsmooth:"
            f" others may write {open_to_all}; set NUMBA_CACHE_DIR to a folder that you alone may "
            "write): 2 of 30 kernels ..."
        )

    def test_something_is_in_the_way(
        self, tmp_path: Path, temporary: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        (tmp_path / "file").write_text("in the way")
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
        assert temporary in chosen_folder().parents
        assert cache.why_not_kept() == f"{tmp_path}/file/pcsmooth: File exists"

    def test_there_is_no_home(self, temporary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
        monkeypatch.setattr(os.path, "expanduser", lambda path: path)
        assert temporary in chosen_folder().parents
        assert cache.why_not_kept() == "~/.cache/pcsmooth: there is no home folder"
        assert not Path("~").exists()

    def test_processes_that_are_started_use_the_same(
        self, temporary: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("XDG_CACHE_HOME", "nowhere")
        folder = chosen_folder()
        monkeypatch.setattr(numba.config, "CACHE_DIR", os.environ["NUMBA_CACHE_DIR"])
        monkeypatch.setattr(cache, "_why_not_kept", "")
        assert chosen_folder() == folder
        assert len(list(temporary.iterdir())) == 1

    def test_nowhere_at_all(
        self, tmp_path: Path, temporary: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        temporary.rmdir()
        monkeypatch.setenv("XDG_CACHE_HOME", "nowhere")
        with pytest.raises(PcsmoothError, match=r"no place .*; set NUMBA_CACHE_DIR to a folder"):
            chosen_folder()


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["", "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"])
def test_what_is_not_kept_is_removed(tmp_path: Path, ending: str) -> None:
    code = (
        "import os; from pcsmooth.kernels.cache import cache_root; "
        "cache_root(); print(os.environ['NUMBA_CACHE_DIR'])"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": "nowhere", "TMPDIR": str(tmp_path)}
    environment.pop("NUMBA_CACHE_DIR", None)
    for last_words in (ending, ""):
        done = subprocess.run(
            [sys.executable, "-c", f"{code}\n{last_words}"], env=environment, capture_output=True
        )
        assert done.stdout.startswith(bytes(tmp_path / ".pcsmooth-kernels-")) or last_words
    assert list(tmp_path.iterdir()) == []


def test_a_forked_process_leaves_it(tmp_path: Path) -> None:
    cache._remove(str(tmp_path), os.getpid() + 1)
    assert tmp_path.exists()
    cache._remove(str(tmp_path), os.getpid())
    assert not tmp_path.exists()


@pytest.mark.slow
def test_kernels_are_kept_in_the_users_cache(tmp_path: Path) -> None:
    code = (
        "from pcsmooth.kernels.grid.grid import bounding_box; import numpy as np; "
        "bounding_box(np.zeros((1, 2)))"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path), "HOME": str(tmp_path)}
    environment.pop("NUMBA_CACHE_DIR", None)
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    kept = [path.name for path in tmp_path.rglob("*.nbi")]
    assert any("bounding_box" in name for name in kept)
