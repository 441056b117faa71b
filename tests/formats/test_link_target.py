"""Links that are followed to a file that is written, and those that are not."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pcsmooth import CloudFileError
from pcsmooth.formats.atomic import atomic_write
from pcsmooth.formats.link_target import link_target

ROOT = pytest.mark.skipif(os.geteuid() != 0, reason="only root may give links away")


@pytest.fixture
def shared(tmp_path: Path) -> Path:
    """A folder as ``/tmp``."""
    folder = tmp_path / "shared"
    folder.mkdir()
    folder.chmod(0o1777)
    return folder


def test_chains_of_links_relative_and_absolute(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "second").symlink_to(tmp_path / "third")
    (tmp_path / "third").symlink_to("new")
    (tmp_path / "first").symlink_to("inner/second")
    assert link_target(str(tmp_path / "first")) == str(tmp_path / "new")


def test_no_link(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert link_target("none/../file") == str(tmp_path / "file")


def test_links_in_a_circle(tmp_path: Path) -> None:
    (tmp_path / "one").symlink_to("other")
    (tmp_path / "other").symlink_to("one")
    with pytest.raises(OSError, match="Too many levels of symbolic links"):
        link_target(str(tmp_path / "one"))


def test_own_links_in_a_shared_folder(shared: Path) -> None:
    (shared / "link").symlink_to("file")
    assert link_target(str(shared / "link")) == str(shared / "file")


@ROOT
@pytest.mark.parametrize("direct", [True, False])
def test_links_of_others_in_a_shared_folder(tmp_path: Path, shared: Path, direct: bool) -> None:
    (tmp_path / "precious").write_bytes(b"old")
    (shared / "trap").symlink_to(tmp_path / "precious")
    os.lchown(shared / "trap", 1234, 1234)
    (tmp_path / "link").symlink_to(shared / "trap")
    path = shared / "trap" if direct else tmp_path / "link"
    with (
        pytest.raises(CloudFileError, match=r"a link of somebody else, .*; name the file itself"),
        atomic_write(str(path)) as file,
    ):
        file.write(b"new")
    assert (tmp_path / "precious").read_bytes() == b"old"


@ROOT
@pytest.mark.parametrize(
    ("folder_mode", "folder_owner"), [(0o1777, 1234), (0o755, 0), (0o1755, 0), (0o777, 0)]
)
def test_links_of_others_elsewhere(shared: Path, folder_mode: int, folder_owner: int) -> None:
    """Of the folder's owner, or where one need not expect others' files."""
    (shared / "link").symlink_to("file")
    os.lchown(shared / "link", 1234, 1234)
    os.chown(shared, folder_owner, -1)
    shared.chmod(folder_mode)
    assert link_target(str(shared / "link")) == str(shared / "file")
