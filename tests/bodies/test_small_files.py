"""Files that somebody else may have named."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from pcsmooth import CloudFileError
from pcsmooth.bodies import small_files
from pcsmooth.bodies.small_files import read_small_file


def test_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"abc")
    assert read_small_file(str(tmp_path / "file")) == b"abc"


def test_a_file_that_is_too_large(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(small_files, "MOST_BYTES", 3_000_000)
    with open(tmp_path / "file", "wb") as file:
        file.truncate(3_000_000)
        assert len(read_small_file(file.name)) == 3_000_000
        file.truncate(3_000_001)
        with pytest.raises(CloudFileError, match="file: has more than 3 MB; give a smaller file"):
            read_small_file(file.name)


def test_a_pipe_that_nobody_writes(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("pipe")
    for name in ("pipe", "link"):
        with pytest.raises(CloudFileError, match=f"{name}: is a named pipe; name a file"):
            read_small_file(str(tmp_path / name))


def test_a_device() -> None:
    with pytest.raises(CloudFileError, match="/dev/zero: is a device; name a file"):
        read_small_file("/dev/zero")


def test_a_socket(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # its path must be short
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        with pytest.raises(CloudFileError, match="socket: is a socket; name a file"):
            read_small_file("socket")


def test_none(tmp_path: Path) -> None:
    with pytest.raises(CloudFileError, match="no such file"):
        read_small_file(str(tmp_path / "none"))
    with pytest.raises(CloudFileError, match="a folder stands where a file should"):
        read_small_file(str(tmp_path))
