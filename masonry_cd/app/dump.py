# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction problems of chosen steps of a run, written to files as they are solved: ``masonry-cd run --dump-problem 120,121``.

The run does not notice: a problem is written after it is solved, and nothing in it is changed. Where a step solves impacts apart from
forces (:mod:`masonry_cd.mechanics.dynamics.impacts`) both problems are written, each as its solver got it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.friction.problem import FrictionProblem

FILES = "problem_[0-9]*.npz"  # what a run may have left in its folder


def parse_steps(words: Sequence[str]) -> tuple[int, ...]:
    """Steps given as ``120`` or ``120,121``, in order and each once; the first step of a run is 1.

    Raises:
        InputError: something that is not a step.
    """
    found = set()
    for word in (part.strip() for text in words for part in text.split(",")):
        if not word.isascii() or not word.isdigit() or len(word) > 9 or int(word) < 1:
            raise InputError("--dump-problem", f'"{word}" is not a step; the first is 1')
        found.add(int(word))
    return tuple(sorted(found))


class Dump:
    """Writes problem_STEP.npz, or problem_STEP_forces.npz and problem_STEP_impacts.npz, into a folder. Give it to ``Stepper.watch``."""

    def __init__(self, folder: Path, steps: Sequence[int]) -> None:
        self.written: list[Path] = []
        self._folder, self._missing = folder, set(steps)
        self._steps = frozenset(steps)

    def check(self, first: int, last: int) -> None:
        """Refuse steps that the run will not make.

        Raises:
            InputError: a step before the first or after the last.
        """
        for step in sorted(self._steps):
            if step > last:
                raise InputError("--dump-problem", f"the run has no step {step}, its last is {last}")
            if step < first:
                raise InputError("--dump-problem", f"step {step} lies before step {first}, at which the run is resumed")

    def __call__(self, step: int, name: str, problem: FrictionProblem) -> None:
        """Write a problem if it belongs to one of the steps."""
        if step in self._steps:
            from masonry_cd.io.problem_files import write_problem  # scipy comes with it

            path = self._folder / f"problem_{step}{'_' if name else ''}{name}.npz"
            write_problem(path, problem)
            self.written.append(path)
            self._missing.discard(step)

    def warnings(self) -> list[str]:
        """Steps that did not come, since the run ended early."""
        return [f"no problem of step {step} was written: the run ended before it" for step in sorted(self._missing)]
