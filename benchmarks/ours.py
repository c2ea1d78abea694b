# SPDX-License-Identifier: GPL-3.0-or-later
r"""Step a scene with masonry_cd and say what it cost and how well it was solved.

    python -m benchmarks.ours wall10x10 --solver auto --tolerance 1e-8 --steps 200

The seconds of a step are those of the whole step: detection, assembly, solution, its error measure, energy account. The error is the
natural map error that the program itself writes down for each step, measured outside the solver. What numba compiles or loads
on first use is called once before, on a small scene. On a machine that does other things too, compare the instructions of a step, where the
processor counts them: they vary by less than 1 %.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.counters import Counters
from benchmarks.scenes import GRAVITY, BenchScene, scene, tower
from loads.bars import Forces, PointLoad
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper, StepReport
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.solvers import SOLVERS


@dataclass(frozen=True)
class Measured:
    """Cost of a run, and how well it was solved."""

    scene: str
    solver: str
    tolerance: float
    planar: bool
    blocks: int  # supports included
    contacts: float  # of the friction problem, mean over the steps; in a plane half of those in space
    steps: int
    first_ms: float  # the first step starts cold
    first_iterations: int
    median_ms: float
    processor_ms: float  # median, of the processor: other programs disturb it least
    mean_ms: float  # over the steps after the first
    instructions: float  # of the processor, mean over the steps after the first [1000]; nan where it does not count them
    cycles: float  # likewise
    iterations: float  # mean over the steps
    error_median: float
    error_max: float
    missed: int  # steps above the tolerance
    detection_share: float  # of the time of all steps
    penetration: float  # largest [m]
    reasons: dict[str, int]  # the solver's words on the steps, without numbers


def stepper(made: BenchScene, steps: int, solver: str = "auto", tolerance: float = 1e-8, **settings: Any) -> Stepper:
    """A stepper at the start of a scene.

    Args:
        made: the scene.
        steps: to be taken.
        solver: by name.
        tolerance: natural map error of each step.
        **settings: other keys of the table [run], e.g. ``planar``, ``threads``, ``max_iterations``, ``seed``.

    Raises:
        ValueError: a solver that this version does not have.
    """
    if solver not in SOLVERS:
        raise ValueError(f'no solver "{solver}"; this version has {", ".join(SOLVERS)}')
    run = Run.model_validate(
        {"dt": made.dt, "duration": made.dt * steps, "theta": made.theta, "solver": solver, "tolerance": tolerance, "threads": 1} | settings
    )
    velocity = np.zeros((steps + 1, 1, 3))
    velocity[:, 0, :] = made.base_velocity(steps)[:, None] * made.direction
    held = PointLoad(len(made.blocks) - 1, np.zeros(3), np.array(made.force), np.ones(steps + 1))
    forces = Forces((held,), ()) if any(made.force) else None
    return Stepper(made.assembly(), velocity, np.tile([0.0, 0.0, -GRAVITY], (steps + 1, 1)), run, forces=forces)


def stepper_of_file(path: Path, changes: Sequence[str] = (), factor: float = 1.0) -> Stepper:
    """A stepper at the start of a scene file, settled on its joints.

    Args:
        path: of the scene.
        changes: of its keys, as for ``--set``.
        factor: by which its supports are shaken more.

    Raises:
        InputError: anything wrong with the scene.
    """
    case = prepare(read_scene(path, list(changes)))
    loading, settings = case.loading, case.scene.run
    machine = Stepper(case.assembly, factor * loading.support_velocity, loading.acceleration, settings, forces=loading.forces)
    if settings.settle:
        settle(machine)
    return machine


def measure(made: BenchScene, steps: int | None = None, solver: str = "auto", tolerance: float = 1e-8, **settings: Any) -> Measured:
    """Step a scene and collect costs and errors; arguments as of :func:`stepper`."""
    steps = made.steps if steps is None else steps
    warm_up(solver, tolerance, settings)
    machine = stepper(made, steps, solver, tolerance, **settings)
    clock, counters, reports, counts = _clocked(machine), Counters.open(), [], []
    for _ in range(steps):
        before = _spent(counters)
        reports.append(machine.step())
        counts.append([end - begin for begin, end in zip(before, _spent(counters), strict=True)])
    return _summary(made, machine, reports, clock.seconds, np.array(counts, dtype=float))


def _spent(counters: Counters | None) -> tuple[float, float, float]:
    """Instructions, cycles and seconds of the processor so far; nan for what it does not count."""
    return *(counters.read() if counters else (nan, nan)), time.process_time()


def warm_up(solver: str, tolerance: float, settings: dict[str, Any]) -> None:
    """Have the kernels compiled, or loaded from their cache: of the solver, and of all that it may turn to on the way."""
    for name in [solver, *SOLVERS]:
        machine = stepper(tower(2), 3, name, tolerance, **settings)
        for _ in range(3):
            machine.step()


class _Clock:
    """Adds up the seconds spent in a function."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.seconds, self._function = 0.0, function

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        begin = time.perf_counter()
        out = self._function(*args, **kwargs)
        self.seconds += time.perf_counter() - begin
        return out


