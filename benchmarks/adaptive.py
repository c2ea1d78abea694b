# SPDX-License-Identifier: GPL-3.0-or-later
r"""Time steps that adapt against fixed ones: error against cost, on whole records.

    python -m benchmarks.adaptive [rocking] [arch] [column] [wall] [--members 8] [--record FILE] [--out TABLE.md]

**rocking**: a single block after a sine pulse against Housner's solution (``benchmarks/rocking.py``): errors of impact times and peaks.

**arch, column, wall**: a whole record, along the arch and across the wall. Under strong shaking the largest motion of a structure is
sensitive to the last digit, so each row is an ensemble: the amplitude is changed by 1e-6 from member to member, and medians are compared,
with the quartiles next to them. The error of a row is how far its medians of the largest displacement and of the largest opening are from
those of the reference, the finest fixed step. The record is L'Aquila 2009, AQV NS where the folder ../shared/records is there, else an
artificial motion of the same kind.

Cost is steps, solver iterations and seconds of the processor (not of the clock: others may use the machine), reading and writing included.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from benchmarks import rocking
from benchmarks.ours import stepper
from benchmarks.sitting import HERE, head, sitting
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.dynamics.adaptive import AdaptiveSteps

RECORD = HERE.parents[1] / "shared/records/laquila_2009_AQV_NS.asc"
PERTURBED = 1e-6  # of the amplitude, from member to member
FIXED, FINEST = (1e-2, 5e-3, 2.5e-3, 1.25e-3), 6.25e-4  # time steps [s]
TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6)  # local errors [m]
RECORDED = 'kind = "record"\npath = "{path}"\ndirection = "{direction}"\nscale = {scale!r}'
ARTIFICIAL = (
    'kind = "artificial"\ndirection = "{direction}"\nspectrum = "EC8"\nag = 3.5\nground = "B"\nrise = 2.0\nlevel = 6.0\n'
    "duration = 30.0\nseed = 7\nscale = {scale!r}"
)
SCENES = {  # structure, friction, tolerance of the solver
    "arch": ('kind = "arch"\nspan = 5.0\nrise = 2.5\nthickness = 0.6\nwidth = 1.0\nvoussoirs = 15', 0.6, 1e-6),
    "column": ('kind = "column"\nheight = 4.0\ndiameter = 0.6\ndrums = 4\nsides = 8', 0.6, 1e-6),
    "wall": ('kind = "wall"\nlength = 4.0\nheight = 2.4\nthickness = 0.4\ncourse_height = 0.4', 0.5, 1e-5),
}


class Row(NamedTuple):
    """An ensemble of runs with one choice of the time step: medians, and quartiles next to them."""

    name: str
    displacement: np.ndarray  # (3,) quartiles of the largest one [m]
    opening: np.ndarray  # (3,) [m]
    steps: float
    iterations: float
    seconds: float  # of the processor
    missed: float


def scene_text(name: str, record: Path | None, scale: float, step: str, seconds: float | None) -> str:
    """The scene file of one run; ``step`` holds the keys of the time step."""
    structure, friction, tolerance = SCENES[name]
    load = ARTIFICIAL if record is None else RECORDED
    load = load.format(scale=scale, direction="y" if name == "wall" else "x", path=record and record.resolve())
    duration = seconds or (30.0 if record is None else 45.0)
    return (
        f"[structure]\n{structure}\n[material]\ndensity = 2000.0\nfriction = {friction}\n[[loads]]\n{load}\n"
        f"[run]\nduration = {duration}\ntolerance = {tolerance}\n{step}\n"
    )


def run_once(text: str) -> tuple[Summary, float]:
    """Run a scene by the text of its file; its summary, and the seconds of the processor."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "scene.toml"
        file.write_text(text)
        case, begin = prepare(read_scene(file)), time.process_time()
        summary = run_case(case, Path(folder) / "out")
        return summary, time.process_time() - begin


def ensemble(scene: str, record: Path | None, members: int, name: str, step: str, seconds: float | None) -> Row:
    """Run all members with one choice of the time step."""
    runs = [run_once(scene_text(scene, record, 1.0 + PERTURBED * m, step, seconds)) for m in range(members)]

    def quartiles(key: str) -> np.ndarray:
        return np.percentile([getattr(run, key) for run, _ in runs], [25.0, 50.0, 75.0])

    iterations = [run.steps * run.solver.iterations_mean for run, _ in runs]
    return Row(
        name,
        quartiles("displacement_max"),
        quartiles("opening_max"),
        float(np.median([run.steps for run, _ in runs])),
        float(np.median(iterations)),
        float(np.median([seconds for _, seconds in runs])),
        float(np.median([run.solver.steps_missed for run, _ in runs])),
    )


