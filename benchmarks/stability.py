# SPDX-License-Identifier: GPL-3.0-or-later
r"""Stiff and extreme cases: does anything drift, sink in, gain energy or break down?

    python -m benchmarks.stability [-o docs/stability.md] [--picture docs/stability.png] [--only dt]

Time steps from 1e-4 to 5e-2 s, mass ratios, light blocks under large forces, friction from none to 10, blocks from millimetres to hundreds
of metres, shaking to 5 g and to 50 Hz, joints from 1e8 to 1e13 N/m3, joints built with gaps of micrometres; and buildings in space, shaken
hard, to a tolerance of 1e-3. A case passes if, in every one of its steps,

    finite        all positions, velocities and impulses are numbers, and the run comes to its end
    drift         a structure at rest moves by less than DRIFT times the width of its smallest block, once its joints carry the weight
    penetration   no block sinks into another by more than REST_OVERLAP (at rest) or OVERLAP (shaken) times that width, beyond what
                  elastic joints are shortened and what joints were built with
    balance       the energy balance closes to BALANCE times the largest work done (or weight over a width)
    dissipation   friction and impacts together give back no energy beyond GAINED times the same

Missed steps are counted, with their largest error. They fail no case by themselves, nor does a step that costs many times the median (in
iterations counted by their weights, the first step left out).
"""

from __future__ import annotations

import argparse
import platform
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.counted_cost import counted
from benchmarks.ours import stepper
from benchmarks.scenes import GRAVITY, BenchScene, arcade, arch, tower, wall
from benchmarks.stability_outcome import BALANCE, DRIFT, GAINED, OVERLAP, REST_OVERLAP, Outcome
from benchmarks.stability_picture import draw
from benchmarks.strong_shaking import rest_cases, strong_cases
from masonry_cd.mechanics.contact.find_joints import built_gap
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped

TOLERANCE = 1e-8
PUSHED_ASIDE = 0.1  # share of a force that friction has to hold, and that does not overturn a tower of three
HARD = 1e-3  # tolerance of what is shaken hard in space


@dataclass(frozen=True, eq=False)
class StabilityCase:
    """A scene, what is extreme about it, and how long it lasts."""

    group: str
    name: str
    scene: BenchScene
    steps: int
    tolerance: float = TOLERANCE

    @property
    def at_rest(self) -> bool:
        """Return True if it has to stand still."""
        return self.scene.amplitude == 0.0


