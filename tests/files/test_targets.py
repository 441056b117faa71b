"""Whether a file can be written."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcsmooth.errors import CloudFileError
from pcsmooth.files.targets import check_target


def test_a_folder_that_must_not_be_entered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def closed(_path: Path) -> bool:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "exists", closed)
    with pytest.raises(CloudFileError, match=r"a\.ply: permission denied; change its permissions"):
        check_target(str(tmp_path / "a.ply"), overwrite=False)
