"""`--skip-existing` compares times and options."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from cli.clouds import save_text, sphere
from cli.commands import pcsmooth, succeeds
from pcsmooth.cli.batch_record import NAME, BatchRecord
from pcsmooth.errors import CloudFileError

SKIPPED = {
    "current": "is there and up to date",
    "unknown": "is there, but not known how it was made; --overwrite makes it anew",
    "changed": "is there, changed since it was made; --overwrite makes it anew",
    "older": "is there, older than its input; --overwrite makes it anew",
}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with two clouds of different sizes."""
    monkeypatch.chdir(tmp_path)
    Path("in").mkdir()
    for count, name in enumerate(("a", "b")):
        save_text(Path(f"in/{name}.xyz"), sphere(60 + count))
        os.utime(f"in/{name}.xyz", (1e9, 1e9))
    return tmp_path


def ran(*options: object, command: str = "denoise") -> list[str]:
    """What became of each file: done, or why it was skipped."""
    told = succeeds(command, "in", "--output-dir", "out", "--json", *options)
    records: list[dict[str, Any]] = [json.loads(line) for line in told.stdout.splitlines()]
    return [record.get("why", "done") for record in records]


def again(*options: object, command: str = "denoise") -> list[str]:
    return ran("--skip-existing", *options, command=command)


def test_what_is_there_is_left_alone_if_it_is_of_the_same_options() -> None:
    assert ran("--strength", "0.5") == ["done"] * 2
    before = [path.read_bytes() for path in sorted(Path("out").glob("[ab]*"))]
    assert again("--strength", "0.5") == [SKIPPED["current"]] * 2
    assert again("--strength", "0.5", "--threads", 1, "--tile", 1000) == [SKIPPED["current"]] * 2
    assert [path.read_bytes() for path in sorted(Path("out").glob("[ab]*"))] == before
    assert again() == ["done"] * 2
    assert again() == [SKIPPED["current"]] * 2
    assert again(command="curvature") == ["done"] * 2


def test_inputs_that_have_changed_are_done_again() -> None:
    ran()
    os.utime("in/b.xyz", (2e9, 2e9))
    assert again() == [SKIPPED["current"], "done"]
    save_text(Path("in/a.xyz"), sphere(90))
    os.utime("in/a.xyz", (1e9, 1e9))
    assert again() == ["done", SKIPPED["current"]]


def test_results_of_others_are_kept() -> None:
    ran()
    Path("out/a.xyz").write_text("mine")
    Path("out", NAME).write_bytes(Path("out", NAME).read_bytes().split(b"\n\n")[0])
    assert again("--strength", "0.1") == [SKIPPED["changed"], SKIPPED["unknown"]]
    os.utime("out/b.xyz", (1e8, 1e8))
    assert again("--strength", "0.1") == [SKIPPED["changed"], SKIPPED["older"]]
    assert Path("out/a.xyz").read_text() == "mine"
    assert again("--strength", "0.1", "--overwrite") == ["done"] * 2
    assert again("--strength", "0.1", "--overwrite") == [SKIPPED["current"]] * 2


def test_files_that_options_name_count() -> None:
    Path("mine.toml").write_text("[cuboid]\nbase = 'cube'\nscale = [1, 1, 2]\n")
    options = ("--polyhedron", "cuboid", "--presets", "mine.toml", "--iterations", 1)
    ran(*options)
    assert again(*options) == [SKIPPED["current"]] * 2
    Path("mine.toml").write_text("[cuboid]\nbase = 'cube'\nscale = [1, 1, 3]\n")
    assert again(*options) == ["done"] * 2


def test_options_of_files_that_fit_a_pattern_count() -> None:
    Path("pcsmooth.toml").write_text("[[denoise.files]]\npattern = 'b*'\nstrength = 0.5\n")
    ran()
    assert again() == [SKIPPED["current"]] * 2
    assert again("--no-config") == [SKIPPED["current"], "done"]


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\n{",
        b"[" * 99999,
        b'{"name": "a.xyz"}\n',
        b"[]\n3\nnull\n",
        b'{"name": "a.xyz", "result": 1, "source": 1, "options": 1, "version": 1, "summary": 1}',
    ],
)
def test_a_damaged_record_tells_nothing(content: bytes) -> None:
    ran()
    Path("out", NAME).write_bytes(content)
    assert again() == [SKIPPED["unknown"]] * 2
    assert again("--overwrite") == ["done"] * 2
    assert again() == [SKIPPED["current"]] * 2


