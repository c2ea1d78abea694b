# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes end with the one that they work for, keep freed memory until it is given back, and keep their signals while gmsh is at work."""

from __future__ import annotations

import os
import platform
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.gmsh_session import gmsh_session
from masonry_cd.foundation.workers import workers

PATIENCE = 60.0  # until something that always happens counts as missing [s]
PROGRAM = """
import os, signal, sys, time
from pathlib import Path
from masonry_cd.foundation.workers import workers

def task(folder):
    (Path(folder) / str(os.getpid())).touch()
    time.sleep(600)

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # tests in the background of a shell inherit that it is ignored
    with workers(2, sys.argv[2]) as pool:
        for run in [pool.submit(task, sys.argv[1]) for _ in range(5)]:
            run.result()
"""


def ended(pid: int) -> bool:
    """True for a process that is gone, or is a zombie that nobody waits for."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def until(what) -> None:
    """Wait for something."""
    last = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < last, "it did not happen"
        time.sleep(0.02)


@pytest.mark.skipif(not Path("/proc/self/stat").exists() or not hasattr(os, "killpg"), reason="looks at processes in /proc")
@pytest.mark.parametrize("begins", ["fork", "spawn"])
@pytest.mark.parametrize("numbers", [(signal.SIGKILL,), (signal.SIGINT, signal.SIGINT)], ids=["killed", "Ctrl-C twice"])
def test_no_worker_outlives_its_program(numbers: tuple[int, ...], begins: str, tmp_path: Path) -> None:
    script, folder = tmp_path / "program.py", tmp_path / "pids"
    script.write_text(PROGRAM)
    folder.mkdir()
    program = subprocess.Popen([sys.executable, str(script), str(folder), begins], start_new_session=True, stderr=subprocess.PIPE)
    until(lambda: len(list(folder.iterdir())) == 2)
    for number in numbers:
        if number == signal.SIGINT:
            os.killpg(program.pid, number)  # as a terminal does: to all of them
        else:
            program.kill()
    said = program.communicate(timeout=PATIENCE)[1].decode()
    assert all(word not in said for word in ("InvalidStateError", "BrokenProcessPool"))  # the interrupt alone, which it does not catch
    until(lambda: all(ended(int(path.name)) for path in folder.iterdir()))
    assert len(list(folder.iterdir())) == 2  # no further task was begun


def die(_: int) -> None:
    """Die as a process does that wants too much memory."""
    os._exit(9)


def test_a_worker_that_dies_is_a_line() -> None:
    with pytest.raises(InputError, match="memory"), workers(1) as pool:
        pool.submit(die, 0).result()


FAULTS = """
import resource
import numpy as np
from masonry_cd.foundation.freed_memory import keep_freed_memory

def step():
    arrays = [np.ones(400_000) for _ in range(5)]  # 16 MB in all, each mapped by itself at first

{first}
for _ in range(3):
    step()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(10):
    step()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""

PIECES = """
from pathlib import Path
import numpy as np
from masonry_cd.foundation.freed_memory import give_back_freed_memory, keep_freed_memory

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1])

keep_freed_memory()
before = resident()
large, small = [], []
for _ in range(100):  # of 1 MB each, and pieces that stay between them
    large.append(np.ones(125_000))
    small.append(np.ones(200))
most = resident()
large.clear()
give_back_freed_memory()
print((resident() - before) / (most - before))
"""


def faults(first: str, **environment: str) -> int:
    """Pages that the system gives to ten steps which free 16 MB each, in a process of its own."""
    command, own = [sys.executable, "-c", FAULTS.format(first=first)], {key: os.environ[key] for key in os.environ if "MALLOC" not in key}
    return int(subprocess.run(command, capture_output=True, check=True, text=True, env=own | environment).stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
@pytest.mark.parametrize("environment", [{}, {"MALLOC_TRIM_THRESHOLD_": "65536"}], ids=["alone", "in a worker of dask"])
def test_what_is_freed_is_kept(environment: dict[str, str]) -> None:
    """Ten steps that free 16 MB each are given hardly a page, thousands otherwise. A busy system may count pages that it moves, too."""
    assert faults("keep_freed_memory()", **environment) < 0.1 * faults("", **environment)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
def test_what_lies_between_pieces_in_use_is_given_back() -> None:
    """When 100 MB are freed, the pieces between which it lies keep less than a tenth."""
    own = {key: os.environ[key] for key in os.environ if "MALLOC" not in key}
    assert float(subprocess.run([sys.executable, "-c", PIECES], capture_output=True, check=True, text=True, env=own).stdout) < 0.1


STATUS = Path("/proc/self/status")


def ignored() -> set[int]:
    """The signals that the system does not deliver to this process."""
    mask = int(re.search(r"SigIgn:\s*(\w+)", STATUS.read_text(encoding="utf-8")).group(1), 16)
    return {number for number in range(1, 65) if mask >> (number - 1) & 1}


@pytest.mark.skipif(not (STATUS.exists() and hasattr(signal, "SIGHUP")), reason="Linux tells here which signals are ignored")
def test_signals_that_are_ignored_stay_so(request):
    former = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    request.addfinalizer(lambda: signal.signal(signal.SIGHUP, former))
    before = ignored()
    assert {signal.SIGHUP, signal.SIGPIPE} <= before
    with gmsh_session():
        assert ignored() == before
    assert ignored() == before
