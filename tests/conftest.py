"""For all tests: one thread where two workers share the cores, and tests by how long they take."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from pcsmooth.kernels.threads import thread_limit


@pytest.fixture(scope="session", autouse=True)
def _one_thread_for_each_worker() -> Iterator[None]:
    """Workers keep to a core each; tests of several threads ask for them."""
    with thread_limit(1 if "PYTEST_XDIST_WORKER" in os.environ else None):
        yield
