r"""Where the time of a shaken scene goes: step by step, phase by phase, and solver by solver.

    python -m benchmarks.profile examples/aqueduct_sinusoidal.toml
    python -m benchmarks.profile examples/church_sine.toml --set run.duration=1 --json

The first table has the steps: under strong shaking a few of them may cost more than all the others. The second has the phases of a step.
The third has what each method did: an iteration's time and instructions per contact, and the bytes that it reads at least, the arrays of
the problem and the factors once, over its time. Beside the bandwidth of the memory that says whether iterations wait for data.

Seconds are those of the processor, on all threads. Instructions are counted where the system gives them (``counters.py``).
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, field
from math import nan
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.counters import Counters
from benchmarks.ours import stepper_of_file
from benchmarks.sitting import head, sitting
from masonry_cd.dynamics import moreau_jean
from masonry_cd.errors import InputError
from masonry_cd.friction.operators import ProblemArrays
from masonry_cd.linalg.symbolic import SymbolicFactor
from masonry_cd.solvers import accelerated, admm, interior, newton, nlgs, pivoting
from masonry_cd.solvers.linearised_bodies import INTERIOR, PATH, PIVOTING, PROXIMAL
from masonry_cd.solvers.nlgs_table import ScaledProblem

PHASES = ("predict", "detect", "assemble", "solve", "update", "account")  # functions of moreau_jean.py
NAMES = {
    INTERIOR: "interior, damped path",
    PATH: "interior, path by its length",
    PROXIMAL: "interior, proximal points",
    PIVOTING: "pivoting",
}
COPIED = 2**25  # doubles copied to measure the bandwidth: 256 MiB, more than caches hold


@dataclass
class Turns:
    """What a method did in all steps."""

    turns: int = 0
    iterations: int = 0
    seconds: float = 0.0
    instructions: float = 0.0
    contacts: float = 0.0  # summed over the iterations
    moved: float = 0.0  # data of the iterations [B]


@dataclass
class Profile:
    """What a run cost."""

    scene: str
    blocks: int  # supports included
    tolerance: float
    seconds: list[float] = field(default_factory=list)  # of each step
    contacts: list[int] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    phases: dict[str, float] = field(default_factory=dict)  # seconds
    methods: dict[str, Turns] = field(default_factory=dict)
    bandwidth: float = nan  # of the memory [B/s]


def profile(path: Path, changes: Sequence[str] = ()) -> Profile:
    """Run a scene file without writing results.

    Args:
        path: of the scene.
        changes: of its keys, as for ``--set``.

    Raises:
        InputError: anything wrong with the scene.
    """
    machine = stepper_of_file(path, ["run.threads=1", *changes])
    out = Profile(path.name, machine.assembly.count, machine.settings.tolerance, bandwidth=_bandwidth())
    with _watched(out):
        for _ in range(machine.settings.steps):
            begin = time.process_time()
            report = machine.step()
            out.seconds.append(time.process_time() - begin)
            out.contacts.append(report.contacts)
            out.errors.append(report.error)
    return out


@contextmanager
def _watched(out: Profile) -> Iterator[None]:
    """Clocks around the phases of a step, and around what each solver calls."""
    counters = Counters.open()

    def phase(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any) -> Any:
            begin = time.process_time()
            found = function(*args)
            out.phases[name] = out.phases.get(name, 0.0) + time.process_time() - begin
            return found

        return call

    def method(function: Callable[..., Any], name: Callable[..., str]) -> Callable[..., Any]:
        def call(*args: Any) -> Any:
            before, begin = counters.read()[0] if counters else nan, time.process_time()
            found = function(*args)
            spent, counted = time.process_time() - begin, counters.read()[0] - before if counters else nan
            turns, iterations, contacts = out.methods.setdefault(name(*args), Turns()), int(found[0]), _contacts_of(args)
            turns.turns += 1
            turns.iterations += iterations
            turns.seconds += spent
            turns.instructions += counted
            turns.contacts += iterations * contacts
            turns.moved += iterations * _data(args)
            return found

        return call

    places: list[tuple[Any, str, Callable[..., Any]]] = [
        *((moreau_jean, name, phase(name, getattr(moreau_jean, name))) for name in PHASES),
        (admm, "run_by_team", method(admm.run_by_team, lambda *_: "admm")),
        (newton, "linearised_bodies", method(newton.linearised_bodies, lambda *_: "newton")),
        (interior, "linearised_bodies", method(interior.linearised_bodies, lambda kind, *_: NAMES[kind])),
        (pivoting, "linearised_bodies", method(pivoting.linearised_bodies, lambda kind, *_: NAMES[kind])),
        (nlgs, "nlgs_bodies", method(nlgs.nlgs_bodies, lambda *_: "nlgs")),
        (accelerated, "run_by_team", method(accelerated.run_by_team, lambda *_: "accelerated")),
    ]
    with ExitStack() as stack:
        for owner, name, watched in places:
            stack.enter_context(patch.object(owner, name, watched))
        yield


def _contacts_of(arguments: Sequence[Any]) -> int:
    """Contacts of the problem among the arguments of a method."""
    return next(len(each.bodies) for each in arguments if isinstance(each, ProblemArrays | ScaledProblem))


def _data(arguments: Sequence[Any]) -> float:
    """Bytes that an iteration reads at least: the arrays that a method is given, and the factors that those of linearised laws make."""
    arrays: dict[int, int] = {}
    symbolic = None
    left = list(arguments)
    while left:
        each = left.pop()
        if isinstance(each, np.ndarray):
            arrays[each.__array_interface__["data"][0]] = each.nbytes
        elif isinstance(each, tuple):
            left.extend(each)
        if isinstance(each, SymbolicFactor):
            symbolic = each
    factors = 0
    if isinstance(arguments[0], int) and symbolic is not None:
        n = next(len(each.n) for each in arguments if isinstance(each, ProblemArrays))
        factors = 8 * n * n * int(symbolic.square[-1] + 2 * symbolic.panel[-1])
    return float(sum(arrays.values()) + factors)


def _bandwidth() -> float:
    """Bytes that one thread copies from memory to memory in a second, read and written: the best of three."""
    here, there = np.zeros(COPIED), np.ones(COPIED)
    spent = []
    for _ in range(3):
        begin = time.perf_counter()
        np.copyto(there, here)
        spent.append(time.perf_counter() - begin)
    return 2.0 * here.nbytes / min(spent)


def tables(out: Profile) -> list[str]:
    """The three tables, see the head of this file."""
    seconds, errors = np.array(out.seconds), np.array(out.errors)
    total, median = seconds.sum(), np.median(seconds)
    above = errors > out.tolerance
    lines = [f"{out.scene}: {out.blocks} blocks, {np.mean(out.contacts):.0f} contacts, {len(seconds)} steps; {sitting()}", ""]
    lines += [head("ms per step: mean", "median", "90 %", "worst", "mean/median", "worst/median", "steps missed", "largest error")]
    cells = [1e3 * seconds.mean(), 1e3 * median, 1e3 * np.quantile(seconds, 0.9), 1e3 * seconds.max()]
    ratios = [seconds.mean() / median, seconds.max() / median]
    lines += [f"| {' | '.join(f'{x:.3g}' for x in cells + ratios)} | {above.sum()} ({100 * above.mean():.1f} %) | {errors.max():.1e} |", ""]
    lines += [head("phase", "ms per step", "share")]
    for name, spent in out.phases.items():
        lines.append(f"| {name} | {1e3 * spent / len(seconds):.3g} | {100 * spent / total:.1f} % |")
    lines += ["", head("method", "turns", "iterations", "share", "us per iteration", "ns per contact", "instructions per contact", "GB/s")]
    for name, each in sorted(out.methods.items(), key=lambda item: -item[1].seconds):
        count, contacts = max(each.iterations, 1), max(each.contacts, 1)
        own = [1e6 * each.seconds / count, 1e9 * each.seconds / contacts, each.instructions / contacts, 1e-9 * each.moved / each.seconds]
        row = [name, str(each.turns), str(each.iterations), f"{100 * each.seconds / total:.1f} %", *(f"{x:.3g}" for x in own)]
        lines.append(f"| {' | '.join(row)} |")
    lines += ["", f"memory to memory: {1e-9 * out.bandwidth:.1f} GB/s"]
    return lines


def main() -> int:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Where the time of a shaken scene goes.")
    parser.add_argument("scene", type=Path, help="a scene file")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="another value of a key of the scene")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    try:
        out = profile(given.scene, given.set)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    print(json.dumps(asdict(out)) if given.json else "\n".join(tables(out)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
