"""The tiers of the tests, as hooks of pytest: what is slow carries a marker with a reason, and a budget keeps the others quick.

``@pytest.mark.slow(reason="...")`` leaves a test to ``make test-all``. With ``--budget``, a test without the marker fails if its set-up or
its call takes more than ``ALLOWED`` seconds of processor time, in its process and in those that it waited for: a busy machine adds little
to that. Compiling says nothing about a test, so a phase during which any process put a kernel into numba's cache is not judged.
"""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Generator, Iterator
from pathlib import Path

import pytest
from places import ROOT

ALLOWED = 5.0  # processor time of a phase of a test without the marker [s]
# which keep their compiled kernels, unless NUMBA_CACHE_DIR names a folder
PACKAGES = ("masonry_cd", "structures", "loads", "reports", "tests")
BEGIN = pytest.StashKey[tuple[float, float]]()  # of a phase: the time of day and the processor time until then [s]


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option of ``make test-all``."""
    parser.addoption("--budget", action="store_true", help=f"fail what takes over {ALLOWED:g} s of processor time and is not marked slow")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Refuse a marker that does not say why."""
    for item in items:
        for mark in item.iter_markers("slow"):
            if mark.args or set(mark.kwargs) != {"reason"} or not str(mark.kwargs["reason"]).strip():
                raise pytest.UsageError(f'{item.nodeid}: say why: @pytest.mark.slow(reason="...")')


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None, None, None]:
    """Note when the set-up begins."""
    item.stash[BEGIN] = time.time(), processor_time()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """Note when the call begins."""
    item.stash[BEGIN] = time.time(), processor_time()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Fail a phase that passed but took more than is allowed."""
    spent = processor_time() - item.stash[BEGIN][1]
    report = yield
    judged = item.config.getoption("--budget") and report.passed and call.when != "teardown" and item.get_closest_marker("slow") is None
    if judged and spent > ALLOWED and not kept_since(item.stash[BEGIN][0]):
        report.outcome = "failed"
        report.longrepr = (
            f"its {call.when} took {spent:.1f} s of processor time, {ALLOWED:g} s are allowed: make it smaller or mark it slow"
        )
    return report


def processor_time() -> float:
    """Of this process and of those that it started and waited for [s]."""
    return sum(usage.ru_utime + usage.ru_stime for usage in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def kept_since(moment: float) -> bool:
    """Whether any process has put a compiled kernel into numba's cache since a time of day [s]."""
    return any(path.stat().st_mtime >= moment - 0.1 for path in _kept())  # clocks of file systems are coarse


def _kept() -> Iterator[Path]:
    """What numba's cache holds."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    for folder in [Path(chosen)] if chosen else [ROOT / name for name in PACKAGES]:
        yield from folder.rglob("*.nbc")
