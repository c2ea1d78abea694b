# SPDX-License-Identifier: GPL-3.0-or-later
"""The factor at which rigid blocks begin to move under a held push, by the dynamics: trials, several at a time, narrow it down.

A trial holds the push from rest, on rigid joints, for SECONDS. The blocks move if one goes farther than MOVED of the smallest width. They
stand if none does, or if for REST steps on end the fastest would not go a thousandth as far in the time that is left: under a constant
load blocks that rest go on resting.

Factors spread over a range are tried at once, each in a process of its own, and what is left between the greatest that stands and the least
that moves is divided again, until it is narrow enough. A trial ends as soon as another one has decided it: a push greater than one that
moves the blocks moves them, too. Trials tell how far they are from time to time, so that a search that is stopped has a bracket as well.
"""

from __future__ import annotations

import math
import multiprocessing as mp
import queue
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly

GRAVITY = 9.81  # [m/s2]
SECONDS = 1.5  # that a push is held
MOVED = 0.01
REST, SLOW = 10, 1e-3
STEP = 5e-3  # [s]
TOLERANCE = 1e-6  # natural map error of a step
OFTEN = 5.0  # seconds between two words of a trial
BELOW, ABOVE = 0.97, 1.02  # how far the range reaches beyond the two factors that are guessed
FARTHER = 1.1  # times as far, or less far, where the factor is beyond


@dataclass(frozen=True)
class Trial:
    """A push and what the blocks did so far."""

    factor: float
    verdict: str  # "stands", "moves", "undecided" yet, or "left" to a trial that decides it
    time: float = 0.0  # reached [s]
    gone: float = 0.0  # farthest way of a block, over the smallest width
    missed: int = 0  # steps above their tolerance
    seconds: float = 0.0  # of the processor


@dataclass
class Bracket:
    """Bracket of the factor; an end that no trial gave is None."""

    low: float | None = None
    high: float | None = None
    trials: dict[float, Trial] = field(default_factory=dict)

    def add(self, trial: Trial) -> None:
        """Take in how far a trial is."""
        self.trials[trial.factor] = trial
        if trial.verdict == "stands":
            self.low = max(trial.factor, self.low or 0.0)
        elif trial.verdict == "moves":
            self.high = min(trial.factor, self.high or np.inf)

    def numbers(self) -> dict[str, Any]:
        """For a JSON file."""
        return {"stands": self.low, "moves": self.high, "trials": [asdict(self.trials[factor]) for factor in sorted(self.trials)]}


def hold(assembly: Assembly, direction: Sequence[float], factor: float, seen: Callable[[Trial], bool], within: float = np.inf) -> Trial:
    """Hold a push; ``seen`` gets each step and says whether to leave it, ``within`` are seconds of the clock after which it ends."""
    steps = round(SECONDS / STEP)
    pull = np.tile(GRAVITY * (factor * np.asarray(direction) - [0.0, 0.0, 1.0]), (steps + 1, 1))
    run = Run.model_validate({"dt": STEP, "duration": SECONDS, "tolerance": TOLERANCE})
    machine = Stepper(assembly, np.zeros((steps + 1, 1, 3)), pull, run)
    begin, clock, resting, missed = time.process_time(), time.monotonic(), 0, 0
    for k in range(1, steps + 1):
        missed += machine.step().error > TOLERANCE
        gone = float(np.abs(machine.state.position - assembly.centre).max() / assembly.width)
        speed = float(np.abs(machine.state.velocity).max() / assembly.width)
        resting = resting + 1 if speed * (SECONDS - k * STEP) <= SLOW * MOVED else 0
        verdict = "moves" if gone > MOVED else "stands" if resting >= REST or k == steps else "undecided"
        trial = Trial(factor, verdict, k * STEP, gone, missed, time.process_time() - begin)
        if verdict != "undecided":
            return trial
        if seen(trial):
            return Trial(factor, "left", k * STEP, gone, missed, trial.seconds)
        if time.monotonic() - clock > within:
            break
    return trial


