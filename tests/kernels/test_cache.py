from __future__ import annotations

import os
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import numba
import pytest

from pcsmooth import PcsmoothError
from pcsmooth.cli.messages import compiling
from pcsmooth.kernels import cache


def test_the_digest_follows_every_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "one.py").write_text("x = 1\n")
    (tmp_path / "two.py").write_text("y = 1\n")
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "one.py"))
    before = cache.sources_digest()
    assert cache.sources_digest() == before
    (tmp_path / "two.py").write_text("y = 2\n")
    assert cache.sources_digest() != before


@pytest.fixture(autouse=True)
def _as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setattr(cache, "_why_not_kept", "")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)


def chosen_folder() -> Path:
    cache.use_own_cache()
    return Path(vars(numba.config)["CACHE_DIR"])


def test_the_users_choice_is_respected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "chosen"))
    assert chosen_folder() == tmp_path / "chosen" / "pcsmooth" / cache.sources_digest()
    assert cache.why_not_kept() == ""


def test_the_users_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = chosen_folder()
    assert folder == tmp_path / "pcsmooth" / cache.sources_digest()
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


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
        assert compiling() == (
            f"compiling for this machine (in every run, as nothing is kept: {open_to_all}/pcsmooth:"
            f" others may write {open_to_all}; set NUMBA_CACHE_DIR to a folder that you alone may "
            "write) ..."
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
        folder.mkdir(0o700, parents=True)
        assert chosen_folder() == folder
        assert len(list(temporary.iterdir())) == 1

    def test_nowhere_at_all(
        self, tmp_path: Path, temporary: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        temporary.rmdir()
        monkeypatch.setenv("XDG_CACHE_HOME", "nowhere")
        with pytest.raises(PcsmoothError, match=r"no place .*; set NUMBA_CACHE_DIR to a folder"):
            cache.use_own_cache()


@pytest.mark.parametrize("ending", ["", "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"])
def test_what_is_not_kept_is_removed(tmp_path: Path, ending: str) -> None:
    code = "import pcsmooth.kernels, os; print(os.environ['NUMBA_CACHE_DIR'])"
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


def test_kernels_are_kept_in_the_users_cache(tmp_path: Path) -> None:
    code = (
        "from pcsmooth.kernels.grid import bounding_box; import numpy as np; "
        "bounding_box(np.zeros((1, 2)))"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path), "HOME": str(tmp_path)}
    environment.pop("NUMBA_CACHE_DIR", None)
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    kept = [path.name for path in tmp_path.rglob("*.nbi")]
    assert any("bounding_box" in name for name in kept)
