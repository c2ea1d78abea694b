# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures that several test modules use."""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # read by numpy as it is imported: processes of the tests have a core each, threads would wait

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from unittest import mock

import pytest
from block_files import write_plate_scene
from hypothesis import settings
from places import SHARED
from tiers import (  # noqa: F401  hooks of pytest
    pytest_addoption,
    pytest_collection_modifyitems,
    pytest_runtest_call,
    pytest_runtest_makereport,
    pytest_runtest_setup,
    pytest_runtest_teardown,
    pytest_terminal_summary,
)

from masonry_cd.foundation.trust import VARIABLE
from reports.drawing import render

settings.register_profile("steady", derandomize=True, deadline=None, max_examples=50, database=None)  # the same examples in every run
settings.register_profile("search", deadline=None, max_examples=2000, database=None)  # pytest tests/properties --hypothesis-profile search
settings.load_profile("steady")


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of reference data next to the checkout; tests that need it skip where it is absent."""
    folder = SHARED
    if not folder.is_dir():
        pytest.skip("the reference data are not next to this checkout")
    return folder


@pytest.fixture(scope="session", autouse=True)
def unsynced() -> Iterator[None]:
    """No test waits for the disc: what it writes need not survive a loss of power."""
    with mock.patch.object(os, "fsync", lambda _: None):
        yield


@pytest.fixture(scope="session", autouse=True)
def one_core() -> Iterator[None]:
    """Each process of the tests has a core, and starts no others for parts of a limit analysis; tests of these ask for more."""
    with mock.patch.object(os, "sched_getaffinity", lambda _: {0}, create=True):
        yield


@pytest.fixture(scope="session", autouse=True)
def coarse() -> Iterator[None]:
    """Pixels of pictures are no means of several, which takes a third of the time; tests that look at such means ask for them."""
    with mock.patch.object(render, "SAMPLES", 1):
        yield


@pytest.fixture(scope="session")
def scheduler() -> Iterator[str]:
    """The address of a scheduler whose worker is a thread of this process, which has the kernels already."""
    from studied import cluster

    with cluster(1, processes=False) as address:
        yield address


@pytest.fixture
def trusting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Code that scenes name may run, as by --trust."""
    monkeypatch.setenv(VARIABLE, "1")


@pytest.fixture
def block_on_plate(tmp_path: Path) -> Callable[..., Path]:
    """Writes a scene of one block on a shaken plate; lines are replaced by the name of their key."""
    return partial(write_plate_scene, tmp_path)