def _clocked(machine: Stepper) -> _Clock:
    """Put a clock around the detection of one stepper."""
    clock = _Clock(machine.detector.detect)
    machine.detector.detect = clock  # type: ignore[method-assign]
    return clock


def _summary(made: BenchScene, machine: Stepper, reports: list[StepReport], detection: float, counts: np.ndarray) -> Measured:
    seconds, errors = np.array([r.seconds for r in reports]), np.array([r.error for r in reports])
    reasons: dict[str, int] = {}
    for r in reports:
        word = r.reason.split(",")[0].split(" at an error")[0]
        reasons[word] = reasons.get(word, 0) + 1
    return Measured(
        scene=made.name,
        solver=machine.settings.solver,
        tolerance=machine.settings.tolerance,
        planar=machine.plane is not None,
        blocks=machine.assembly.count,
        contacts=float(np.mean([r.contacts for r in reports])),
        steps=len(reports),
        first_ms=1e3 * float(seconds[0]),
        first_iterations=reports[0].iterations,
        median_ms=1e3 * float(np.median(seconds)),
        mean_ms=1e3 * float((seconds[1:] if len(seconds) > 1 else seconds).mean()),
        processor_ms=1e3 * float(np.median(counts[:, 2])),
        instructions=1e-3 * float(counts[1:, 0].mean()) if len(counts) > 1 else nan,
        cycles=1e-3 * float(counts[1:, 1].mean()) if len(counts) > 1 else nan,
        iterations=float(np.mean([r.iterations for r in reports])),
        error_median=float(np.median(errors)),
        error_max=float(errors.max()),
        missed=int((errors > machine.settings.tolerance).sum()),
        detection_share=detection / float(seconds.sum()),
        penetration=max(r.penetration for r in reports),
        reasons=reasons,
    )


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Step a benchmark scene with masonry_cd.")
    parser.add_argument("scene", help="a name of benchmarks/scenes.py, or towerN, wallNxM, arcadeN, archN")
    parser.add_argument("--solver", default="auto")
    parser.add_argument("--tolerance", type=float, default=1e-8)
    parser.add_argument("--steps", type=int)
    parser.add_argument("--dt", type=float)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--max-iterations", type=int)
    parser.add_argument("--space", action="store_true", help="all three dimensions, also where a plane would do")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    try:
        made = scene(given.scene, given.dt)
        settings = {"threads": given.threads, "planar": not given.space, "max_iterations": given.max_iterations}
        out = measure(made, given.steps, given.solver, given.tolerance, **settings)
    except ValueError as wrong:
        parser.error(str(wrong))
    if given.json:
        print(json.dumps(asdict(out)))
        return
    for name, value in asdict(out).items():
        print(f"{name:16} {value:.4g}" if isinstance(value, float) else f"{name:16} {value}")


if __name__ == "__main__":
    main()
