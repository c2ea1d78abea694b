# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a command: a value, and what is said of it.

A command is a function of :mod:`masonry_cd.app.commands` that takes a checked scene, or a folder or file, and returns a :class:`Result`.
The command line prints it (:mod:`masonry_cd.cli.printing`), Python gets its value and its warnings (:mod:`masonry_cd.interface.returned`).
All that is checked is checked in the command, so that both have it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Generic, TypeVar

T_co = TypeVar("T_co", covariant=True)
Say = Callable[[str], object]  # takes a line while a command is at work


@dataclass(frozen=True)
class Result(Generic[T_co]):
    """The outcome of a command.

    Attributes:
        value: what Python gets.
        lines: for the terminal.
        warnings: what must not pass silently, a line each.
        written: files that the command has written.
        stopped: why it ended before its time; empty where it did not. One of the lines or warnings says so.
        signal: number of the signal that ended it, 0 for none.
        resumable: whether the same command continues it.
    """

    value: T_co
    lines: Sequence[str] = ()
    warnings: Sequence[str] = ()
    written: Sequence[Path] = ()
    stopped: str = ""
    signal: int = 0
    resumable: bool = False


def silent(line: str) -> None:
    """Take a line while a command is at work, and say nothing."""


def said(shown: bool) -> Say:
    """Takes the lines of a command at work, to standard error where they are to be shown."""
    return partial(print, file=sys.stderr, flush=True) if shown else silent
