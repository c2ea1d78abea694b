# SPDX-License-Identifier: GPL-3.0-or-later
r"""Does each tuned constant of ``auto``, and of its methods, earn its place? Scenes are solved with it and without it, and costs compared.

    python -m benchmarks.constants
    python -m benchmarks.constants FACTOR LAST --scenes arch demo

Costs are counted, not timed: the iterations of each method by the weights of ``benchmarks.counted_cost``, so that the table is the same on
any machine. The seconds of the processor are a second witness. A structure that slides is sensitive to rounding, and its cost with it: the
row "shaken 1e-9 more" says how far two runs that do not differ in anything that matters are apart. A constant that gains less than that,
or less than 5 % in every scene, has no place.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import scenes as problems

from benchmarks import ours, packing, served
from benchmarks.counted_cost import cost_of
from benchmarks.scenes import GRAVITY, BenchScene, arcade, arch, tower, wall
from benchmarks.sitting import head
from masonry_cd.mechanics.dynamics import islands
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.friction.problem import FrictionProblem, Problem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import Options, auto

ROOT = Path(__file__).parents[1]
NUDGE = 1e-9  # relative change of the shaking that makes no difference
WORTH = 0.05  # least gain of a constant in its best scene


@dataclass
class Spent:
    """Cost of a scene, and how well it was solved."""

    iterations: dict[str, int] = field(default_factory=lambda: dict.fromkeys(auto.METHODS, 0))  # by method
    cost: float = 0.0  # of these, counted [us]
    steps: int = 0
    missed: int = 0
    error: float = 0.0  # largest natural map error, as a multiple of the tolerance
    seconds: float = 0.0  # of the processor
    counting: float = 0.0  # seconds of the processor for the counts themselves

    def judge(self, error: float, tolerance: float) -> None:
        """Take in a step."""
        self.steps += 1
        self.missed += not error <= tolerance
        self.error = max(self.error, error / tolerance)


Scene = Callable[[float, Spent], None]  # runs it with the shaking multiplied by a factor


def _stepped(made: BenchScene, steps: int, tolerance: float = 1e-8, **settings: Any) -> Scene:
    """Steps of a scene of ``benchmarks.scenes``."""

    def run(factor: float, spent: Spent) -> None:
        _step(ours.stepper(replace(made, amplitude=factor * made.amplitude), steps, "auto", tolerance, **settings), steps, spent)

    return run


def _side_by_side(large: BenchScene, small: BenchScene, apart: float) -> BenchScene:
    """Two structures on one base, so far apart along x [m]; they shake as the first does."""
    moved = [replace(block, name=f"next {block.name}", vertices=block.vertices + [apart, 0.0, 0.0]) for block in small.blocks]
    return replace(large, blocks=(*large.blocks, *moved))


def _file(path: str, *changes: str) -> Scene:
    """The steps of a scene file."""

    def run(factor: float, spent: Spent) -> None:
        machine = ours.stepper_of_file(ROOT / path, changes, factor)
        _step(machine, machine.settings.steps, spent)

    return run


def _step(machine: Stepper, steps: int, spent: Spent) -> None:
    begin = time.process_time()
    for _ in range(steps):
        spent.judge(machine.step().error, machine.settings.tolerance)
    spent.seconds += time.process_time() - begin


def _cold(made: Callable[[float], Sequence[Problem]], tolerance: float) -> Scene:
    """Problems that are solved once each, with no step before."""

    def run(factor: float, spent: Spent) -> None:
        for problem in made(factor):
            begin = time.process_time()
            solution = auto.solve(problem, Options(tolerance=tolerance))
            spent.seconds += time.process_time() - begin
            spent.judge(natural_map_error(problem, solution.impulse), tolerance)

    return run


def _poured(factor: float, spent: Spent) -> None:
    """Spheres poured into a box, whose sides the factor multiplies."""
    asked = packing.arguments().parse_args(["300", *served.PACKING])
    asked.width *= factor
    machine, _ = packing.stepper(asked, asked.friction[0])
    _step(machine, machine.settings.steps, spent)


def _packings(factor: float) -> list[FrictionProblem]:
    return [problems.packing(cells, 0.8, speed * factor) for cells in (3, 4) for speed in (0.01, 0.05, 0.2)]


def _thrown(factor: float) -> list[FrictionProblem]:
    return [problems.thrown(speed * factor) for speed in (0.05, 0.3, 1.0)]


def _local(factor: float) -> list[Problem]:
    bodies: list[FrictionProblem] = [*_thrown(factor), problems.packing(3, 0.8, 0.05 * factor), problems.tower(20)]
    return [problem.to_local() for problem in bodies]


def _jolted(made: BenchScene, share: float, frequency: float) -> BenchScene:
    """The scene on a base that shakes at a share of gravity."""
    return replace(made, amplitude=share * GRAVITY / (2.0 * np.pi * frequency), frequency=frequency)


SCENES: dict[str, Scene] = {
    "tower at rest": _stepped(tower(50, amplitude=0.0), 200),
    "wall at rest": _stepped(wall(10, 10, amplitude=0.0), 200),
    "tower": _stepped(tower(50), 200),
    "arch": _stepped(arch(27), 300),
    "arcade": _stepped(arcade(3), 200),
    "wall": _stepped(wall(10, 10), 150),
    "wall, 1 g": _stepped(_jolted(wall(6, 6), 1.0, 2.0), 300),
    "wall, space": _stepped(wall(6, 6), 60, 1e-6, planar=False),
    "demo": _file("examples/aqueduct_sinusoidal.toml", "run.duration=0.5"),
    "church": _file("benchmarks/bits/church.toml"),
    "large church": _file("examples/church_sine.toml", "run.duration=0.1"),
    "sliding church": _file("examples/church_sine.toml", "run.duration=0.8"),
    "Arles": _file("examples/aqueduct_arles.toml", "run.duration=0.8"),
    "debris": _file("benchmarks/bits/debris.toml"),
    "islands": _file("benchmarks/bits/islands.toml"),
    "elastic": _file("benchmarks/bits/elastic.toml"),
    "arcade next to a slender tower": _stepped(_side_by_side(arcade(4, amplitude=0.05), tower(40, side=0.25), 80.0), 200),
    "poured grains": _poured,
    "packed grains": _cold(_packings, 1e-8),
    "thrown walls": _cold(_thrown, 1e-8),
    "local": _cold(_local, 1e-8),
}

# What each constant is set to where it is switched off.
SWITCHED: dict[str, Any] = {
    "GRAINS": 10**9,  # no scene is swept
    "SINGLE": np.inf,  # all are in space, stacks of blocks too
    "SWEEPS": 400,
    "MOST": 15,  # ADMM always has as many iterations
    "FACTOR": 1,  # or 1,000
    "ROUGH": -1.0,  # pivoting is not asked
    "LAST": 120,
    "OPERATIONS": 0.0,  # no method that factorises in space is asked
    "admm.OPEN": 1.0,  # R of open contacts as of those that stick
    "admm.SLIDES": 1.0,
    "admm.PROBE": 10**9,  # no other k is tried
    "islands.EASY": 10**9,  # no island is solved alone since it is hard
    "islands.FULL": 10**9,  # those that are not are one group
    "interior.LEAVE": 1.0,  # the damped path is followed to the tolerance, that by its length to CLOSE
}


@contextmanager
def switched(name: str, value: Any) -> Iterator[None]:
    """``auto``, or the module before the dot, with another value of one of its constants."""
    place, _, constant = name.rpartition(".")
    module = auto if not place else islands if place == "islands" else getattr(auto, place)
    kept = getattr(module, constant)
    setattr(module, constant, value)
    try:
        yield
    finally:
        setattr(module, constant, kept)


@contextmanager
def counted(spent: Spent) -> Iterator[None]:
    """``auto`` with all that it spends added up."""
    methods = auto.METHODS

    def count(name: str) -> SimpleNamespace:
        def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
            found = methods[name].solve(problem, options, start)
            begin = time.process_time()
            spent.iterations[name] += found.iterations
            spent.cost += cost_of(name, problem, found)
            spent.counting += time.process_time() - begin
            return found

        return SimpleNamespace(solve=solve)

    auto.METHODS = {name: count(name) for name in methods}  # type: ignore[misc]
    try:
        yield
    finally:
        auto.METHODS = methods


def measure(scene: Scene, factor: float = 1.0) -> Spent:
    """Run a scene with its shaking multiplied by a factor."""
    spent = Spent()
    with counted(spent):
        scene(factor, spent)
    spent.seconds -= spent.counting
    return spent


HEAD = ("without", "scene", *auto.METHODS, "cost [ms]", "ratio", "missed", "largest error", "CPU [s]", "ratio")


def row(what: str, scene: str, found: Spent, usual: Spent) -> str:
    """A line of the table; errors are multiples of the tolerance."""
    counts = (*found.iterations.values(), f"{1e-3 * found.cost:.1f}", f"{found.cost / usual.cost:.2f}")
    ends = (f"{found.missed} of {found.steps}", f"{found.error:.2g}", f"{found.seconds:.2f}", f"{found.seconds / usual.seconds:.2f}")
    return "| " + " | ".join(map(str, (what, scene, *counts, *ends))) + " |"


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Does each tuned constant of auto earn its place?")
    parser.add_argument("constants", nargs="*", help=f"left out: {' '.join(SWITCHED)}")
    parser.add_argument("--scenes", nargs="*", help=f"beginnings of names; left out: {', '.join(SCENES)}")
    given = parser.parse_args()
    chosen = {name: scene for name, scene in SCENES.items() if not given.scenes or name.startswith(tuple(given.scenes))}
    for scene in chosen.values():  # kernels are compiled, or loaded from their cache
        measure(scene)
    print(head(*HEAD))
    usual = {name: measure(scene) for name, scene in chosen.items()}
    for name, found in usual.items():
        print(row("", name, found, found), flush=True)
    for name, scene in chosen.items():
        print(row("shaken 1e-9 more", name, measure(scene, 1.0 + NUDGE), usual[name]), flush=True)
    for constant in given.constants or SWITCHED:
        with switched(constant, SWITCHED[constant]):
            for name, scene in chosen.items():
                found = measure(scene)
                if found.iterations != usual[name].iterations:
                    print(row(constant, name, found, usual[name]), flush=True)


if __name__ == "__main__":
    main()
