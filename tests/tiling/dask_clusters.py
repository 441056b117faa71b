"""Dask clusters on this machine, for tests."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from distributed import LocalCluster

#: Workers that die leave sockets and warnings behind.
UNTIDY = pytest.mark.filterwarnings("ignore")


def start_cluster(allowed_failures: int = 3, **options: Any) -> LocalCluster:
    """Start one of which so many workers may die at a task before that is given up."""
    distributed = pytest.importorskip("distributed")
    settings = pytest.importorskip("dask").config
    with settings.set({"distributed.scheduler.allowed-failures": allowed_failures}):
        cluster: LocalCluster = distributed.LocalCluster(
            dashboard_address=None, silence_logs=logging.CRITICAL, **options
        )
    return cluster
