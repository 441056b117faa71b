"""Files in TOML."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcsmooth.bodies.toml_files import read_toml
from pcsmooth.errors import CloudFileError


def test_tables_and_values(tmp_path: Path) -> None:
    file = tmp_path / "a.toml"
    file.write_text("a = 1\n[b]\nc = 'é'\n", "utf8")
    assert read_toml(str(file)) == {"a": 1, "b": {"c": "é"}}


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"a = ", "is not TOML"),
        (b"a = '\xff'", "is not TOML"),
        (b"a = " + b"[" * 9999, "is nested too deeply"),
    ],
)
def test_what_is_none(tmp_path: Path, content: bytes, told: str) -> None:
    file = tmp_path / "a.toml"
    file.write_bytes(content)
    with pytest.raises(CloudFileError, match=rf"a\.toml: {told}.*; correct it there"):
        read_toml(str(file))
