# SPDX-License-Identifier: GPL-3.0-or-later
r"""Error against run time of single runs of a scene.

Runs over all time steps and tolerances are compared with a reference of their own, at half the smallest step and the tightest
tolerance, at equal times t (the frames). With d_b the displacement of free block b relative to the base and w_j the opening of joint j,

    displacement error = max_t |d - d_ref|_2 / max_t |d_ref|_2,        |d|_2^2 = mean over b of |d_b|^2
    opening error      = max_t |w - w_ref|_2 / max_t |w_ref|_2,        |w|_2^2 = mean over j of w_j^2

and a denominator of less than STILL times the size of the structure is replaced by that: what did not move has no relative error. The
reference itself is about as wrong as the finest runs differ from it; closing lines say so.
"""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from masonry_cd.analysis.deformed import base_at, solids_of
from masonry_cd.app.progress import Interrupted
from masonry_cd.app.result import Say
from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import in_words
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.studies.accuracy.picture import Measurement, PanelSheet, Point, TimePanel, exponent

TOLERANCES = (1e-2, 1e-4, 1e-6)
DT_FACTORS = (2.0, 1.0, 0.5)  # of the scene's time step
STILL = 1e-6  # displacements of less than this share of the structure's size are none
FALLS = 0.2  # order in the time step below which an error does not fall with it
NOTHING_DRAWN = ("report.crack_map=false", "report.damage=false", "report.html=false", "report.animation=false", "report.times=[]")


@dataclass(frozen=True)
class SceneRow:
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
class ComparedMotion:
    """Motion of a run that is compared, at F frames."""

    time: np.ndarray  # (F,) [s]
    displacement: np.ndarray  # (F, B, 3) of the free blocks relative to the base [m]
    opening: np.ndarray  # (F, J) [m]
    size: float  # of the structure [m]


def measured(title: str, rows: Sequence[SceneRow]) -> Measurement:
    """Return the measurement of the runs of a scene, the reference first."""
    heading, cells, runs = f"Error against run time: {title}", [vars(row) for row in rows], rows[1:]
    reference, several = rows[0], len({row.solver for row in runs}) > 1
    facts = f"each point a time step; reference: dt {1e3 * reference.dt:g} ms, tolerance {exponent(reference.tolerance)}"
    keys = dict.fromkeys((row.solver, row.tolerance) for row in runs)
    groups = {
        f"{solver} {exponent(tolerance)}" if several else f"tolerance {exponent(tolerance)}": sorted(
            (row for row in runs if (row.solver, row.tolerance) == (solver, tolerance)), key=lambda row: -row.dt
        )
        for solver, tolerance in keys
    }
    panels = [_panel(words, groups, key) for key, words in (("displacement_error", "displacement"), ("opening_error", "joint opening"))]
    diagram = PanelSheet(heading, f"{facts}; hollow: tolerance missed", "stepping time of the run [s]", panels)
    return Measurement(heading, cells, cells, _lines(title, rows), _warnings(rows), diagram)


def _panel(words: str, groups: Mapping[str, Sequence[SceneRow]], key: str) -> TimePanel:
    """An error over the stepping time, a line per tolerance; points of the last one say their time steps."""
    last = list(groups)[-1]
    lines = []
    for name, own in groups.items():
        labels = [f"dt {1e3 * row.dt:g} ms" if name == last else "" for row in own]
        points = [Point(row.stepping_seconds, 100.0 * getattr(row, key), not row.reached, at) for row, at in zip(own, labels, strict=True)]
        lines.append((name, points))
    return TimePanel(f"{words} error, relative [%]", lines)


def run_rows(
    path: Path, overrides: Sequence[str], solvers: Sequence[str], dts: Sequence[float], tolerances: Sequence[float], repeats: int, say: Say
) -> list[SceneRow]:
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
            raise InputError("--dts", f"{dt:g} s is not a whole fraction of {largest:g} s; runs are compared at equal times")
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


