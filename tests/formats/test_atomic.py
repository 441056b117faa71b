from __future__ import annotations

import errno
import os
import stat
import struct
import sys
from pathlib import Path

import pytest

from pcsmooth import CloudFileError
from pcsmooth.formats.atomic import atomic_write

ROOT = pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")


def test_new_file_gets_what_open_would_give(tmp_path: Path) -> None:
    with open(tmp_path / "plain", "wb"):
        pass
    with atomic_write(str(tmp_path / "atomic")) as file:
        file.write(b"new")
    assert (tmp_path / "atomic").read_bytes() == b"new"
    assert (tmp_path / "atomic").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_umask_is_obeyed(tmp_path: Path) -> None:
    old = os.umask(0o027)
    try:
        with atomic_write(str(tmp_path / "file")):
            pass
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o640


def test_replaced_file_keeps_its_mode(tmp_path: Path) -> None:
    target = tmp_path / "file"
    target.write_bytes(b"old")
    target.chmod(0o604)
    with atomic_write(str(target)) as file:
        file.write(b"new")
        assert target.read_bytes() == b"old"
    assert target.read_bytes() == b"new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o604


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("existing", [True, False])
def test_exception_leaves_the_folder_as_it_was(
    tmp_path: Path, error: type[BaseException], existing: bool
) -> None:
    target = tmp_path / "file"
    if existing:
        target.write_bytes(b"old")

    def interrupted() -> None:
        with atomic_write(str(target)) as file:
            file.write(b"half of the new")
            raise error

    with pytest.raises(error):
        interrupted()
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"old"] * existing


def test_symbolic_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").write_bytes(b"old")
    (tmp_path / "link").symlink_to("real")
    with atomic_write(str(tmp_path / "link")) as file:
        file.write(b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"


def test_file_name_without_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with atomic_write("file") as file:
        file.write(b"new")
    assert (tmp_path / "file").read_bytes() == b"new"


def test_device_is_written_not_replaced() -> None:
    with atomic_write(os.devnull) as file:
        file.write(b"gone")
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


def test_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError, match="directory"), atomic_write(str(tmp_path)):
        pass


def test_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_write(str(tmp_path / "none" / "file")):
        pass


def test_write_protected_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "file"
    target.write_bytes(b"old")
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write anything
    with pytest.raises(PermissionError, match="denied"), atomic_write(str(target)) as file:
        file.write(b"new")
    assert target.read_bytes() == b"old"


def write(target: Path, **options: bool) -> list[str]:
    """Write a file; returns what was told of it."""
    told: list[str] = []
    with atomic_write(str(target), tell=told.append, **options) as file:
        file.write(b"new")
    return told


