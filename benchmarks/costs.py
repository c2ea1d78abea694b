r"""What a call of ADMM and of Newton costs: the weights by which ``auto`` counts, fitted to what is measured here.

    python -m benchmarks.costs
    python -m benchmarks.costs tower50 wall10x10 --steps 20

Each scene is stepped by each method, in a plane and in space, several times over. A step counts with the least seconds of the processor
that it took in any of them; the first step, which starts cold, does not. The fit is one of relative errors, with weights that are not
negative, in which each pair of scene and method counts the same: seconds of all its steps against what its calls had to work with and what
their iterations had to do (``masonry_cd.mechanics.solvers.auto.work``).
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from benchmarks.ours import stepper, warm_up
from benchmarks.scenes import BenchScene, scene
from benchmarks.sitting import head
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution
from masonry_cd.mechanics.solvers import Options, auto
from masonry_cd.mechanics.solvers.admm import Memory

SMALL = ("tower1", "tower3", "tower10", "arch9", "arch27", "tower50", "arcade3", "wall4x5", "wall10x10")
LARGE = ("wall20x20", "arcade50", "wall31x16", "wall40x25", "arcade250")
METHODS = ("admm", "newton")
LIMIT = 100  # iterations of a step
REPEATS = 3


@dataclass(frozen=True)
class Calls:
    """The calls of one method in one scene."""

    scene: str
    planar: bool
    method: str
    microseconds: float  # of all calls together
    calls: int
    iterations: int
    work: np.ndarray  # (8,) sum over the calls, without factorisations, and over the iterations


def measure(made: BenchScene, method: str, planar: bool, steps: int, repeats: int = REPEATS) -> Calls:
    """Step a scene with one method, the same steps ``repeats`` times over."""
    runs = [_calls(made, method, planar, steps) for _ in range(repeats)]
    seconds = np.min([run[0] for run in runs], axis=0)
    iterations, work = runs[0][1:]
    summed = np.concatenate([work.sum(axis=0), iterations @ work])
    summed[3] = 0.0
    return Calls(made.name, planar, method, 1e6 * float(seconds.sum()), len(seconds), int(iterations.sum()), summed)


def _calls(made: BenchScene, method: str, planar: bool, steps: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Seconds (N,), iterations (N,) and work of an iteration (N, 4) of the calls in a run, but for the first."""
    machine = stepper(made, steps, method, planar=planar, max_iterations=LIMIT)
    solve, calls = machine.islands.solver, []

    def timed(problem: FrictionProblem, options: Options, start: Solution) -> Solution:
        begin = time.process_time()
        solution = solve(problem, options, start)
        seconds, memory = time.process_time() - begin, Memory.read(solution.memory)
        assert memory is not None
        calls.append((seconds, solution.iterations, auto.work(problem, memory.pattern)))
        return solution

    machine.islands.solver = timed  # type: ignore[assignment]
    for _ in range(steps):
        machine.step()
    seconds, iterations, work = (np.array(column) for column in zip(*calls[1:], strict=True))
    return seconds, iterations, work


def fit(measured: list[Calls]) -> tuple[np.ndarray, np.ndarray]:
    """Weights (8,) of a call and of an iteration [us], and model over measurement (N,), of the calls of one method."""
    share = np.array([each.work / each.microseconds for each in measured])
    weights, _ = nnls(share, np.ones(len(share)))
    return weights, share @ weights


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="What a call of ADMM and of Newton costs.")
    parser.add_argument("scenes", nargs="*", help=f"names of benchmarks/scenes.py; left out: {' '.join(SMALL + LARGE)}")
    parser.add_argument("--steps", type=int, help=f"of each; left out: 40, or 12 of {', '.join(LARGE)}")
    given = parser.parse_args()
    print(head("method", "scene", "", "iterations", "us/call", "us/iteration", "model/measured"))
    for method in METHODS:
        warm_up(method, 1e-8, {})
        measured = []
        for name in given.scenes or SMALL + LARGE:
            steps = given.steps or (12 if name in LARGE else 40)
            measured += [measure(scene(name), method, planar, steps) for planar in (True, False)]
        weights, ratio = fit(measured)
        for each, r in zip(measured, ratio, strict=True):
            cells = f"{each.iterations / each.calls:.1f} | {each.microseconds / each.calls:.1f} | {each.microseconds / each.iterations:.2f}"
            print(f"| {method} | {each.scene} | {'plane' if each.planar else 'space'} | {cells} | {r:.2f} |")
        call, iteration = (", ".join(f"{w:.2g}" for w in part) for part in np.split(weights, 2))
        print(f"\n{method}: a call {call}; an iteration {iteration}\n", flush=True)


if __name__ == "__main__":
    main()
