r"""Limit analysis against the dynamics: the factor of a push that each kind of structure bears, by both, and what the cone programme costs.

    python -m benchmarks.limit                       all kinds, push along x and across; "large church" when it is named
    python -m benchmarks.limit --walls               dry walls of Ferris & Tin-Loi: associated, least found, published
    python -m benchmarks.limit dome arch --share 0.005
    python -m benchmarks.limit --sizes 3.0 2.0 1.3   churches by the length of their blocks: seconds, iterations, gap

**By the dynamics** a push is held from rest, on rigid joints, for SECONDS: the structure moves if a block goes farther than MOVED of the
smallest width. The factor is bracketed by halving between one at which it stands and one at which it moves, to a share of the factor.
A hair above its factor a structure is too slow to be seen, so both may lie some thousandths too high.
Where sliding decides, rigid dynamics may find any factor that Coulomb's law allows, from the least one without dilation to the
associated one.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import structures
from benchmarks import dry_walls
from benchmarks.sitting import head
from masonry_cd.contact.find_joints import find_joints
from masonry_cd.dynamics.moreau_jean import Stepper
from masonry_cd.dynamics.settings import Run
from masonry_cd.limit.analysis import Analysis, Options, analyse
from masonry_cd.limit.mechanism import STATES
from masonry_cd.limit.problem import Bars, Loads
from masonry_cd.model.blocks import Assembly

GRAVITY = 9.81  # [m/s2]
FRICTION, DENSITY = 0.6, 2000.0
SECONDS = 1.5  # that a push is held
MOVED = 0.01
STEP = 5e-3  # [s]


def church(length: float) -> dict[str, Any]:
    """A church with aisles and a tower, of blocks of a length; 2.6 m makes 710."""
    table = {"kind": "church", "block_length": length, "course_height": 0.5 * length, "aisles": True, "length": 26.0, "height": 11.0}
    return table | {"thickness": 1.1, "windows": 3, "tower_height": 22.0}


TABLES: dict[str, dict[str, Any]] = {
    "arch": {"kind": "arch", "span": 4.0, "thickness": 0.6, "width": 1.0, "voussoirs": 21},
    "aqueduct": {"kind": "aqueduct", "spans": 2, "clear_span": 4.0, "pier_width": 1.6, "ring_thickness": 0.5, "width": 2.0},
    "wall": {"kind": "wall", "length": 3.0, "height": 2.0, "thickness": 0.4, "course_height": 0.25},
    "column": {"kind": "column", "height": 5.0, "diameter": 0.9, "drums": 6, "sides": 8},
    "tower": {"kind": "tower", "side": 3.0, "height": 9.0, "thickness": 0.6, "course_height": 0.75, "belfry_width": 0.0, "door_width": 0.0},
    "barrel vault": {"kind": "vault", "form": "barrel", "span": 4.0, "thickness": 0.5, "voussoirs": 13, "length": 2.0, "unit_length": 1.0},
    "cross vault": {"kind": "vault", "form": "cross", "span": 4.0, "thickness": 0.5, "voussoirs": 9},
    "dome": {"kind": "dome", "span": 5.0, "thickness": 0.6, "sides": 8, "rows": 5, "oculus": 1.0},
    "church": {"kind": "church", "block_length": 3.0, "course_height": 1.25},
    "large church": church(2.6),
}
USUAL = [name for name in TABLES if name != "large church"]  # which takes as long as all others
WAYS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0)}


def push(assembly: Assembly, direction: Sequence[float] = WAYS["x"], bars: Bars | None = None) -> Loads:
    """Gravity, and lambda times the weight along a direction, on the free blocks; and ties."""
    weight = np.where(assembly.fixed, 0.0, GRAVITY * assembly.mass)
    dead, live = np.zeros((assembly.count, 6)), np.zeros((assembly.count, 6))
    dead[:, 2], live[:, :3] = -weight, weight[:, None] * np.asarray(direction) / np.linalg.norm(direction)
    return Loads(dead, live, bars or Bars.none())


def moves(assembly: Assembly, direction: Sequence[float], factor: float) -> bool:
    """Whether rigid blocks at rest move under a held push."""
    steps = round(SECONDS / STEP)
    pull = np.tile(GRAVITY * (factor * np.asarray(direction) - [0.0, 0.0, 1.0]), (steps + 1, 1))
    run = Run.model_validate({"dt": STEP, "duration": SECONDS, "tolerance": 1e-6})
    machine = Stepper(assembly, np.zeros((steps + 1, 1, 3)), pull, run)
    for _ in range(steps):
        machine.step()
        if np.abs(machine.state.position - assembly.centre).max() > MOVED * assembly.width:
            return True
    return False


def bracket(assembly: Assembly, direction: Sequence[float], guess: float, share: float) -> tuple[float, float]:
    """A factor at which the structure stands and one at which it moves, apart by a share of the guess."""
    low, high = 0.97 * guess, 1.02 * guess
    while moves(assembly, direction, low):
        low, high = 0.9 * low, low
    while not moves(assembly, direction, high):
        low, high = high, 1.05 * high
    while high - low > share * guess:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if moves(assembly, direction, middle) else (middle, high)
    return low, high


def row(name: str, way: str, share: float) -> str:
    """A row of the table: limit analysis and dynamics of a structure."""
    blocks, _ = structures.build_with_notes(TABLES[name], DENSITY, Path())
    assembly = Assembly.from_blocks(blocks, FRICTION)
    found = analyse(assembly, find_joints(assembly), push(assembly, WAYS[way]), Options(starts=2))
    if not found.stands:
        return f"| {name} | {way} | {assembly.count} | does not stand | | | |"
    factor = found.associated.factor
    low, high = bracket(assembly, WAYS[way], found.least.optimum.factor if found.least else factor, share)
    least = f"{found.least.optimum.factor:.4f}" if found.least else ""
    part = sum(found.associated.mechanism.count(state) for state in STATES[2:4])
    kind = f"{part} joints slide" if part else "hinges"
    return f"| {name} | {way} | {assembly.count} | {least} | {factor:.4f} | {low:.4f} to {high:.4f} | {kind} |"


def wall_row(number: int, share: float) -> str:
    """A dry wall of Ferris & Tin-Loi: both factors, three starts, and the dynamics."""
    assembly = Assembly.from_blocks(dry_walls.dry_wall(number), dry_walls.FRICTION)
    found = analyse(assembly, find_joints(assembly), push(assembly), Options(starts=3))
    least = f"{found.least.optimum.factor:.4f}" if found.least else ""
    low, high = bracket(assembly, WAYS["x"], found.associated.factor, share)
    return f"| {number} | {found.associated.factor:.5f} | {least} | {dry_walls.LEAST.get(number, '')} | {low:.3f} to {high:.3f} |"


def size_row(length: float, sides: int) -> str:
    """A church with blocks of a length: what the cone programmes take, or pyramids with so many sides."""
    blocks, _ = structures.build_with_notes(church(length), DENSITY, Path())
    assembly = Assembly.from_blocks(blocks, FRICTION)
    joints = find_joints(assembly)
    begin = time.perf_counter()
    found: Analysis = analyse(assembly, joints, push(assembly, WAYS["y"]), Options(sides, starts=0))
    whole = time.perf_counter() - begin
    answer, made = found.associated, found.associated.certificate
    worst = max(made.equilibrium, made.friction, made.flow)
    numbers = f"{found.problem.points.count} | {answer.factor:.5f} | {answer.optimum.iterations} | {answer.seconds:.1f} | {whole:.1f}"
    return f"| {length:g} | {assembly.count} | {numbers} | {made.gap:.0e} | {worst:.0e} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables asked for."""
    raw = argparse.RawTextHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m benchmarks.limit", description=__doc__, formatter_class=raw)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of {', '.join(TABLES)}; all when none is named")
    parser.add_argument("--share", type=float, default=0.01, help="width of the bracket of the dynamics, as a share of the factor")
    parser.add_argument("--sizes", type=float, nargs="+", metavar="LENGTH", help="of the blocks of churches [m]: what the solver takes")
    parser.add_argument("--sides", type=int, default=0, help="of pyramids in the place of cones, with --sizes")
    parser.add_argument("--walls", action="store_true", help="the dry walls of Ferris & Tin-Loi, three starts each")
    asked = parser.parse_args(arguments)
    unknown = [kind for kind in asked.kinds if kind not in TABLES]
    if unknown or not math.isfinite(asked.share) or asked.share <= 0.0:
        parser.error(f"no such kind: {', '.join(unknown)}" if unknown else "--share is above 0")
    if asked.walls:
        print(head("wall", "associated", "least found", "published", "dynamics stands, moves"))
        for number in dry_walls.ROWS:
            print(wall_row(number, asked.share), flush=True)
        return
    if asked.sizes:
        heads = ("blocks", "points", "factor", "iterations", "seconds", "with the check at rest", "gap", "residual")
        print(head("block length [m]", *heads))
        for length in asked.sizes:
            print(size_row(length, asked.sides), flush=True)
        return
    print(head("structure", "push", "blocks", "least found", "associated", "dynamics stands, moves", "associated mechanism"))
    for kind in asked.kinds or USUAL:
        for way in WAYS:
            print(row(kind, way, asked.share), flush=True)


if __name__ == "__main__":
    main()