def study(scene: str, record: Path | None, members: int, seconds: float | None) -> list[str]:
    """The table of a scene, its reference first, lines as they come."""
    asked = [(f"fixed {1e3 * dt:g} ms", f"dt = {dt!r}") for dt in (FINEST, *reversed(FIXED))]
    asked += [(f"auto, {1e6 * tolerance:g} um", f'dt = "auto"\ndt_tolerance = {tolerance!r}') for tolerance in TOLERANCES]
    lines = [head("time step", "displacement [mm]", "opening [mm]", "off by [%]", "steps", "iterations", "processor [s]", "missed")]
    reference = None
    for name, step in asked:
        row = ensemble(scene, record, members, name, step, seconds)
        reference = reference or row
        lines.append(table_row(row, reference))
        print("\n".join(lines[-1:] if len(lines) > 2 else lines), flush=True)
    return lines


def table_row(row: Row, reference: Row) -> str:
    """One line of the table."""
    off = [100.0 * (got[1] / best[1] - 1.0) for got, best in ((row.displacement, reference.displacement), (row.opening, reference.opening))]
    spread = [f"{1e3 * q[1]:.2f} ({1e3 * q[0]:.2f} to {1e3 * q[2]:.2f})" for q in (row.displacement, row.opening)]
    return (
        f"| {row.name} | {spread[0]} | {spread[1]} | {off[0]:+.1f}, {off[1]:+.1f} | {row.steps:.0f} | {row.iterations:.0f} | "
        f"{row.seconds:.2f} | {row.missed:.0f} |"
    )


# --- a single block against Housner --------------------------------------------------------------------------------------------------


def adaptive_angle(tolerance: float, end: float) -> tuple[np.ndarray, int, int, float]:
    """The angle of the rocking block at equal times [rad], steps, iterations, and seconds of the processor."""
    tick = 1e-2 / 32
    ticks, time_, angle, iterations = round(end / tick), [0.0], [0.0], 0
    machine = stepper(rocking.block_on_base(tick), ticks, "auto", 1e-10, dt="auto", dt_tolerance=tolerance)
    pace, begin = AdaptiveSteps(machine), time.process_time()
    while machine.load_step < ticks:
        iterations += pace.step(ticks - machine.load_step).report.iterations
        time_.append(machine.state.time)
        angle.append(2.0 * np.arctan2(machine.state.orientation[1, 2], machine.state.orientation[1, 0]))
    return np.interp(tick * np.arange(ticks + 1), time_, angle), machine.steps, iterations, time.process_time() - begin


def rocking_table() -> list[str]:
    """Errors of fixed and of adapting steps."""
    end = float(rocking.housner(np.zeros(1))[0].impacts[-1]) + 0.1
    lines = [head("time step", "impact times [ms]", "peaks [%]", "steps", "processor [s]")]
    for dt in (*FIXED[1:], FINEST, 3.125e-4):
        begin, steps = time.process_time(), round(end / dt)
        late, low, _ = rocking.errors(rocking.ours_angle(dt, steps, "auto"), dt)
        lines.append(f"| fixed {1e3 * dt:g} ms | {1e3 * late:.3f} | {100 * low:.3f} | {steps} | {time.process_time() - begin:.2f} |")
    for tolerance in TOLERANCES:
        angle, steps, _, seconds = adaptive_angle(tolerance, end)
        late, low, _ = rocking.errors(angle, 1e-2 / 32)
        lines.append(f"| auto, {1e6 * tolerance:g} um | {1e3 * late:.3f} | {100 * low:.3f} | {steps} | {seconds:.2f} |")
    print("\n".join(lines), flush=True)
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Time steps that adapt against fixed ones.")
    parser.add_argument("scenes", nargs="*", default=[], metavar="SCENE", help=f"rocking, {', '.join(SCENES)}; all when left out")
    parser.add_argument("--members", type=int, default=8, help="of an ensemble")
    parser.add_argument("--record", type=Path, help="a record, instead of L'Aquila 2009, AQV NS")
    parser.add_argument("--seconds", type=float, help="of the record, from its beginning; all of it when left out")
    parser.add_argument("--out", type=Path, help="where the tables are written, too")
    given = parser.parse_args(arguments)
    for name in given.scenes:
        if name not in ("rocking", *SCENES):
            parser.error(f'no scene "{name}"; there are rocking, {", ".join(SCENES)}')
    record = given.record or (RECORD if RECORD.exists() else None)
    lines = [sitting(), "", f"record: {record.name if record else f'artificial, since {RECORD.name} is not there'}"]
    print("\n".join(lines))
    for name in given.scenes or ("rocking", *SCENES):
        print(f"\n{name}", flush=True)
        lines += ["", name, *(rocking_table() if name == "rocking" else study(name, record, given.members, given.seconds))]
        if given.out:
            given.out.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
