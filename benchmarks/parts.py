# SPDX-License-Identifier: GPL-3.0-or-later
r"""Cost of each part of a step: a whole run, its results written, with a clock around every part.

    python -m benchmarks.parts wall71x36 --steps 20
    python -m benchmarks.parts church600 --steps 20 --json

``benchmarks.scaling --parts`` puts the sizes of a family side by side. A part's seconds are its own: those of the parts that it calls are
taken off, so that the parts add up to the run. They are seconds of the processor, which other programs disturb least, on all threads.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.ours import stepper, warm_up
from benchmarks.scenes import BenchScene, scene
from benchmarks.sitting import head, numbers_of
from masonry_cd.analysis.damage.step_peaks import StepPeaks
from masonry_cd.app import measured_joints, recorder, run_loop
from masonry_cd.io import checkpoint
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.mechanics.contact import detector
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics import impacts, islands, moreau_jean, solving
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.friction import problem
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.model.joints import JointPeaks
from masonry_cd.mechanics.solvers import admm, interior, newton, nlgs

PARTS: dict[str, tuple[tuple[Any, str], ...]] = {  # where each part begins: owner and attribute
    "broad phase": ((detector.Detector, "_rebuild"),),
    "narrow phase": ((detector, "update_pairs"), (detector, "write_contacts")),
    "motion": ((moreau_jean, "predict"), (moreau_jean, "update")),
    "contact rows": ((moreau_jean, "assemble"),),
    "impacts found": ((impacts, "find_impacts"), (impacts, "carried_impulse")),
    "analysis": ((Pattern, "of"), (Pattern, "locate")),
    "iterations": (
        (nlgs, "run_by_team"), (admm, "admm_bodies"), (newton, "over_bodies"),
        (interior, "over_bodies"),
    ),
    "error measure": ((problem, "error_norms"),),
    "islands": ((islands.Islands, "link"), (islands.Islands, "solve")),
    "energy": ((moreau_jean, "account"),),
    "joints": ((measured_joints, "measure_joints"), (JointPeaks, "update"), (StepPeaks, "update")),
    "output": ((recorder.Recorder, "step"), (recorder.Recorder, "write_frame"), (recorder.Recorder, "close")),
    "step, rest": ((Stepper, "step"),),
}  # fmt: skip
IMPACTS = " of impacts"  # added to the parts of the second solve of a step with impacts
SOLVE = ("analysis", "iterations", "error measure", "solver, rest")  # the parts that belong to a solver


@dataclass
class Clocks:
    """Seconds and calls of each part; a stack of running clocks takes what is inside off what is outside."""

    seconds: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)
    suffix: str = ""  # of the parts of a solver, see IMPACTS
    _inside: list[float] = field(default_factory=list)  # seconds of the parts inside each running one

    def timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function with the clock of a part around it."""

        def call(*args: Any, **kwargs: Any) -> Any:
            self._inside.append(0.0)
            begin = time.process_time()
            try:
                return function(*args, **kwargs)
            finally:
                spent = time.process_time() - begin
                name = part + self.suffix if part in SOLVE else part
                self.seconds[name] = self.seconds.get(name, 0.0) + spent - self._inside.pop()
                self.calls[name] = self.calls.get(name, 0) + 1
                if self._inside:
                    self._inside[-1] += spent

        return call

    def told_apart(self, solve_apart: Callable[..., Any]) -> Callable[..., Any]:
        """``impacts.solve_apart`` whose second solve books under names of its own."""

        def call(*args: Any) -> Any:
            *rest, solve = args

            def named(problem: Any, start: Any, kind: str) -> Any:
                self.suffix = IMPACTS if kind == islands.IMPACTS else ""
                return solve(problem, start, kind)

            try:
                return solve_apart(*rest, named)
            finally:
                self.suffix = ""

        return call


@contextmanager
def clocked(machine: Stepper) -> Iterator[Clocks]:
    """Put clocks around all parts, and take them off again."""
    clocks, kept = Clocks(), [(solving, "solve_apart", solving.solve_apart), (machine.islands, "solver", machine.islands.solver)]
    for part, places in PARTS.items():
        for owner, name in places:
            own = vars(owner)[name]
            kept.append((owner, name, own))
            if isinstance(own, classmethod):
                setattr(owner, name, staticmethod(clocks.timed(part, getattr(owner, name))))
            else:
                setattr(owner, name, clocks.timed(part, own))
    machine.islands.solver = clocks.timed("solver, rest", machine.islands.solver)
    solving.solve_apart = clocks.told_apart(solving.solve_apart)
    try:
        yield clocks
    finally:
        for owner, name, own in kept:
            setattr(owner, name, own)