def test_a_record_that_cannot_be_read_or_written_is_said() -> None:
    Path("out", NAME).mkdir(parents=True)
    told = succeeds("denoise", "in", "--output-dir", "out")
    assert f"warning: out/{NAME}: cannot be written (" in told.stderr
    assert told.stderr.count("--skip-existing will not know these results") == 1
    assert again() == [SKIPPED["unknown"]] * 2


def test_no_link_is_followed() -> None:
    Path("out").mkdir()
    Path("precious").write_text("mine")
    Path("out", NAME).symlink_to("../precious")
    told = succeeds("denoise", "in", "--output-dir", "out")
    assert f"out/{NAME}: cannot be written" in told.stderr
    assert Path("precious").read_text() == "mine"


def test_results_in_sub_folders_are_told_apart() -> None:
    Path("in/a").mkdir()
    save_text(Path("in/a/a.xyz"), sphere(70))
    assert again("--recursive") == ["done"] * 3
    lines = Path("out", NAME).read_text().splitlines()
    names = {json.loads(line)["name"] for line in lines if line}
    assert names == {"a.xyz", "b.xyz", "a/a.xyz"}
    assert again("--recursive") == [SKIPPED["current"]] * 3


def test_a_result_that_is_gone_again_is_not_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(*_arguments: object) -> None:
        return None

    monkeypatch.setattr("pcsmooth.cli.batch_record.file_state", gone)
    ran()
    assert not Path("out", NAME).exists()
    assert BatchRecord("out").failure == ""


def test_json_says_why() -> None:
    ran()
    told = succeeds("denoise", "in", "--output-dir", "out", "--skip-existing")
    assert "in/a.xyz: skipped, out/a.xyz is there and up to date" in told.stderr
    assert pcsmooth("denoise", "in", "--output-dir", "out").status == 1


def test_a_result_that_another_run_has_made_meanwhile(monkeypatch: pytest.MonkeyPatch) -> None:
    def made(*_arguments: object, **_options: object) -> None:
        Path("out").mkdir(exist_ok=True)
        for name in ("a", "b"):
            Path(f"out/{name}.xyz").write_text("theirs")
        raise CloudFileError("out/a.xyz", "exists already", "pass --overwrite")

    monkeypatch.setattr("pcsmooth.files.denoise_file.denoise_input", made)
    assert again() == [
        "is there, made meanwhile by another run", SKIPPED["unknown"]
    ]  # fmt: skip
    Path("out/a.xyz").unlink()
    Path("out/b.xyz").unlink()
    assert pcsmooth("denoise", "in", "--output-dir", "out").status == 1


def test_a_page_that_fails_is_no_result_of_another_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_arguments: object) -> None:
        raise CloudFileError("pages/a.xyz.html", "no space left", "check the disk")

    monkeypatch.setattr("pcsmooth.cli.files.write_beside", full)
    told = pcsmooth("denoise", "in", "--output-dir", "out", "--report", "pages", "--skip-existing")
    assert told.status == 1
    assert "2 files: 0 done, 0 skipped, 2 failed" in told.stderr


def test_an_input_that_changes_while_it_is_worked_on_is_done_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from pcsmooth.files import denoise_file

    denoise_input = denoise_file.denoise_input

    def changing(*arguments: Any, **options: Any) -> Any:
        os.utime("in/a.xyz", (2e9, 2e9))
        return denoise_input(*arguments, **options)

    with monkeypatch.context() as patched:
        patched.setattr(denoise_file, "denoise_input", changing)
        ran("--jobs", 1)
    assert again()[0] == "done"
    assert again() == [SKIPPED["current"]] * 2


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_no_reader_of_a_pipe_is_waited_for() -> None:
    Path("out").mkdir()
    os.mkfifo(Path("out", NAME))
    assert (
        f"out/{NAME}: cannot be written" in succeeds("denoise", "in", "--output-dir", "out").stderr
    )
