from __future__ import annotations

import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import pytest

from pcsmooth.cleanup import clean_up, on_failure, temporary_folder


class TestOnFailure:
    def test_a_block_that_ends_leaves_things_alone(self) -> None:
        calls: list[int] = []
        with on_failure(lambda: calls.append(1)):
            pass
        clean_up(1.0)
        assert calls == []

    @pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
    def test_an_exception(self, error: type[BaseException]) -> None:
        calls: list[int] = []
        with pytest.raises(error), on_failure(lambda: calls.append(1)):
            raise error
        clean_up(1.0)
        assert calls == [1]

    def test_errors_on_the_way_out_are_lost(self) -> None:
        with pytest.raises(KeyError, match="first"), on_failure(lambda: 1 // 0):
            raise KeyError("first")

    def test_equal_functions_are_told_apart(self) -> None:
        calls: list[int] = []
        call = calls.clear
        with on_failure(call), on_failure(call):
            calls.append(1)
            clean_up(1.0)
            calls.append(2)
        assert calls == [2]


class TestCleanUp:
    def test_latest_first_and_once(self) -> None:
        calls: list[str] = []
        with (
            on_failure(lambda: calls.append("outer")),
            on_failure(lambda: 1 // 0),
            on_failure(lambda: calls.append("inner")),
        ):
            clean_up(1.0)
            clean_up(1.0)
        assert calls == ["inner", "outer"]

    def test_waits_for_what_another_thread_is_at_but_not_for_ever(self) -> None:
        calls: list[str] = []
        at_it, go_on = threading.Event(), threading.Event()

        def slow() -> None:
            at_it.set()
            go_on.wait(30.0)
            calls.append("slow")

        def fail() -> None:
            with suppress(KeyboardInterrupt), on_failure(slow):
                raise KeyboardInterrupt

        with on_failure(lambda: calls.append("other")):
            thread = threading.Thread(target=fail)
            thread.start()
            at_it.wait(30.0)
            clean_up(0.01)
            assert calls == []
            go_on.set()
            clean_up(30.0)
            assert calls == ["slow", "other"]
            thread.join()


class TestTemporaryFolder:
    def test_is_gone_in_the_end(self, tmp_path: Path) -> None:
        with temporary_folder("work-", str(tmp_path)) as folder:
            assert Path(folder).parent == tmp_path
            assert Path(folder).name.startswith("work-")
            (Path(folder) / "file").write_text("x")
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
    def test_is_gone_after_an_exception(self, tmp_path: Path, error: type[BaseException]) -> None:
        def fail() -> None:
            with temporary_folder("work-", str(tmp_path)) as folder:
                (Path(folder) / "file").write_text("x")
                raise error

        with pytest.raises(error):
            fail()
        assert list(tmp_path.iterdir()) == []

    def test_a_folder_that_cannot_be_made(self, tmp_path: Path) -> None:
        with (
            pytest.raises(FileNotFoundError, match="work-"),
            temporary_folder("work-", str(tmp_path / "none")),
        ):
            pass


class TestAtEnd:
    CODE = """
import os, sys
from pcsmooth.cleanup import at_end, clean_up
at_end(lambda: print("put away", flush=True))
"""

    @pytest.mark.parametrize(
        "ending", ["", "sys.exit(3)", "clean_up(1.0); os._exit(0)", "clean_up(1.0)"]
    )
    def test_is_put_away_once(self, ending: str) -> None:
        done = subprocess.run([sys.executable, "-c", self.CODE + ending], capture_output=True)
        assert done.stdout == b"put away\n"
