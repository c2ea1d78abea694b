# SPDX-License-Identifier: GPL-3.0-or-later
r"""Where the time of shaken scenes goes: step by step, phase by phase, and solver by solver.

    python -m benchmarks.profile examples/aqueduct_sinusoidal.toml
    python -m benchmarks.profile examples/church_sine.toml --set run.duration=1 --json
    python -m benchmarks.profile --steps-only --records FOLDER
    python -m benchmarks.profile --against TREE tower50 strong2 heap1000 examples/church_sine.toml

The first table has the steps: under strong shaking a few of them may cost more than all the others. The second has the phases of a step.
The third has what each method did: an iteration's time and instructions per contact, and the bytes that it reads at least, the arrays of
the problem and the factors once, over its time. Next to the bandwidth of the memory that says whether iterations wait for data.

With ``--steps-only`` the first table is all, a line for each scene. No scene given means SHAKEN. The files that scenes name as records are
looked for in the folder given; without one, the scenes of SHAKEN that need them are left out.

With ``--against`` the scenes are stepped in another tree of the program and in this one by turns, and a table has the ratios, see
``turns.py``; scenes may be names, too.

Seconds are those of the processor, on all threads. Instructions are counted where the system gives them (``counters.py``).
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import asdict, dataclass, field
from math import nan
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks import turns
from benchmarks.counters import Counters
from benchmarks.ours import stepper_of_file
from benchmarks.sitting import HERE, head, sitting
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics import moreau_jean
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.solvers import admm, interior, newton, nlgs
from masonry_cd.mechanics.solvers.linearised_bodies import interior_by_team, newton_by_team, path_by_team, pivoting_by_team
from masonry_cd.mechanics.solvers.nlgs_sweep import ScaledProblem
from masonry_cd.mechanics.solvers.recall import Recalled

SHAKEN = (  # strongly: a plane, and in space a church that slides and a larger one
    HERE.parent / "examples/aqueduct_sinusoidal.toml",
    HERE / "church_laquila.toml",
    HERE.parent / "examples/church_sine.toml",
)
PHASES = ("predict", "detect", "assemble", "solve", "update", "account")  # functions of moreau_jean.py
NAMES = {
    interior_by_team: "interior, damped path",
    path_by_team: "interior, path by its length",
    newton_by_team: "newton",
    pivoting_by_team: "pivoting",
}
STEPS = head(
    *("scene", "blocks", "contacts", "steps", "ms per step: mean", "median", "90 %", "worst", "mean/median", "worst/median"),
    *("steps missed", "largest error", "tolerance"),
)
COPIED = 2**25  # doubles copied to measure the bandwidth: 256 MiB, more than caches hold


@dataclass
class Turns:
    """Share of a method over all steps."""

    turns: int = 0
    iterations: int = 0
    seconds: float = 0.0
    instructions: float = 0.0
    contacts: float = 0.0  # summed over the iterations
    moved: float = 0.0  # data of the iterations [B]


@dataclass
class Profile:
    """Cost of a run."""

    scene: str
    blocks: int  # supports included
    tolerance: float
    seconds: list[float] = field(default_factory=list)  # of each step
    contacts: list[int] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)
    phases: dict[str, float] = field(default_factory=dict)  # seconds
    methods: dict[str, Turns] = field(default_factory=dict)
    bandwidth: float = nan  # of the memory [B/s]


def records_in(folder: Path, scene: Path) -> list[str]:
    """Changes of a scene's keys by which the files of its loads are in a folder.

    Raises:
        InputError: no scene.
    """
    paths = ((k, load["path"]) for k, load in enumerate(read_scene(scene).loads) if "path" in load)
    return [f"loads[{k}].path={(folder / Path(path).name).resolve()}" for k, path in paths]


def profile(path: Path, changes: Sequence[str] = (), steps_only: bool = False) -> Profile:
    """Run a scene file without writing results.

    Args:
        path: of the scene.
        changes: of its keys, as for ``--set``.
        steps_only: whether phases and methods are not requested.

    Raises:
        InputError: anything wrong with the scene.
    """
    machine = stepper_of_file(path, ["run.threads=1", *changes])
    out = Profile(path.name, machine.assembly.count, machine.settings.tolerance, bandwidth=nan if steps_only else _bandwidth())
    with nullcontext() if steps_only else _watched(out):
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
        *((owner, "over_bodies", method(owner.over_bodies, lambda by_team, *_: NAMES[by_team])) for owner in (newton, interior)),
        (nlgs, "run_by_team", method(nlgs.run_by_team, lambda *_: "sweeps")),
    ]
    with ExitStack() as stack:
        for owner, name, watched in places:
            stack.enter_context(patch.object(owner, name, watched))
        yield


def _contacts_of(arguments: Sequence[Any]) -> int:
    """Contacts of the problem among the arguments of a method."""
    problems = (each.problem if isinstance(each, ScaledProblem) else each for each in arguments)
    return next(len(each.mu) for each in problems if isinstance(each, ProblemArrays))


def _data(arguments: Sequence[Any]) -> float:
    """Bytes that an iteration reads at least: the arrays that a method is given, and the factors that those of linearised laws make."""
    arrays: dict[int, int] = {}
    left, factors = list(arguments), 0
    while left:
        each = left.pop()
        if isinstance(each, np.ndarray):
            arrays[each.__array_interface__["data"][0]] = each.nbytes
        elif isinstance(each, Recalled):
            factors = 8 * (len(each.factors.squares) + 2 * len(each.factors.panels))
            left.append(each.factors.pattern.symbolic)
        elif isinstance(each, tuple):
            left.extend(each)
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


def line_of_steps(out: Profile) -> str:
    """The line of a scene in the table of steps, whose head is STEPS."""
    seconds, errors = np.array(out.seconds), np.array(out.errors)
    median, above = np.median(seconds), errors > out.tolerance
    spent = [1e3 * seconds.mean(), 1e3 * median, 1e3 * np.quantile(seconds, 0.9), 1e3 * seconds.max()]
    cells = [out.scene, str(out.blocks), f"{np.mean(out.contacts):.0f}", str(len(seconds))]
    cells += [f"{x:.3g}" for x in (*spent, seconds.mean() / median, seconds.max() / median)]
    cells += [f"{above.sum()} ({100 * above.mean():.1f} %)", f"{errors.max():.1e}", f"{out.tolerance:g}"]
    return f"| {' | '.join(cells)} |"


def tables(out: Profile) -> list[str]:
    """The three tables, see the head of this file."""
    total = sum(out.seconds)
    lines = [sitting(), "", STEPS, line_of_steps(out), "", head("phase", "ms per step", "share")]
    for name, spent in out.phases.items():
        lines.append(f"| {name} | {1e3 * spent / len(out.seconds):.3g} | {100 * spent / total:.1f} % |")
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
    parser = argparse.ArgumentParser(description="Where the time of shaken scenes goes.")
    parser.add_argument("scenes", nargs="*", type=Path, help="scene files; left out: three that are shaken hard; with --against names, too")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="another value of a key of the scenes")
    parser.add_argument("--records", type=Path, metavar="FOLDER", help="where the files are that scenes name as records")
    parser.add_argument("--steps-only", action="store_true", help="one table with a line for each scene")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--against", type=Path, metavar="TREE", help="another tree of the program, whose steps are compared")
    parser.add_argument("--set-here", action="append", default=[], metavar="KEY=VALUE", help="with --against: in this tree alone")
    parser.add_argument("--repeat", type=int, default=3, help="with --against: runs of which the quickest counts")
    given = parser.parse_args()
    try:
        run_all(given) if given.against is None else compare(given)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def compare(given: argparse.Namespace) -> None:
    """Step the scenes requested in two trees, and print the ratios as they come."""
    print(f"{sitting()}\n\n{turns.HEAD}", flush=True)
    with turns.process_of(given.against) as against, turns.process_of(HERE.parent) as here:
        for name in map(str, given.scenes or turns.SCENES):
            found = records_in(given.records, Path(name)) if given.records is not None and name.endswith(".toml") else []
            changes = [*found, *given.set]
            print(turns.row((against, here), name, (changes, [*changes, *given.set_here]), given.repeat), flush=True)


def run_all(given: argparse.Namespace) -> None:
    """Run the scenes requested, and print what they cost as it comes."""
    if given.steps_only and not given.json:
        print(f"{sitting()}\n\n{STEPS}", flush=True)
    for scene in given.scenes or SHAKEN:
        if not given.scenes and given.records is None and records_in(HERE, scene):
            print(f"{scene.name} is left out: --records FOLDER names the folder of its records", file=sys.stderr)
            continue
        found = [] if given.records is None else records_in(given.records, scene)
        out = profile(scene, [*found, *given.set], given.steps_only)
        lines = [json.dumps(asdict(out))] if given.json else [line_of_steps(out)] if given.steps_only else [*tables(out), ""]
        print("\n".join(lines), flush=True)


if __name__ == "__main__":
    sys.exit(main())