def bracket(
    assembly: Assembly,
    direction: Sequence[float],
    guesses: tuple[float, float],
    share: float,
    jobs: int = 1,
    within: float = np.inf,
    report: Callable[[Bracket, Trial], None] = lambda bracket, trial: None,
) -> Bracket:
    """A factor at which the structure stands and one at which it moves.

    Args:
        assembly: the structure.
        direction: (3,) unit, of the push.
        guesses: between which the factor is likely to lie.
        share: how far the two may be apart, over the greater guess.
        jobs: trials at a time, each in a process of its own.
        within: seconds of the clock after which no trial goes on.
        report: is given the bracket so far, and the trial that has said something.
    """
    search = _Search(assembly, direction, jobs, time.monotonic() + within, report)
    found = search.found
    low, high = BELOW * guesses[0], ABOVE * guesses[1]  # believed
    close = share * guesses[1]
    while time.monotonic() < search.end:
        first, last = found.low or low, found.high or high
        parts = min(jobs + 1, math.ceil((last - first) / close - 1e-9))
        inside = np.linspace(first, last, parts + 1)[1:-1]
        if parts < 2 and found.low is None:
            inside, low = np.array([first]), first / FARTHER
        elif parts < 2 and found.high is None:
            inside, high = np.array([last]), last * FARTHER
        elif parts < 2:
            break
        search.one_by_one(inside) if jobs == 1 else search.at_once(inside)
    return found


class _Search:
    """Trials of a structure, and what they have shown so far."""

    def __init__(
        self, assembly: Assembly, direction: Sequence[float], jobs: int, end: float, report: Callable[[Bracket, Trial], None]
    ) -> None:
        self.what, self.jobs, self.end, self.report = (assembly, direction), jobs, end, report
        self.found = Bracket()

    def one_by_one(self, factors: np.ndarray) -> None:
        """Try factors that rise until one moves the blocks."""
        for factor in factors:
            trial = hold(*self.what, float(factor), lambda trial: False, self.end - time.monotonic())
            self.found.add(trial)
            self.report(self.found, trial)
            if trial.verdict == "moves":
                return

    def at_once(self, factors: np.ndarray) -> None:
        """Try factors that rise, ``jobs`` at a time."""
        context = mp.get_context("spawn")
        words: Any = context.Queue()
        known = context.Array("d", [0.0, np.inf])
        waiting, at_work = [float(factor) for factor in factors], dict[float, Any]()
        while waiting or at_work:
            low, high = self.found.low or 0.0, self.found.high or np.inf
            with known.get_lock():
                known[0], known[1] = low, high
            waiting = [factor for factor in waiting if low < factor < high and time.monotonic() < self.end]
            while waiting and len(at_work) < self.jobs:
                factor = waiting.pop(0)
                work = (*self.what, factor, known, words, self.end - time.monotonic())
                at_work[factor] = context.Process(target=_work, args=work, daemon=True)
                at_work[factor].start()
            try:
                trial, ended = words.get(timeout=OFTEN)
            except queue.Empty:
                _none_lost(at_work)
                continue
            self.found.add(trial)
            if ended:
                at_work.pop(trial.factor).join()
            self.report(self.found, trial)


def _none_lost(at_work: dict[float, Any]) -> None:
    """Stop where a process has failed, as for want of memory."""
    for factor, worker in at_work.items():
        if worker.exitcode:
            raise RuntimeError(f"the trial of factor {factor:.4g} ended with exit code {worker.exitcode}")


def _work(assembly: Assembly, direction: Sequence[float], factor: float, known: Any, words: Any, within: float) -> None:
    """A trial in a process of its own."""
    last = time.monotonic()
    words.put((Trial(factor, "undecided"), False))

    def seen(trial: Trial) -> bool:
        nonlocal last
        if time.monotonic() - last > OFTEN:
            last = time.monotonic()
            words.put((trial, False))
        return not known[0] < factor < known[1]

    words.put((hold(assembly, direction, factor, seen, within), True))
