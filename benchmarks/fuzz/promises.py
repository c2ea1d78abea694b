# SPDX-License-Identifier: GPL-3.0-or-later
"""Promises of the program for every input, however damaged, and the check that a case kept them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

LONGEST = 1000  # characters of a line that a person reads
SECONDS = 30.0  # of processor time
MEMORY = 2e9  # resident [B], where what reads foreign files may have twice as many addresses
ERROR, WARNING = "masonry-cd: error: ", "masonry-cd: warning: "
STOPPED = re.compile(r"masonry-cd: interrupted.*|masonry-cd: continue with: .*|.*finishing the step.*")
FAULT = re.compile(
    r"(walls?|legs|opening|vault|roof|columns|arcade|buttress) |\S+:\d+: structure\.|\S+\.(json|dxf|ifc): |and \d+ more faults$"
)  # of a plan or a block, all at once
NOTES = re.compile(r"compiling.*|building .*")


@dataclass(frozen=True)
class Outcome:
    """How a case ended."""

    code: int | None  # exit code; negative for a signal; None where it had to be stopped
    stdout: str
    stderr: str
    seconds: float  # of processor time
    memory: float  # largest resident size, beyond that of the process that it was forked from [B]
    interrupted: bool  # by the worker, since it had made its steps
    left: tuple[str, ...]  # files and folders that were not there before, the output apart
    output: bool  # whether the output is there


def broken(outcome: Outcome) -> str:
    """The first promise that a case broke, as text; empty where it kept them all."""
    lines = [line for line in outcome.stderr.split("\n") if line and not NOTES.fullmatch(line)]
    if outcome.code is None:
        return "did not end"
    if outcome.code < 0:
        return f"ended by signal {-outcome.code}"
    if "Traceback" in outcome.stderr or "Traceback" in outcome.stdout:
        return "traceback"
    if outcome.code not in ((0, 1, 2, 130) if outcome.interrupted else (0, 1, 2)):
        return f"exit code {outcome.code}"
    wrong = _of_lines(outcome, lines)
    if wrong:
        return wrong
    if outcome.seconds > SECONDS:
        return f"took {outcome.seconds:.0f} s"
    if outcome.memory > MEMORY:
        return f"took {outcome.memory / 1e9:.1f} GB"
    if any(name.endswith((".part", ".tmp")) or ".part." in name for name in outcome.left):
        return f"left {outcome.left[0]}"
    if outcome.left:
        return f"wrote {', '.join(outcome.left)[:200]}"
    return "left an output after a refusal" if outcome.code == 2 and outcome.output else ""


def _of_lines(outcome: Outcome, lines: list[str]) -> str:
    """Describe the fault in the lines on standard error."""
    unreadable = next((line for line in [*lines, *outcome.stdout.split("\n")] if not line.isprintable()), None)
    if unreadable is not None:
        return "control characters in a line"
    if any(len(line) > LONGEST for line in [*lines, *outcome.stdout.split("\n")]):
        return "a line of more than 1000 characters"
    if outcome.code == 2:
        one = bool(lines) and lines[0].startswith(ERROR) and all(FAULT.match(line) for line in lines[1:])
        return "" if one else f"{len(lines)} lines for a refusal"
    allowed = [line for line in lines if line.startswith(WARNING) or STOPPED.fullmatch(line)]
    if len(allowed) < len(lines):
        return "other lines on standard error"
    if outcome.code == 1 and not any("the run ended early" in line for line in lines):
        return "exit code 1 without a reason"
    return ""


def left_behind(folder: Path, before: set[str], output: str) -> tuple[str, ...]:
    """Files and folders below a folder that were not there, the output apart."""
    now = {str(path.relative_to(folder)) for path in folder.rglob("*")}
    return tuple(sorted(name for name in now - before if name.split("/")[0] != output or name.endswith(".part") or ".part." in name))
