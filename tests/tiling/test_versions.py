"""Workers of a cluster that differ are refused, whatever cluster it is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pcsmooth.errors import PcsmoothError
from pcsmooth.tiling import dask_runner
from pcsmooth.tiling.dask_runner import DaskRunner

OWN = dask_runner._versions()


def runner_whose_workers_have(versions: dict[str, Any]) -> DaskRunner:
    """A runner without a cluster, two workers of which answer."""
    runner = object.__new__(DaskRunner)
    places = {place: name for name, place in dask_runner._COMPARED.items()}

    def ask(_question: Callable[..., Any], place: str) -> list[tuple[str, Any]]:
        return [("tcp://a", OWN[places[place]]), ("tcp://b", versions[places[place]])]

    vars(runner).update(_versions=OWN, _ask=ask)
    return runner


def test_workers_that_are_alike_are_taken() -> None:
    runner_whose_workers_have(OWN)._check_versions()


@pytest.mark.parametrize("library", OWN)
def test_another_version_is_refused(library: str) -> None:
    runner = runner_whose_workers_have({**OWN, library: OWN[library] + "0"})
    with pytest.raises(PcsmoothError, match=f"dask worker tcp://b has {library} .*0, with which"):
        runner._check_versions()


@pytest.mark.parametrize("library", OWN)
@pytest.mark.parametrize(
    ("found", "said"),
    [(ImportError("none"), "has no {}; install {} "), (None, "has {} None, with which")],
)
def test_what_is_missing_is_named(library: str, found: object, said: str) -> None:
    runner = runner_whose_workers_have({**OWN, library: found})
    with pytest.raises(PcsmoothError, match=said.format(library, library)):
        runner._check_versions()
