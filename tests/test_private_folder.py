"""Folders that are private, and those that only seem to be."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from pcsmooth.private_folder import private_folder, trusted_files

ROOT = pytest.mark.skipif(os.geteuid() != 0, reason="only root may give folders away")


@pytest.fixture
def _no_mask() -> Iterator[None]:
    """Whatever is made is open to all."""
    before = os.umask(0)
    yield
    os.umask(before)


def mode_of(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


@pytest.mark.usefixtures("_no_mask")
def test_new_folders_are_private_from_the_start(tmp_path: Path) -> None:
    assert private_folder(tmp_path / "a" / "b") == tmp_path / "a" / "b"
    assert (mode_of(tmp_path / "a"), mode_of(tmp_path / "a" / "b")) == (0o700, 0o700)
    assert list((tmp_path / "a" / "b").iterdir()) == []


def test_one_that_others_may_read_becomes_private(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a").chmod(0o755)
    private_folder(tmp_path / "a")
    assert mode_of(tmp_path / "a") == 0o700


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o720, 0o702, 0o1777])
def test_one_that_others_may_write(tmp_path: Path, mode: int) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a").chmod(mode)
    with pytest.raises(PermissionError, match=f"others may write {tmp_path}/a"):
        private_folder(tmp_path / "a")
    assert mode_of(tmp_path / "a") == mode


@pytest.mark.parametrize("mode", [0o770, 0o707])
def test_one_in_a_folder_that_others_may_write(tmp_path: Path, mode: int) -> None:
    (tmp_path / "a" / "b" / "c").mkdir(parents=True)
    (tmp_path / "a").chmod(mode)
    with pytest.raises(PermissionError, match=f"others may write {tmp_path}/a"):
        private_folder(tmp_path / "a" / "b" / "c")


def test_one_in_a_folder_where_all_have_their_own(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a").chmod(0o1777)
    assert private_folder(tmp_path / "a" / "b") == tmp_path / "a" / "b"


@ROOT
@pytest.mark.parametrize("name", ["a", "a/b"])
def test_somebody_elses(tmp_path: Path, name: str) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    os.chown(tmp_path / name, 1234, -1)
    with pytest.raises(PermissionError, match=f"{tmp_path}/{name} is somebody else's"):
        private_folder(tmp_path / "a" / "b")


def test_a_link_says_nothing_of_where_it_leads(tmp_path: Path) -> None:
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    (tmp_path / "link").symlink_to("open")
    with pytest.raises(PermissionError, match=f"others may write {tmp_path}/open"):
        private_folder(tmp_path / "link" / "b")
    (tmp_path / "mine").mkdir()
    (tmp_path / "open" / "link").symlink_to(tmp_path / "mine")
    assert private_folder(tmp_path / "open" / "link") == tmp_path / "mine"


def test_no_absolute_path() -> None:
    with pytest.raises(FileNotFoundError, match="there is no home folder"):
        private_folder(Path("~/.cache"))


def test_a_file_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    for path in (tmp_path / "file", tmp_path / "file" / "a"):
        with pytest.raises(FileExistsError):
            private_folder(path)


class TestTrustedFiles:
    @pytest.fixture
    def folder(self, tmp_path: Path) -> Path:
        """One with two files, which others may read."""
        folder = tmp_path / "a" / "b"
        folder.mkdir(parents=True)
        for name in ("x", "y"):
            (folder / name).touch(0o644)
        folder.chmod(0o755)
        return folder

    def test_ones_own(self, folder: Path) -> None:
        assert trusted_files(folder) == {"x", "y"}
        folder.chmod(0o555)
        assert trusted_files(folder) == {"x", "y"}
        assert mode_of(folder) == 0o555

    @ROOT
    def test_those_of_root(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(os, "geteuid", lambda: 1234)
        assert trusted_files(folder) == {"x", "y"}

    @ROOT
    @pytest.mark.parametrize("name", ["", "a", "a/b", "a/b/x"])
    def test_somebody_elses(self, tmp_path: Path, folder: Path, name: str) -> None:
        os.chown(tmp_path / name, 1234, -1)
        assert trusted_files(folder) == frozenset()

    @pytest.mark.parametrize("name", ["", "a", "a/b", "a/b/x"])
    @pytest.mark.parametrize("others", [0o020, 0o002])
    def test_others_may_write(self, tmp_path: Path, folder: Path, name: str, others: int) -> None:
        path = tmp_path / name
        path.chmod(mode_of(path) | others)
        assert trusted_files(folder) == frozenset()

    def test_in_a_folder_where_all_have_their_own(self, folder: Path) -> None:
        folder.parent.chmod(0o1777)
        assert trusted_files(folder) == {"x", "y"}
        folder.chmod(0o1777)
        assert trusted_files(folder) == frozenset()

    def test_links_and_folders_among_them(self, tmp_path: Path, folder: Path) -> None:
        (folder / "z").symlink_to("x")
        assert trusted_files(folder) == frozenset()
        (folder / "z").unlink()
        (folder / "z").mkdir()
        assert trusted_files(folder) == frozenset()

    def test_a_link_to_it(self, tmp_path: Path, folder: Path) -> None:
        (tmp_path / "link").symlink_to(folder)
        assert trusted_files(tmp_path / "link") == {"x", "y"}
        (tmp_path / "a").chmod(0o777)
        assert trusted_files(tmp_path / "link") == frozenset()

    def test_none(self, folder: Path) -> None:
        assert trusted_files(folder / "none") == frozenset()
        assert trusted_files(folder / "x") == frozenset()