def cases() -> Iterator[StabilityCase]:
    """All cases, in the order of the table."""
    for dt, steps in ((1e-4, 1000), (1e-3, 1000), (1e-2, 500), (5e-2, 200)):
        yield StabilityCase("time step, at rest", f"tower of 10, dt {dt:g} s", replace(tower(10, amplitude=0.0), dt=dt), steps)
        yield StabilityCase("time step, at rest", f"arch of 27, dt {dt:g} s", replace(arch(27, amplitude=0.0), dt=dt), steps)
    for dt, steps in ((1e-4, 2000), (1e-3, 1000), (1e-2, 200), (5e-2, 60)):
        shaken = replace(_shaken(arcade(3), 0.5 * GRAVITY, 1.0), dt=dt)
        yield StabilityCase("time step, shaken", f"arcade of 3, 0.5 g at 1 Hz, dt {dt:g} s", shaken, steps)
    for ratio in (1e2, 1e4, 1e6):
        yield StabilityCase("mass ratio", f"tower of 10, top {ratio:.0e} times heavier", _denser(tower(10, amplitude=0.0), -1, ratio), 400)
    yield StabilityCase("mass ratio", "tower of 10, foot 1e+06 times heavier", _denser(tower(10, amplitude=0.0), 1, 1e6), 400)
    for ratio in (1e2, 1e3, 1e4, 1e5, 1e6):
        yield StabilityCase("light block", f"top of 3 pushed, {ratio:.0e} times its weight", _pushed(3, ratio), 400)
    for mu in (0.0, 0.05, 2.0, 10.0):
        yield StabilityCase("friction", f"tower of 10 at rest, mu {mu:g}", replace(tower(10, amplitude=0.0), friction=mu), 400)
        shaken = replace(_shaken(wall(6, 6), GRAVITY, 2.0), friction=mu)
        yield StabilityCase("friction", f"wall 6 x 6, 1 g at 2 Hz, mu {mu:g}", shaken, 500)
    for length in (4e-3, 0.4, 4.0, 400.0):
        still = _scaled(wall(6, 6, amplitude=0.0), length / 0.4)
        yield StabilityCase("size", f"wall at rest, blocks of {length:g} m", still, 400)
        shaken = _shaken(_scaled(wall(6, 6), length / 0.4), GRAVITY, 2.0)
        yield StabilityCase("size", f"wall, 1 g at 2 Hz, blocks of {length:g} m", shaken, 500)
    for share in (1.0, 2.0, 5.0):
        shaken = _shaken(wall(6, 6), share * GRAVITY, 2.0)
        yield StabilityCase("amplitude", f"wall 6 x 6, {share:g} g at 2 Hz", shaken, 1000)
    for frequency in (5.0, 20.0, 50.0):
        shaken = _shaken(wall(6, 6), GRAVITY, frequency)
        yield StabilityCase("frequency", f"wall 6 x 6, 1 g at {frequency:g} Hz", shaken, 1000)
    for stiffness in (1e8, 1e9, 1e11, 1e13):
        for dt, steps in ((1e-3, 400), (1e-2, 200)):
            still = replace(tower(10, amplitude=0.0), stiffness=stiffness, dt=dt)
            yield StabilityCase("joint stiffness", f"tower of 10 at rest, {stiffness:.0e} N/m3, dt {dt:g} s", still, steps)
        shaken = replace(_shaken(wall(6, 6), GRAVITY, 2.0), stiffness=stiffness)
        yield StabilityCase("joint stiffness", f"wall 6 x 6, 1 g at 2 Hz, {stiffness:.0e} N/m3", shaken, 500)
    for name, made, steps in rest_cases():
        yield StabilityCase("gaps of 1e-6 m as built, at rest", name, made, steps)
    for name, made, steps in strong_cases():
        yield StabilityCase("strong shaking in space", name, made, steps, HARD)


def _shaken(made: BenchScene, acceleration: float, frequency: float) -> BenchScene:
    """The scene on a base that shakes at some peak acceleration [m/s2] and frequency [Hz]."""
    return replace(made, amplitude=acceleration / (2.0 * np.pi * frequency), frequency=frequency)


def _denser(made: BenchScene, block: int, factor: float) -> BenchScene:
    """The scene with one block heavier."""
    blocks = list(made.blocks)
    blocks[block] = replace(blocks[block], density=factor * blocks[block].density)
    return replace(made, blocks=tuple(blocks))


def _pushed(count: int, ratio: float) -> BenchScene:
    """A tower whose top block takes a force of ten times the tower's weight, which is ``ratio`` times its own, aslant by a tenth."""
    made = tower(count, amplitude=0.0)
    weight = made.blocks[-1].density * float(np.ptp(made.blocks[-1].vertices, axis=0).prod()) * GRAVITY
    force = 10.0 * count * weight
    return replace(_denser(made, -1, force / weight / ratio), force=(PUSHED_ASIDE * force, 0.0, -force))


def _scaled(made: BenchScene, factor: float) -> BenchScene:
    """The scene with all lengths multiplied."""
    return replace(made, blocks=tuple(replace(block, vertices=factor * block.vertices) for block in made.blocks))


