"""For all tests: one thread where two workers share the cores, and tests by how long they take."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator

import pytest

from pcsmooth.kernels.threads import thread_limit

#: One of so many cases of a test is tried where time is short.
_EVERY = 5


@pytest.fixture(scope="session", autouse=True)
def _one_thread_for_each_worker() -> Iterator[None]:
    """Workers keep to a core each; tests of several threads ask for them."""
    with thread_limit(1 if "PYTEST_XDIST_WORKER" in os.environ else None):
        yield


def pytest_addoption(parser: pytest.Parser) -> None:
    """Offer the selection of `make test-fast`."""
    parser.addoption(
        "--fast",
        action="store_true",
        help=f"leave out tests marked slow, and of many cases of a test take every {_EVERY}th",
    )


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Select what `--fast` wants."""
    if not config.getoption("--fast"):
        return
    taken: list[pytest.Item] = []
    left_out: list[pytest.Item] = []
    places: Counter[str] = Counter()
    for item in items:
        name = item.nodeid.partition("[")[0]
        is_taken = places[name] % _EVERY == 0 and item.get_closest_marker("slow") is None
        places[name] += 1
        (taken if is_taken else left_out).append(item)
    items[:] = taken
    config.hook.pytest_deselected(items=left_out)