@dataclass(frozen=True)
class Costs:
    """Costs of the parts of a run."""

    scene: str
    blocks: int  # supports included
    contacts: float  # of the friction problem, mean over the steps
    joints: int
    steps: int  # after the first, which is left out
    build_seconds: float  # assembly, joints and stepper from the blocks
    first_seconds: float  # the first step
    frame_every: int
    seconds: dict[str, float]  # of each part
    calls: dict[str, int]
    checkpoint_seconds: float  # of one, at the end
    peak_mb: float  # resident memory of the process


def measure(made: BenchScene, steps: int, frame_every: int = 20, **settings: Any) -> Costs:
    """Run a scene with its results written into a temporary folder.

    Args:
        made: the scene.
        steps: to be taken after the first.
        frame_every: steps between two frames.
        **settings: keys of the table [run].
    """
    warm_up("auto", 1e-8, settings)
    begin = time.process_time()
    machine = stepper(made, steps + 1, **settings)
    found = find_joints(machine.assembly)
    built = time.process_time() - begin
    first: dict[str, float] = {}

    def progress(step: int) -> None:
        if step == 1:  # it starts cold
            first.update(seconds=time.process_time() - begin)
            clocks.seconds.clear()
            clocks.calls.clear()

    with tempfile.TemporaryDirectory() as folder, ResultWriter(Path(folder) / "result.h5", machine.assembly, found) as writer:
        with clocked(machine) as clocks:
            begin = time.process_time()
            report = run_loop.run(machine, found, writer, run_loop.RunPlan(steps + 1, frame_every), progress)
        begin = time.process_time()
        checkpoint.save(Path(folder) / checkpoint.NAME, machine.snapshot(), {})
        saved = time.process_time() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return Costs(
        made.name, machine.assembly.count, report.contacts_mean, found.count, steps, built, first["seconds"], frame_every, clocks.seconds,
        clocks.calls, saved, peak,
    )  # fmt: skip


def run_parts(name: str, steps: int, extra: Sequence[str] = ()) -> Costs:
    """:func:`measure` a scene in a process of its own."""
    return Costs(**numbers_of("benchmarks.parts", [name, "--steps", str(steps), *extra]))


def names_of(costs: list[Costs]) -> list[str]:
    """The parts that any of them has, in the order of a step, those of the impacts behind."""
    known = [*PARTS, "solver, rest", *(name + IMPACTS for name in SOLVE)]
    return [name for name in known if any(name in each.seconds for each in costs)]


def table(costs: list[Costs]) -> list[str]:
    """Microseconds per block and step of each part, size by size, and how much each grew from the first to the last."""
    per_block = [{name: 1e6 * x / each.steps / each.blocks for name, x in each.seconds.items()} for each in costs]
    lines = [head("us/step/block", *(f"{each.scene}: {each.blocks}" for each in costs), "growth")]
    for name in names_of(costs):
        cells = [row.get(name, 0.0) for row in per_block]
        lines.append(_line(name, cells))
    detection = [row.get("broad phase", 0.0) + row.get("narrow phase", 0.0) for row in per_block]
    totals = [sum(row.values()) for row in per_block]
    solves = [sum(x for name, x in row.items() if name.startswith(SOLVE)) for row in per_block]
    lines += [_line("all but the solver", [t - s for t, s in zip(totals, solves, strict=True)]), _line("all", totals)]
    shares = [f"{100 * d / t:.0f} %" for d, t in zip(detection, totals, strict=True)]
    lines.append(f"| detection, share | {' | '.join(shares)} | |")
    once = [("to build", [each.build_seconds for each in costs]), ("first step", [each.first_seconds for each in costs])]
    once.append(("a checkpoint", [each.checkpoint_seconds for each in costs]))
    for name, seconds in once:
        lines.append(_line(f"{name}, us/block", [1e6 * x / each.blocks for x, each in zip(seconds, costs, strict=True)]))
    lines.append(f"| peak memory [MB] | {' | '.join(f'{each.peak_mb:.0f}' for each in costs)} | |")
    return lines


def _line(name: str, cells: list[float]) -> str:
    growth = f"x {cells[-1] / cells[0]:.2f}" if cells[0] > 0.0 else ""
    return f"| {name} | {' | '.join(f'{x:.3g}' for x in cells)} | {growth} |"


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="What each part of a step costs.")
    parser.add_argument("scene", help="a name of benchmarks/scenes.py, or towerN, wallNxM, arcadeN, archN, churchN (N: block length in mm)")
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--frame-every", type=int, default=20)
    parser.add_argument("--space", action="store_true", help="all three dimensions, also where a plane would do")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--max-iterations", type=int, help="of each solve: the other parts cost the same without a good solution")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    try:
        settings = {"planar": not given.space, "threads": given.threads, "max_iterations": given.max_iterations}
        costs = measure(scene(given.scene), given.steps, given.frame_every, **settings)
    except ValueError as wrong:
        parser.error(str(wrong))
    print(json.dumps(asdict(costs)) if given.json else "\n".join(table([costs])))


if __name__ == "__main__":
    main()