def run_once(scene: Scene, repeats: int = 1) -> tuple[Summary, ComparedMotion]:
    """Run a scene in a folder that is thrown away; its summary, with median times, and its motion.

    Raises:
        Interrupted: by a signal; half a run is none to compare.
    """
    from masonry_cd.app.case import prepare
    from masonry_cd.app.run_case import run_case

    summaries = []
    for _ in range(repeats):
        with TemporaryDirectory() as folder:
            summaries.append(run_case(prepare(scene), Path(folder)))
            if summaries[-1].signal:
                raise Interrupted(summaries[-1].signal)
            with Results.open(Path(folder) / "result.h5") as results:
                motion = motion_of(results)
    seconds = {key: statistics.median(getattr(found, key) for found in summaries) for key in ("stepping_seconds", "wall_seconds")}
    return summaries[0] | Summary(**seconds), motion


def motion_of(results: Results) -> ComparedMotion:
    """The motion of a run."""
    solids = solids_of(results.blocks)
    position = np.asarray(results.position[: results.frames], dtype=float)
    moved = base_at(results, solids, slice(0, results.frames)).seen(position) - solids.centre
    size = float(np.linalg.norm(np.ptp(solids.vertices[~solids.fixed[solids.vertex_block]], axis=0)))
    return ComparedMotion(results.time, moved[:, ~solids.fixed], results.joint_history("opening"), size)


def motion_errors(motion: ComparedMotion, reference: ComparedMotion) -> tuple[float, float]:
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


def _run_row(summary: Summary, motion: ComparedMotion, reference: ComparedMotion, is_reference: bool) -> SceneRow:
    """The row of a run."""
    solver = summary.solver
    own = ("displacement_max", "opening_max", "sliding_max", "joints_opened", "joints_slid", "joints_separated", "collapsed_blocks")
    displacement, opening = motion_errors(motion, reference)
    return SceneRow(
        solver=solver.name,
        tolerance=solver.tolerance,
        displacement_error=displacement,
        opening_error=opening,
        steps_missed=solver.steps_missed,
        error_max=solver.error_max,
        reached=not summary.stopped and not solver.steps_missed,
        reference=is_reference,
        **{key: getattr(summary, key) for key in ("dt", "steps", "stepping_seconds", "wall_seconds", *own)},
    )


def _lines(title: str, rows: Sequence[SceneRow]) -> list[str]:
    """The runs as text: the finest, the fastest, and how the error falls with the time step."""
    reference, runs = rows[0], rows[1:]
    finest = min(runs, key=lambda row: (row.tolerance, row.dt))
    fastest = min(runs, key=lambda row: row.stepping_seconds)
    lines = [f"{title}: {len(runs)} runs against dt {reference.dt:g} s, tolerance {reference.tolerance:g} ({reference.solver})"]
    for name, row in (("finest", finest), ("fastest", fastest)):
        lines.append(
            f"{name}, dt {row.dt:g} s, tolerance {row.tolerance:g}: displacements within {100 * row.displacement_error:.2g} %, openings "
            f"within {100 * row.opening_error:.2g} %, stepping {in_words(row.stepping_seconds)}"
        )
    lines.append("the reference itself may be as far off as the finest run")
    order = _order([row for row in runs if row.tolerance == finest.tolerance and row.solver == reference.solver])
    if order is not None:
        falls = f"falls as dt to the {order:.2g}" if order > FALLS else "does not fall with dt over this range"
        lines.append(f"at tolerance {finest.tolerance:g} the displacement error {falls}")
    return lines


def _order(rows: Sequence[SceneRow]) -> float | None:
    """Slope of log error over log dt, by least squares; None with fewer than three runs or an error of nothing."""
    if len(rows) < 3 or min(row.displacement_error for row in rows) <= 0.0:
        return None
    steps, errors = (np.log([getattr(row, key) for row in rows]) for key in ("dt", "displacement_error"))
    return float(np.polyfit(steps, errors, 1)[0])


def _warnings(rows: Sequence[SceneRow]) -> list[str]:
    """Runs that missed their tolerance or broke off."""
    broken = [row for row in rows if not row.reached]
    out = []
    for row in broken:
        what = f"{row.steps_missed} of {row.steps} steps missed it" if row.steps_missed else f"the run broke off after {row.steps} steps"
        name = "the reference" if row.reference else f"{row.solver}, dt {row.dt:g} s"
        out.append(f"{name}, tolerance {row.tolerance:g}: {what}, the largest error is {row.error_max:.1e}")
    return out
