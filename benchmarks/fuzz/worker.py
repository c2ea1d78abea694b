# SPDX-License-Identifier: GPL-3.0-or-later
"""A case in a process of its own: forked from one that has imported and compiled everything, within limits of time and memory."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import sys
import time
import traceback
from collections.abc import Sequence
from contextlib import suppress
from io import FileIO, TextIOWrapper
from pathlib import Path

from benchmarks.fuzz.promises import Outcome, left_behind
from masonry_cd.foundation.own_files import LIST

STEPS = 60  # those that warm up included, after which a run is interrupted: a changed duration may ask for a million
ADDRESSES = 6 * 2**30  # in addition to those of the parent [B]
LARGEST_FILE = 2**30  # [B]
WALL = 180.0  # after which a case is stopped [s]
PROCESSOR = 60  # after which the system stops it [s]
FOREIGN = 10.0  # processor time that a file may take in the readers of foreign files, which have 120 s elsewhere [s]
BLOCKS = 3000  # that a structure may have here, 100,000 elsewhere: large ones that are sound would take minutes to build
MOST_STEPS = 1e6  # of a run, 2e7 elsewhere, whose loads take 4 GB and a minute: sound where there is that much
MARK = "interrupted-by-the-worker"
PLAN = "plan"  # begins the names of files that are written of a refused plan, its faults in red


def run_case(folder: Path, command: Sequence[str], output: str) -> Outcome:
    """Run a command line in a folder that holds its files and nothing else."""
    import psutil

    before = {str(path.relative_to(folder)) for path in folder.rglob("*")}
    aside = folder.with_name(folder.name + ".aside")  # what the case says, and its folder for temporary files
    (aside / "tmp").mkdir(parents=True)
    shared = psutil.Process().memory_info().rss  # with which the child begins
    child = os.fork()
    if child == 0:
        _in_child(folder, command, aside)
    status, usage = _waited(child)
    code = None if status is None else os.waitstatus_to_exitcode(status)
    cost = (usage.ru_utime + usage.ru_stime, max(0.0, usage.ru_maxrss * 1024.0 - shared))
    found = outcome(folder, aside, before, output, code, cost)
    shutil.rmtree(aside)
    return found


def outcome(folder: Path, aside: Path, before: set[str], output: str, code: int | None, cost: tuple[float, float]) -> Outcome:
    """How a case ended, by its code, its seconds and bytes, what it said into a folder next to its own, and the files that it left."""
    temporary = [f"tmp/{path.name}" for path in (aside / "tmp").iterdir() if path.name.startswith("masonry")]
    return Outcome(
        code=code,
        stdout=(aside / "stdout").read_text(errors="replace"),
        stderr=(aside / "stderr").read_text(errors="replace"),
        seconds=cost[0],
        memory=cost[1],
        interrupted=(aside / MARK).exists(),
        left=(*left_behind(folder, before, output), *temporary),
        output=output not in before and (folder / output).exists() and not _only_a_plan(folder / output),
    )


def _only_a_plan(output: Path) -> bool:
    """True of a folder that holds files of a plan and the mark of a folder that the program wrote, and nothing else."""
    names = {path.name for path in output.glob("*")} - {LIST}
    return bool(names) and all(name.startswith(PLAN) for name in names)


def _waited(child: int) -> tuple[int | None, resource.struct_rusage]:
    """Wait for a process and its children; None for one that had to be stopped."""
    end, pause = time.monotonic() + WALL, 0.002
    while True:
        found, status, usage = os.wait4(child, os.WNOHANG)
        if found:
            with suppress(ProcessLookupError):
                os.killpg(child, signal.SIGKILL)
            return status, usage
        if time.monotonic() > end:
            with suppress(ProcessLookupError):
                os.killpg(child, signal.SIGKILL)
            return None, os.wait4(child, 0)[2]
        time.sleep(pause)
        pause = min(2.0 * pause, 0.05)


def _in_child(folder: Path, command: Sequence[str], aside: Path) -> None:
    """Become the command line: never returns."""
    code = 99
    try:
        os.setpgid(0, 0)
        os.chdir(folder)
        os.environ["TMPDIR"] = str(aside / "tmp")
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        redirect(aside)
        limit_all()
        _interrupt_after_steps(aside / MARK)
        code = called(command)
    except BaseException:
        traceback.print_exc()
    finally:
        flush()
        os._exit(code)


def redirect(aside: Path) -> None:
    """Have what is said go to files of a folder, whatever the streams were."""
    for number, name in ((1, "stdout"), (2, "stderr")):
        file = os.open(aside / name, os.O_WRONLY | os.O_CREAT)
        os.dup2(file, number)
        os.close(file)
    sys.stdout, sys.stderr = (TextIOWrapper(FileIO(n, "w", closefd=False), encoding="utf-8", errors="backslashreplace") for n in (1, 2))


def flush() -> None:
    """Write what was said."""
    with suppress(BaseException):
        sys.stdout.flush()
        sys.stderr.flush()


def called(command: Sequence[str]) -> int:
    """The exit code of the command line."""
    from masonry_cd.cli import main

    sys.argv = ["masonry-cd", *command]
    try:
        main()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    return 0


def limit_all() -> None:
    """Limits of the system; soft ones, so that the readers of foreign files can set their own."""
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
    wanted = {
        resource.RLIMIT_CPU: PROCESSOR,
        resource.RLIMIT_AS: pages * resource.getpagesize() + ADDRESSES,
        resource.RLIMIT_FSIZE: LARGEST_FILE,
        resource.RLIMIT_CORE: 0,
    }
    for which, most in wanted.items():
        limit(which, most)
    from masonry_cd.mechanics.dynamics import settings
    from structures import size
    from structures.files import foreign

    size.MOST, settings.MOST_STEPS = BLOCKS, MOST_STEPS
    foreign.Limits.__new__.__defaults__ = (FOREIGN, foreign.MEMORY, foreign.OUTPUT)


def limit(which: int, most: int) -> None:
    """A soft limit of the system for this process and those that it starts."""
    resource.setrlimit(which, (most, resource.getrlimit(which)[1]))


def _interrupt_after_steps(mark: Path) -> None:
    """Have Ctrl-C pressed after some steps of a run, which must then end as it promises."""
    from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

    step, done = Stepper.step, [0]

    def counted(stepper: Stepper) -> object:
        result = step(stepper)
        done[0] += 1
        if done[0] == STEPS:
            mark.touch()
            os.kill(os.getpid(), signal.SIGINT)
        return result

    Stepper.step = counted  # type: ignore[assignment,method-assign]
