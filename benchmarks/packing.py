# SPDX-License-Identifier: GPL-3.0-or-later
r"""Spheres that are poured: what it costs until they lie, how well each step is solved, and the slope of the heap that they leave.

    python -m benchmarks.packing 10000 --width 2 --dt 4e-3 --solver accelerated
    python -m benchmarks.packing 5000 --heap --friction 0.3 0.6

They fall from a loose lattice into a box, or with ``--heap`` onto a round floor with a rim one diameter high, over which the surplus rolls.
A run ends when those that are inside have settled: their mean kinetic energy is below ``--still`` times weight and diameter of a sphere, so
that a sphere of mean energy could rise by that share of its diameter; or at ``--longest``.

The seconds are those of the processor, of all threads together, and by the clock; building and compiling are left out. The slope is that of
the line through the tops of the heap over the distance from its axis, from the middle to the rim.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.sitting import head, sitting
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import parse_scene
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

DIAMETER = 0.1  # the largest [m]
FILL = 1.0 / 3.0  # power of the number of spheres with which the floor of a heap grows
FLOOR = 1.4 / 1200**FILL  # diameter of that floor for one sphere [m]
GRAVITY = 9.81
SCENE = """
[structure]
kind = "packing"
count = {count}
diameters = {diameters}
seed = {seed}
{container}
[material]
density = 2000.0
friction = {friction}
{rolling}
[run]
dt = {dt}
duration = {longest}
tolerance = {tolerance}
solver = "{solver}"
threads = {threads}
until_still = false
"""


class Poured(NamedTuple):
    """A packing, and what it took."""

    machine: Stepper
    rim: float  # radius of the floor of a heap [m]; inf: a box
    processor: float  # [s]
    clock: float  # [s]
    errors: np.ndarray  # (S,) of the steps
    iterations: np.ndarray  # (S,)
    contacts: int  # in the last step
    settled: bool


def stepper(asked: argparse.Namespace, friction: float) -> tuple[Stepper, float]:
    """A stepper at the start, and the radius of the rim."""
    floor = FLOOR * asked.count**FILL
    box = f"length = {asked.width}\nwidth = {asked.width}"
    ring = f'form = "cylinder"\ndiameter = {floor}\nheight = {DIAMETER}'
    text = SCENE.format(
        container=ring if asked.heap else box,
        friction=friction,
        rolling=f"rolling_friction = {asked.rolling}" if asked.rolling else "",
        **{key: getattr(asked, key) for key in ("count", "diameters", "seed", "dt", "longest", "tolerance", "solver", "threads")},
    )
    limit = [f"run.max_iterations={asked.max_iterations}"] if asked.max_iterations else []
    case = prepare(parse_scene(text, Path("packing.toml"), limit))
    machine = Stepper(case.assembly, case.loading.support_velocity, case.loading.acceleration, case.scene.run)
    return machine, 0.5 * floor if asked.heap else np.inf


def pour(asked: argparse.Namespace, friction: float) -> Poured:
    """Step until the spheres lie."""
    machine, rim = stepper(asked, friction)
    machine.friction_problem()  # compiles
    errors, iterations, contacts = [], [], 0
    processor, clock, settled = time.process_time(), time.perf_counter(), False
    while not settled and machine.state.time < asked.longest - 0.5 * asked.dt:
        report = machine.step()
        errors.append(report.error)
        iterations.append(report.iterations)
        contacts = report.contacts
        settled = machine.state.time > 0.5 and energy_over_weight(machine, rim) < asked.still
        if asked.verbose and machine.steps % 25 == 0:
            seconds = time.process_time() - processor
            state = f"{machine.state.time:.3f} s, energy {energy_over_weight(machine, rim):.1e}, error {report.error:.1e}"
            print(f"{state}, {report.iterations} iterations, {contacts} contacts, {seconds:.0f} s", flush=True)
    spent = time.process_time() - processor, time.perf_counter() - clock
    return Poured(machine, rim, *spent, np.array(errors), np.array(iterations), contacts, settled)


def inside(machine: Stepper, rim: float) -> np.ndarray:
    """Numbers of the spheres that have not gone over the rim."""
    spheres, position = np.flatnonzero(machine.assembly.shapes.rounding > 0.0), machine.state.position
    return spheres[(np.hypot(*position[spheres, :2].T) < rim) & (position[spheres, 2] > 0.0)]


def energy_over_weight(machine: Stepper, rim: float) -> float:
    """Mean kinetic energy of the spheres inside over their m g d."""
    on = inside(machine, rim)
    r, v = machine.assembly.shapes.rounding[on], machine.state.velocity[on]
    speed = (v[:, :3] ** 2).sum(axis=1) + 0.4 * r * r * (v[:, 3:] ** 2).sum(axis=1)
    return float(np.mean(0.5 * speed / (GRAVITY * 2.0 * r)))


def slope(p: np.ndarray, r: np.ndarray, rim: float) -> float:
    """Angle of repose [deg] of spheres at p (N, 3) of radius r (N,) [m]: of a line through tops, 24 on rings half a diameter apart."""
    distance, height = [], []
    for ring in np.arange(0.5 * DIAMETER, rim - 0.5 * DIAMETER, 0.5 * DIAMETER):
        for turn in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
            across = (p[:, 0] - ring * np.cos(turn)) ** 2 + (p[:, 1] - ring * np.sin(turn)) ** 2
            below = across < r * r
            if below.any():
                distance.append(ring)
                height.append((p[below, 2] + np.sqrt(r[below] ** 2 - across[below])).max())
    return float(np.degrees(np.arctan(-np.polyfit(distance, height, 1)[0])))


def row(asked: argparse.Namespace, friction: float) -> str:
    """A line of the table."""
    done = pour(asked, friction)
    error, missed = done.errors, int((done.errors > asked.tolerance).sum())
    worst, median = f"{error.max():.1e}", f"{np.median(error):.1e}"
    time_of = f"{done.machine.state.time:.2f}" + ("" if done.settled else " (still moves)")
    on, machine = inside(done.machine, done.rim), done.machine
    angle = f"{slope(machine.state.position[on], machine.assembly.shapes.rounding[on], done.rim):.1f}" if asked.heap else ""
    energy = f"{energy_over_weight(machine, done.rim):.0e}"
    counts = [len(on), done.contacts, time_of, energy, len(error), f"{done.iterations.mean():.0f}"]
    cells = [asked.count, friction, *counts, median, worst, missed, f"{done.processor:.0f}", f"{done.clock:.0f}", angle]
    return "| " + " | ".join(map(str, cells)) + " |"


def arguments() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, help="spheres")
    parser.add_argument("--heap", action="store_true", help="onto a floor with a low rim, not into a box")
    parser.add_argument("--friction", nargs="+", type=float, default=[0.5], help="coefficients, a run for each")
    parser.add_argument("--rolling", type=float, default=0.0, help="rolling friction")
    parser.add_argument("--diameters", type=lambda text: [float(d) for d in text.split(",")], default=[DIAMETER], help="with commas [m]")
    parser.add_argument("--width", type=float, default=1.0, help="of the box [m]")
    parser.add_argument("--dt", type=float, default=3e-3, help="time step [s]")
    parser.add_argument("--still", type=float, default=1e-3, help="mean kinetic energy over m g d at which they have settled")
    parser.add_argument("--longest", type=float, default=5.0, help="time after which a run ends in any case [s]")
    parser.add_argument("--tolerance", type=float, default=1e-4, help="natural map error of a step")
    parser.add_argument("--max-iterations", type=int, help="of a step")
    parser.add_argument("--solver", default="auto")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1, help="of the lattice")
    parser.add_argument("--verbose", action="store_true", help="a line every 25 steps")
    return parser


def main() -> None:
    """Command line."""
    asked = arguments().parse_args()
    print(sitting())
    names = ("spheres", "friction", "inside", "contacts", "time [s]", "energy", "steps", "iterations", "median error", "worst", "missed")
    print(head(*names, "processor [s]", "clock [s]", "slope [deg]"), flush=True)
    for friction in asked.friction:
        print(row(asked, friction), flush=True)


if __name__ == "__main__":
    main()
