from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from pcsmooth.kernels import cache


def test_the_digest_follows_every_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "one.py").write_text("x = 1\n")
    (tmp_path / "two.py").write_text("y = 1\n")
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "one.py"))
    before = cache.sources_digest()
    assert cache.sources_digest() == before
    (tmp_path / "two.py").write_text("y = 2\n")
    assert cache.sources_digest() != before


def test_the_users_own_folder_is_respected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "/chosen/by/hand")
    cache.use_own_cache()
    assert vars(numba.config)["CACHE_DIR"] == "/chosen/by/hand"


def test_a_folder_that_cannot_be_made_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    folder = cache.writable_folder(tmp_path / "file" / "cache")
    assert folder.is_dir()
    assert tmp_path not in folder.parents
    folder.rmdir()
    assert cache.writable_folder(tmp_path / "new" / "cache") == tmp_path / "new" / "cache"


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
