# SPDX-License-Identifier: GPL-3.0-or-later
"""masonry_cd.foundation.workers: processes end with the one that they work for, whichever way it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from masonry_cd.foundation.errors import InputError
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
    """Whether a process is gone, or is a zombie that nobody waits for."""
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
