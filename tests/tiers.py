# SPDX-License-Identifier: GPL-3.0-or-later
"""The tiers of the tests, as hooks of pytest: what is slow carries a marker with a reason, and a budget keeps the others quick.

``@pytest.mark.slow(reason="...")`` leaves a test to ``make test-all``. A test without the marker is meant to take ``ALLOWED`` seconds of
processor time at the most, in its process and in those that it waited for. With ``--budget``, one whose call takes ``SLACK`` times that
fails. Compiling says nothing about a test, so a call during which any process put a kernel into the store is not judged. In the end the
seconds of each folder and of the tests that took most are printed, with those of fixtures, and how much memory a process of pytest had.

After each file what its tests have freed goes back to the system: pieces that stay in use, as modules and caches, else keep it in pieces.
"""

from __future__ import annotations

import os
import resource
import time
from collections import Counter
from collections.abc import Generator, Iterator
from pathlib import Path, PurePosixPath

import pytest
from places import ROOT

from masonry_cd.foundation.freed_memory import give_back_freed_memory

ALLOWED = 5.0  # processor time of the call of a test without the marker [s]
SLACK = 3.0  # times as much processor time takes a slow processor whose cores are shared, as seen between two runs of one machine
LISTED = 40  # tests in the list of those that took most
# which keep their compiled kernels, unless NUMBA_CACHE_DIR names a folder
PACKAGES = ("masonry_cd", "structures", "loads", "reports", "tests")
SECONDS = "processor seconds"  # the property of a report that holds those of its phase
MEMORY = "resident memory"  # and the one that holds the most that its process has had until then [GB]
BEGIN = pytest.StashKey[tuple[float, float]]()  # of a phase: the time of day and the processor time until then [s]


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option of ``make test-all``."""
    words = f"fail what takes over {SLACK:g} times SECONDS of processor time, {ALLOWED:g} where none are given, and is not marked slow"
    parser.addoption("--budget", nargs="?", type=float, const=ALLOWED, metavar="SECONDS", help=words)


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
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None, None, None]:
    """Note when the teardown begins; give memory back after the last test of a file."""
    item.stash[BEGIN] = time.time(), processor_time()
    result = yield
    if nextitem is None or nextitem.path != item.path:
        give_back_freed_memory()
    return result


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note what a phase took; fail a call that passed but took more than is allowed."""
    spent = processor_time() - item.stash[BEGIN][1]
    report = yield
    report.user_properties += [(SECONDS, spent), (MEMORY, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024e-9)]
    allowed = item.config.getoption("--budget")
    judged = allowed is not None and report.passed and call.when == "call" and item.get_closest_marker("slow") is None
    if judged and spent > SLACK * allowed and not kept_since(item.stash[BEGIN][0]):
        report.outcome = "failed"
        report.longrepr = f"it took {spent:.1f} s of processor time, {allowed:g} s are meant: make it smaller or mark it slow"
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print the processor time of folders, and of the tests that took most of it, and the memory of the largest process."""
    if config.getoption("--budget") is None:
        return
    tests, folders, most = Counter[str](), Counter[str](), 0.0
    for report in (report for reports in terminalreporter.stats.values() for report in reports if isinstance(report, pytest.TestReport)):
        noted = dict(report.user_properties)
        spent, most = noted.get(SECONDS, 0.0), max(most, noted.get(MEMORY, 0.0))
        tests[report.nodeid] += spent
        folders[str(PurePosixPath(report.nodeid.partition("::")[0]).parent)] += spent
    terminalreporter.section(f"processor time, of {sum(tests.values()):.0f} s")
    terminalreporter.line(", ".join(f"{folder} {spent:.0f} s" for folder, spent in folders.most_common()))
    for name, spent in tests.most_common(LISTED):
        terminalreporter.line(f"{spent:7.1f} s  {name}")
    terminalreporter.line(f"resident memory of a process: {most:.2f} GB at most")


def processor_time() -> float:
    """Return the time of this process and of those that it started and waited for [s]."""
    return sum(usage.ru_utime + usage.ru_stime for usage in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def kept_since(moment: float) -> bool:
    """Return True if any process has put a compiled kernel into numba's cache since a time of day [s]."""
    return any(path.stat().st_mtime >= moment - 0.1 for path in _kept())  # clocks of file systems are coarse


def _kept() -> Iterator[Path]:
    """Yield the files in numba's cache."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    for folder in [Path(chosen)] if chosen else [ROOT / name for name in PACKAGES]:
        yield from folder.rglob("*.nbc")