class TestNewFile:
    """A name that must not be taken from another file."""

    def check(self, target: Path) -> None:
        def meanwhile() -> None:
            with atomic_write(str(target), overwrite=False) as file:
                file.write(b"new")
                target.write_bytes(b"another's")

        with pytest.raises(CloudFileError, match=r"exists already, .*; pass --overwrite"):
            meanwhile()
        assert target.read_bytes() == b"another's"
        assert os.listdir(target.parent) == [target.name]

    def test_another_comes_meanwhile(self, tmp_path: Path) -> None:
        self.check(tmp_path / "file")

    def test_another_was_there(self, tmp_path: Path) -> None:
        (tmp_path / "file").write_bytes(b"old")
        with pytest.raises(CloudFileError, match="exists already"):
            write(tmp_path / "file", overwrite=False)
        assert (tmp_path / "file").read_bytes() == b"old"

    def test_none_comes(self, tmp_path: Path) -> None:
        write(tmp_path / "file", overwrite=False)
        assert os.listdir(tmp_path) == ["file"]
        assert (tmp_path / "file").read_bytes() == b"new"
        assert (tmp_path / "file").stat().st_nlink == 1

    def test_disk_without_hard_links(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        def refuse(*_names: str) -> None:
            raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

        monkeypatch.setattr(os, "link", refuse)
        self.check(tmp_path / "file")
        (tmp_path / "file").unlink()
        self.test_none_comes(tmp_path)

    def test_disk_without_hard_links_that_fails(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def refuse(*_names: str) -> None:
            raise OSError(errno.EIO, os.strerror(errno.EIO))

        monkeypatch.setattr(os, "link", refuse)
        monkeypatch.setattr(os, "replace", refuse)
        with pytest.raises(OSError, match="Input/output"):
            write(tmp_path / "file", overwrite=False)
        assert os.listdir(tmp_path) == []


class TestReplacedFile:
    """What stays as it was when a file takes another's place."""

    @pytest.fixture
    def target(self, tmp_path: Path) -> Path:
        target = tmp_path / "file"
        target.write_bytes(b"old")
        return target

    def test_nobody_else_may_read_it_before_it_is_whole(self, target: Path) -> None:
        target.chmod(0o666)
        with atomic_write(str(target)) as file:
            file.write(b"new")
            assert stat.S_IMODE(os.fstat(file.fileno()).st_mode) == 0o600
        assert stat.S_IMODE(target.stat().st_mode) == 0o666

    @pytest.mark.parametrize("bit", [stat.S_ISUID, stat.S_ISGID])
    def test_rights_of_the_old_bytes_are_dropped(self, target: Path, bit: int) -> None:
        target.chmod(0o755 | bit)
        assert write(target) == ["its setuid or setgid bit is not kept"]
        assert stat.S_IMODE(target.stat().st_mode) == 0o755

    @ROOT
    def test_owner_and_group(self, target: Path) -> None:
        os.chown(target, 1234, 2345)
        assert write(target) == []
        assert (target.stat().st_uid, target.stat().st_gid) == (1234, 2345)

    @ROOT
    def test_owner_and_group_that_may_not_be_given(
        self, target: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def refuse(*_arguments: int) -> None:
            raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

        os.chown(target, 1234, 2345)
        target.chmod(0o664)
        monkeypatch.setattr(os, "fchown", refuse)
        assert write(target) == ["owner 1234 is not kept", "group 2345 is not kept"]
        assert stat.S_IMODE(target.stat().st_mode) == 0o644  # not another group's to write

    def test_the_bytes_are_on_the_disk_before_the_old_ones_go(
        self, target: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        done: list[str] = []
        fsync, replace = os.fsync, os.replace

        def note_sync(file: int) -> None:
            state = os.fstat(file)
            size = state.st_size if stat.S_ISREG(state.st_mode) else None
            done.append("folder" if size is None else f"{size} bytes")
            fsync(file)

        def note_replacing(*names: str) -> None:
            done.append("replaced")
            replace(*names)

        monkeypatch.setattr(os, "fsync", note_sync)
        monkeypatch.setattr(os, "replace", note_replacing)
        write(target)
        assert done == ["3 bytes", "replaced", "folder"]

    def test_folders_that_cannot_be_synchronized(
        self, target: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def refuse_folders(file: int) -> None:
            if stat.S_ISDIR(os.fstat(file).st_mode):
                raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))

        monkeypatch.setattr(os, "fsync", refuse_folders)
        write(target)
        assert target.read_bytes() == b"new"


@pytest.mark.skipif(sys.platform != "linux", reason="has no such attributes")
class TestExtendedAttributes:
    if sys.platform == "linux":

        @pytest.fixture
        def target(self, tmp_path: Path) -> Path:
            target = tmp_path / "file"
            target.write_bytes(b"old")
            try:
                os.setxattr(target, "user.origin", b"survey 7")
            except OSError:
                pytest.skip("this disk has none")
            return target

        def test_are_kept(self, target: Path) -> None:
            assert write(target) == []
            assert os.getxattr(target, "user.origin") == b"survey 7"

        def test_that_cannot_be_kept_are_told(
            self, target: Path, monkeypatch: pytest.MonkeyPatch
        ) -> None:
            def refuse(*_arguments: object) -> None:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

            monkeypatch.setattr(os, "setxattr", refuse)
            assert write(target) == ["extended attribute user.origin is not kept"]
            assert target.read_bytes() == b"new"

        def test_access_list(self, target: Path) -> None:
            self.grant(target, "access")
            before = os.getxattr(target, "system.posix_acl_access")
            mode = target.stat().st_mode
            assert write(target) == []
            assert os.getxattr(target, "system.posix_acl_access") == before
            assert target.stat().st_mode == mode

        def test_access_list_of_the_folder_is_for_new_files(self, target: Path) -> None:
            self.grant(target.parent, "default")
            target.chmod(0o640)
            assert write(target) == []
            assert os.listxattr(target) == ["user.origin"]
            assert stat.S_IMODE(target.stat().st_mode) == 0o640
            write(target.with_name("another"))
            assert "system.posix_acl_access" in os.listxattr(target.with_name("another"))

        def test_without_its_access_list_the_group_gets_no_more(
            self, target: Path, monkeypatch: pytest.MonkeyPatch
        ) -> None:
            def refuse(*_arguments: object) -> None:
                raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP))

            self.grant(target, "access")
            assert stat.S_IMODE(target.stat().st_mode) == 0o660
            monkeypatch.setattr(os, "setxattr", refuse)
            assert "extended attribute system.posix_acl_access is not kept" in write(target)
            assert stat.S_IMODE(target.stat().st_mode) == 0o600

        def grant(self, path: Path, kind: str) -> None:
            """Let user 1234 read and write, the owner too, and nobody else."""
            entries = [(1, 6, -1), (2, 6, 1234), (4, 0, -1), (16, 6, -1), (32, 0, -1)]
            listed = struct.pack("<I", 2)
            listed += b"".join(struct.pack("<HHi", *entry) for entry in entries)
            try:
                os.setxattr(path, f"system.posix_acl_{kind}", listed)
            except OSError:
                pytest.skip("this disk has no access lists")
