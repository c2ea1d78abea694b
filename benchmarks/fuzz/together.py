# SPDX-License-Identifier: GPL-3.0-or-later
"""Many cases in one process, one after the other: some 50 times as many a minute where a case alone starts Python and a library.

Readers of foreign files run here without a child of theirs. What ends the process, or breaks a promise in it, is judged by the same case
in a process of its own (:mod:`benchmarks.fuzz.worker`), as users run it.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

from benchmarks.fuzz import promises, worker
from benchmarks.fuzz.promises import Outcome
from structures.files import foreign

COMMANDS = ("build", "record", "solve", "study")  # that leave nothing behind in the process; a run is interrupted by a signal
PEAK = Path("/proc/self/clear_refs")  # Linux: "5" has the largest resident size measured from there on


class Case(NamedTuple):
    """A case to be run."""

    files: dict[str, bytes]
    command: list[str]
    output: str  # what the command may write


def laid_out(files: dict[str, bytes], folder: Path) -> Path:
    """A folder with files."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


def alone(case: Case, folder: Path) -> Outcome:
    """A case in a process of its own."""
    place = laid_out(case.files, folder / "case")
    found = worker.run_case(place, case.command, case.output)
    shutil.rmtree(place)
    return found


def run_cases(cases: Sequence[Case], folder: Path) -> Iterator[Outcome]:
    """Run cases in as few processes as they leave alive."""
    at = 0
    while at < len(cases):
        for found in _in_one(cases[at:], folder):
            yield alone(cases[at], folder) if promises.broken(found) else found
            at += 1
        if at < len(cases):  # which ended the process
            yield alone(cases[at], folder)
            at += 1


def _in_one(cases: Sequence[Case], folder: Path) -> Iterator[Outcome]:
    """The outcomes of a process, as long as it lives."""
    mine, its = Pipe(duplex=False)
    child = os.fork()
    if child == 0:
        _serve(cases, folder, its)
    its.close()
    with suppress(EOFError):
        for _ in cases:
            if not mine.poll(worker.WALL):
                break
            yield mine.recv()
    with suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    for place in ("together", "together.aside"):
        shutil.rmtree(folder / place, ignore_errors=True)


def _serve(cases: Sequence[Case], folder: Path, answers: Connection) -> None:
    """Run cases and send how they ended: never returns."""
    try:
        os.setpgid(0, 0)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        worker.limit_all()
        with readers_here():
            for case in cases:
                answers.send(_ended(case, folder))
    finally:
        os._exit(0)


def keep_commands() -> None:
    """Have the command line made once: that takes longer than most cases."""
    from typer.main import get_command

    from masonry_cd.cli import app

    app.app = get_command(app.app)  # type: ignore[assignment]


@contextmanager
def readers_here() -> Iterator[None]:
    """Readers of foreign files run in this process, in the folder that a child of theirs would have."""
    apart = foreign._run
    foreign._run = _read_here
    yield
    foreign._run = apart


def _read_here(folder: Path, limits: foreign.Limits) -> int | None:
    """Answer the request in a folder: 0, the exit code of a child that answers."""
    home, streams = Path.cwd(), [os.dup(number) for number in (1, 2)]
    os.chdir(folder)
    said = os.open("said", os.O_WRONLY | os.O_CREAT)
    for number in (1, 2):  # libraries print by themselves
        os.dup2(said, number)
    try:
        foreign.answer(json.loads(Path("request.json").read_text(encoding="utf-8")))
    finally:
        for number, stream in zip((1, 2), streams, strict=True):
            os.dup2(stream, number)
        for opened in (said, *streams):
            os.close(opened)
        os.chdir(home)
    return 0


def _ended(case: Case, folder: Path) -> Outcome:
    """How a case ends in this process."""
    place, aside = laid_out(case.files, folder / "together"), folder / "together.aside"
    before = {str(path.relative_to(place)) for path in place.rglob("*")}
    (aside / "tmp").mkdir(parents=True)
    os.chdir(place)
    tempfile.tempdir = str(aside / "tmp")
    worker.redirect(aside)
    begin = time.process_time()
    worker.limit(resource.RLIMIT_CPU, int(begin) + worker.PROCESSOR)
    PEAK.write_text("5", encoding="utf-8")
    with warnings.catch_warnings():  # each is shown once more
        try:
            code = worker.called(case.command)
        except BaseException:
            traceback.print_exc()
            code = 99
    worker.flush()
    found = worker.outcome(place, aside, before, case.output, code, (time.process_time() - begin, _peak()))
    os.chdir(folder)
    shutil.rmtree(place)
    shutil.rmtree(aside)
    return found


def _peak() -> float:
    """The largest resident size of this process since it was last reset [B]."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return 1024.0 * next(float(line.split()[1]) for line in lines if line.startswith("VmHWM"))