def run(case: StabilityCase, solver: str = "auto") -> Outcome:
    """Step a case and judge it."""
    machine = stepper(case.scene, case.steps, solver, case.tolerance)
    assembly, free = machine.assembly, ~machine.assembly.fixed
    settle(machine)
    begin = machine.state.position.copy()
    width, built = machine.width, built_gap(assembly)
    support = int(np.argmax(assembly.fixed))
    work, missed, stopped = float(assembly.mass[free].sum()) * GRAVITY * width, 0, ""
    seen = [np.zeros(6)]
    with counted() as cost:
        for _ in range(case.steps):
            try:
                report = machine.step()
            except RunStopped as reason:
                stopped = str(reason)
                break
            cost.end_step(report.contacts)
            energy = machine.energy
            work = max(work, abs(energy["base_work"]), abs(energy["gravity_work"]), energy["kinetic"])
            missed += not report.error <= case.tolerance
            moved = machine.state.position - begin
            ways = [history[free] - history[support] for history in (moved, case.scene.dt * machine.state.velocity[:, :3])]
            lengths = [np.linalg.norm(way, axis=1).max() / width for way in ways]
            gain = -energy["friction"] - energy["impact"] - energy["damping"]
            deep = np.maximum(0.0, report.penetration - built) / width  # NaN stays NaN
            seen.append(np.array([*lengths, deep, abs(energy["balance"]), gain, report.error]))
    drift, travel, penetration, balance, gained, error = (0.0 + np.max(seen, axis=0)).tolist()  # NaN stays NaN, and fails
    return Outcome(
        group=case.group, name=case.name, at_rest=case.at_rest, blocks=int(free.sum()), steps=machine.steps, drift=drift, travel=travel,
        penetration=penetration, balance=balance / work, gained=gained / work, missed=missed, error_max=error, worst=cost.worst,
        stopped=stopped,
    )  # fmt: skip


MEASURED = ("drift", "travel", "penetration", "balance", "gained", "missed", "largest error", "worst/median")
HEAD = ("case", "blocks", "steps", *MEASURED, "verdict")


def row(found: Outcome) -> str:
    """A line of the table; the drift of what is shaken is no fault, and stands in brackets."""
    drift = f"{found.drift:.1e}" if found.at_rest else f"({found.drift:.1e})"
    numbers = [drift, *(f"{value:.1e}" for value in (found.travel, found.penetration, found.balance, found.gained))]
    verdict = f"**FAIL**: {', '.join(found.failures)}" if found.failures else "pass"
    cells = [found.name, found.blocks, found.steps, *numbers, found.missed, f"{found.error_max:.1e}", f"{found.worst:.0f}", verdict]
    return "| " + " | ".join(map(str, cells)) + " |"


def table(outcomes: Sequence[Outcome]) -> str:
    """The table in Markdown."""
    head = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    return "\n".join(head + [row(found) for found in outcomes])


def sheet(outcomes: Sequence[Outcome]) -> str:
    """The page that docs/ keeps."""
    passed = sum(not found.failures for found in outcomes)
    steps, missed = sum(found.steps for found in outcomes), sum(found.missed for found in outcomes)
    words = (__doc__ or "").split("\n\n", 2)[2].strip()
    limits = (
        f"DRIFT {DRIFT:g}, REST_OVERLAP {REST_OVERLAP:g}, OVERLAP {OVERLAP:g}, BALANCE {BALANCE:g}, GAINED {GAINED:g}; "
        f"tolerance {TOLERANCE:g}, {HARD:g} of what is shaken hard in space, solver auto"
    )
    return (
        "\n\n".join(
            [
                "# Stiff and extreme cases",
                f"Made by `python -m benchmarks.stability`: {passed} of {len(outcomes)} cases pass, "
                f"{missed} of {steps} steps missed the tolerance.",
                words,
                f"{limits}. Drift, travel in a step and penetration are shares of the smallest block's width, energies of the "
                "largest work done. What travels a good part of that width in a step can get into a block before it is seen.",
                table(outcomes),
            ]
        )
        + "\n"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line, see the head of this file; 1 if a case fails."""
    parser = argparse.ArgumentParser(description="Stiff and extreme cases: drift, penetration, energy, steps missed.")
    parser.add_argument("-o", "--output", type=Path, help="write the page, Markdown")
    parser.add_argument("--picture", type=Path, help="draw the measures against their limits")
    parser.add_argument("--only", default="", help="cases whose group or name holds this word")
    parser.add_argument("--solver", default="auto")
    given = parser.parse_args(arguments)
    chosen = [case for case in cases() if given.only in case.group or given.only in case.name]
    if not chosen:
        parser.error(f'no case "{given.only}"')
    print(f"{platform.machine()}, Python {platform.python_version()}\n\n{table([])}", flush=True)
    outcomes = []
    for case in chosen:
        outcomes.append(run(case, given.solver))
        print(row(outcomes[-1]), flush=True)
    if given.output:
        given.output.write_text(sheet(outcomes), encoding="utf-8")
    if given.picture:
        draw(outcomes, given.picture)
    return int(any(found.failures for found in outcomes))


if __name__ == "__main__":
    sys.exit(main())
