# SPDX-License-Identifier: GPL-3.0-or-later
r"""Error against run time: of the friction solvers on one problem, and of whole runs over time step and tolerance.

**A problem.** Every solver is given every tolerance from a cold start. Its error is the natural map error
(:mod:`masonry_cd.mechanics.friction.problem`), scaled and unscaled, computed from the impulses outside the solver; its time the median of
repeats, kernels compiled before. A solver that misses a tolerance would go through the same iterations for a tighter one, so tighter ones
are left out.

**A scene.** Runs over all time steps and tolerances are compared with a reference of their own, at half the smallest step and the tightest
tolerance, at equal times t (the frames). With d_b the displacement of free block b relative to the base and w_j the opening of joint j,

    displacement error = max_t |d - d_ref|_2 / max_t |d_ref|_2,        |d|_2^2 = mean over b of |d_b|^2
    opening error      = max_t |w - w_ref|_2 / max_t |w_ref|_2,        |w|_2^2 = mean over j of w_j^2

and a denominator of less than STILL times the size of the structure is replaced by that: what did not move has no relative error. The
reference itself is about as wrong as the finest runs differ from it; closing lines say so.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from masonry_cd.analysis.deformed import base_shift, solids_of
from masonry_cd.app.commands.solve import load_kernels
from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.friction.problem import LocalProblem, Problem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options, pivoting

PROBLEM_TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
SCENE_TOLERANCES = (1e-2, 1e-4, 1e-6)
DT_FACTORS = (2.0, 1.0, 0.5)  # of the scene's time step
LONG = 5.0  # [s] a solve that takes longer is not repeated
STILL = 1e-6  # displacements of less than this share of the structure's size are none
NOTHING_DRAWN = ("report.crack_map=false", "report.damage=false", "report.html=false", "report.animation=false", "report.times=[]")

Say = Callable[[str], None]


@dataclass(frozen=True)
class SolverRow:
    """One solver at one tolerance."""

    solver: str
    tolerance: float
    error: float  # natural map error, scaled
    error_unscaled: float
    iterations: int
    seconds: float  # median
    repeats: int
    reached: bool


@dataclass(frozen=True)
class RunRow:
    """One run of a scene."""

    solver: str
    dt: float  # [s]
    tolerance: float
    displacement_error: float
    opening_error: float
    displacement_max: float  # [m]
    opening_max: float  # [m]
    sliding_max: float  # [m]
    joints_opened: int
    joints_slid: int
    joints_separated: int
    collapsed_blocks: int
    steps: int
    steps_missed: int
    error_max: float  # largest natural map error of a step
    stepping_seconds: float  # median
    wall_seconds: float  # median
    reached: bool  # the run came to its end and missed its tolerance in no step
    reference: bool = False


@dataclass(frozen=True, eq=False)
class Motion:
    """What of a run is compared, at F frames."""

    time: np.ndarray  # (F,) [s]
    displacement: np.ndarray  # (F, B, 3) of the free blocks relative to the base [m]
    opening: np.ndarray  # (F, J) [m]
    size: float  # of the structure [m]


def solver_rows(problem: Problem, solvers: Sequence[str], tolerances: Sequence[float], repeats: int, say: Say) -> list[SolverRow]:
    """Measure solvers on a problem, see the head of this file.

    Args:
        problem: over bodies or in the impulses.
        solvers: names in ``SOLVERS``.
        tolerances: from loose to tight.
        repeats: solves per row, but for those longer than LONG.
        say: called with a line before each solver.
    """
    rows: list[SolverRow] = []
    for name in solvers:
        say(f"{name}: {problem.contacts} contacts")
        load_kernels(name, problem)
        for tolerance in tolerances:
            rows.append(_solver_row(problem, name, tolerance, repeats))
            if not rows[-1].reached:
                break
    return rows


def _solver_row(problem: Problem, name: str, tolerance: float, repeats: int) -> SolverRow:
    """One solver at one tolerance."""
    seconds: list[float] = []
    while len(seconds) < repeats and sum(seconds) < LONG:
        begin = time.perf_counter()
        solution = SOLVERS[name](problem, Options(tolerance=tolerance), None)
        seconds.append(time.perf_counter() - begin)
    error = natural_map_error(problem, solution.impulse)
    unscaled = natural_map_error(problem, solution.impulse, scaled=False)
    median = statistics.median(seconds)
    return SolverRow(name, tolerance, error, unscaled, solution.iterations, median, len(seconds), bool(error <= tolerance))


def solvers_for(problem: Problem, asked: Sequence[str] | None) -> tuple[str, ...]:
    """The solvers to measure: those asked for, or all that solve such a problem themselves."""
    if asked is not None:
        return tuple(asked)
    solves = {"interior": not isinstance(problem, LocalProblem), "pivoting": pivoting.applies(problem)}
    return tuple(name for name in SOLVERS if solves.get(name, True))


def run_rows(
    path: Path, overrides: Sequence[str], solvers: Sequence[str], dts: Sequence[float], tolerances: Sequence[float], repeats: int, say: Say
) -> list[RunRow]:
    """Run a scene over time steps and tolerances; the first row is the reference.

    Args:
        path: scene file.
        overrides: changes to it, ``key=value``.
        solvers: to run it with; the first one makes the reference.
        dts: time steps [s], each a whole fraction of the largest.
        tolerances: of the steps.
        repeats: of each run, for its time.
        say: called with a line before each run.

    Raises:
        InputError: a scene that is wrong; time steps without common times.
    """
    largest, smallest = max(dts), min(dts)
    for dt in dts:
        if abs(round(largest / dt) * dt - largest) > 1e-9 * largest:
            raise InputError("--dts", f"{dt:g} s is no whole fraction of {largest:g} s; runs are compared at equal times")
    scene = read_scene(path, [*overrides, f"run.dt={largest!r}"])
    frame = largest * min(scene.run.frame_every, scene.run.steps or scene.run.frame_every)
    common = [*overrides, *NOTHING_DRAWN, f"run.frames_per_second={1.0 / frame!r}"]
    asked = [(solvers[0], smallest / 2.0, min(tolerances), True)]
    asked += [(solver, dt, tolerance, False) for solver in solvers for tolerance in tolerances for dt in dts]
    rows, reference = [], None
    for k, (solver, dt, tolerance, is_reference) in enumerate(asked):
        say(f"run {k + 1} of {len(asked)}: {solver}, dt {dt:g} s, tolerance {tolerance:g}{', the reference' if is_reference else ''}")
        changes = [*common, f'run.solver="{solver}"', f"run.dt={dt!r}", f"run.tolerance={tolerance!r}"]
        summary, motion = run_once(read_scene(path, changes), 1 if is_reference else repeats)
        reference = reference or motion
        rows.append(_run_row(summary, motion, reference, is_reference))
    return rows


def run_once(scene: Scene, repeats: int = 1) -> tuple[dict[str, Any], Motion]:
    """Run a scene in a folder that is thrown away; its summary, with median times, and its motion."""
    from masonry_cd.app.case import prepare
    from masonry_cd.app.run_case import run_case

    summaries = []
    for _ in range(repeats):
        with TemporaryDirectory() as folder:
            summaries.append(run_case(prepare(scene), Path(folder)))
            with Results.open(Path(folder) / "result.h5") as results:
                motion = motion_of(results)
    for key in ("stepping_seconds", "wall_seconds"):
        summaries[0][key] = statistics.median(summary[key] for summary in summaries)
    return summaries[0], motion


def motion_of(results: Results) -> Motion:
    """The motion of a run."""
    solids = solids_of(results.blocks)
    position = np.asarray(results.position[: results.frames], dtype=float)
    moved = position - solids.centre - base_shift(results, solids, position)[:, None]
    size = float(np.linalg.norm(np.ptp(solids.vertices[~solids.fixed[solids.vertex_block]], axis=0)))
    return Motion(results.time, moved[:, ~solids.fixed], results.joint_history("opening"), size)


def motion_errors(motion: Motion, reference: Motion) -> tuple[float, float]:
    """Displacement error and opening error, see the head of this file; of a run that ended early, up to its end."""
    frames = min(len(motion.time), len(reference.time))
    while frames and abs(motion.time[frames - 1] - reference.time[frames - 1]) > 1e-9 * max(1.0, reference.time[frames - 1]):
        frames -= 1  # a last frame beyond the common times
    pairs = ((motion.displacement, reference.displacement), (motion.opening[..., None], reference.opening[..., None]))
    first, second = (_relative(got[:frames], best[:frames], STILL * reference.size) for got, best in pairs)
    return first, second


def _relative(got: np.ndarray, best: np.ndarray, least: float) -> float:
    """max_t |got - best|_2 / max_t |best|_2 of histories (F, n, d)."""
    if got.size == 0:
        return 0.0

    def largest(history: np.ndarray) -> float:
        return float(np.sqrt((history**2).sum(axis=2).mean(axis=1)).max())

    return largest(got - best) / max(largest(best), least)


def _run_row(summary: dict[str, Any], motion: Motion, reference: Motion, is_reference: bool) -> RunRow:
    """The row of a run."""
    solver = summary["solver"]
    own = ("displacement_max", "opening_max", "sliding_max", "joints_opened", "joints_slid", "joints_separated", "collapsed_blocks")
    displacement, opening = motion_errors(motion, reference)
    return RunRow(
        solver=solver["name"],
        tolerance=solver["tolerance"],
        displacement_error=displacement,
        opening_error=opening,
        steps_missed=solver["steps_missed"],
        error_max=solver["error_max"],
        reached=not summary["stopped"] and not solver["steps_missed"],
        reference=is_reference,
        **{key: summary[key] for key in ("dt", "steps", "stepping_seconds", "wall_seconds", *own)},
    )
