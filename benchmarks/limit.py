# SPDX-License-Identifier: GPL-3.0-or-later
r"""Limit analysis against the dynamics: the factor of a push that each kind of structure bears, by both, and what the cone programme costs.

    python -m benchmarks.limit                       all kinds, push along x and across; "large church" when it is named
    python -m benchmarks.limit --walls               dry walls of Ferris & Tin-Loi: associated, least found, published
    python -m benchmarks.limit dome arch --share 0.005
    python -m benchmarks.limit church --along y --jobs 8 -o church.json
    python -m benchmarks.limit --sizes 2.6 1.7 1.3   churches by the length of their blocks: seconds, iterations, gap
    python -m benchmarks.limit --searched examples/church_parts.toml   its check, rounds of the search among all blocks and among some

**By the dynamics** a push is held from rest, on rigid joints, and the factor at which blocks begin to move is bracketed by trials, to a
share of the factor (:mod:`benchmarks.held_push`). ``--jobs`` makes several at a time; ``-o`` keeps what is known so far. A hair above its
factor a structure is too slow to be seen, so both may lie some thousandths too high.
Where sliding decides, rigid dynamics may find any factor that Coulomb's law allows, from the least one without dilation to the
associated one.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import dry_walls
from benchmarks.held_push import GRAVITY, Bracket, Trial, bracket
from benchmarks.limit_structures import NAMES, USUAL, church, made, of_table
from benchmarks.sitting import head
from masonry_cd.analysis.limit import neighbours
from masonry_cd.analysis.limit.analysis import Analysis, LimitOptions, analyse
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.analysis.limit.problem import Bars, BlockLoads
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import limit_case
from masonry_cd.limit.facts import facts
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly

FRICTION = 0.6
WAYS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0)}


def push(assembly: Assembly, direction: Sequence[float] = WAYS["x"], bars: Bars | None = None) -> BlockLoads:
    """Gravity, and lambda times the weight along a direction, on the free blocks; and ties."""
    weight = np.where(assembly.fixed, 0.0, GRAVITY * assembly.mass)
    dead, live = np.zeros((assembly.count, 6)), np.zeros((assembly.count, 6))
    dead[:, 2], live[:, :3] = -weight, weight[:, None] * np.asarray(direction) / np.linalg.norm(direction)
    return BlockLoads(dead, live, bars or Bars.none())


@dataclass(frozen=True)
class Asked:
    """How to look for the factor of the dynamics."""

    share: float = 0.01  # width of the bracket, over the factor
    jobs: int = 1  # trials at a time
    within: float = math.inf  # seconds of the clock
    starts: int = 2  # of the search for the least factor
    between: tuple[float, float] | None = None  # where the dynamics is looked for; None: by the two factors of limit analysis
    friction: float = FRICTION
    file: Path | None = None  # for what is known so far


def row(name: str, way: str, asked: Asked, rows: list[dict[str, Any]]) -> str:
    """A row of the table: limit analysis and dynamics of a structure; its numbers go to ``rows``, which are written as trials end."""
    assembly = Assembly.from_blocks(made(name), asked.friction)
    found = analyse(assembly, find_joints(assembly), push(assembly, WAYS[way]), LimitOptions(starts=asked.starts))
    if not found.stands:
        return f"| {name} | {way} | {assembly.count} | does not stand | | | |"
    factor = found.associated.factor
    lowest = found.least.optimum.factor if found.least else factor
    sliding = sum(found.associated.mechanism.count(state) for state in STATES[2:4])
    rows.append({"structure": name, "push": way, "blocks": assembly.count, "least": lowest, "associated": factor, "joints_slide": sliding})

    def report(bracket: Bracket, trial: Trial) -> None:
        rows[-1] |= bracket.numbers()
        if asked.file:
            asked.file.write_text(json.dumps(rows, indent=1))
        words = f"{name} {way} {trial.factor:.4f}: {trial.verdict} at {trial.time:.3f} s, gone {trial.gone:.1e} of the width"
        print(f"{words}, {trial.seconds:.0f} s of processor time; {_ends(bracket)}", file=sys.stderr, flush=True)

    seen = bracket(assembly, WAYS[way], asked.between or (lowest, factor), asked.share, asked.jobs, asked.within, report)
    least = f"{lowest:.4f}" if found.least else ""
    kind = f"{sliding} joints slide" if sliding else "hinges"
    return f"| {name} | {way} | {assembly.count} | {least} | {factor:.4f} | {_ends(seen)} | {kind} |"


def _ends(seen: Bracket) -> str:
    """A bracket in a cell of a table."""
    low, high = ("?" if end is None else f"{end:.4f}" for end in (seen.low, seen.high))
    return f"{low} to {high}"


def wall_row(number: int, share: float) -> str:
    """A dry wall of Ferris & Tin-Loi: both factors, three starts, and the dynamics."""
    assembly = Assembly.from_blocks(dry_walls.dry_wall(number), dry_walls.FRICTION)
    found = analyse(assembly, find_joints(assembly), push(assembly), LimitOptions(starts=3))
    factor = found.associated.factor
    lowest = found.least.optimum.factor if found.least else factor
    seen = bracket(assembly, WAYS["x"], (lowest, factor), share)
    least = f"{lowest:.4f}" if found.least else ""
    return f"| {number} | {factor:.5f} | {least} | {dry_walls.LEAST.get(number, '')} | {_ends(seen)} |"


def size_row(length: float) -> str:
    """A church with blocks of a length: what the cone programmes take."""
    assembly = Assembly.from_blocks(of_table(church(length)), FRICTION)
    joints = find_joints(assembly)
    begin = time.perf_counter()
    found: Analysis = analyse(assembly, joints, push(assembly, WAYS["y"]), LimitOptions(starts=0))
    whole = time.perf_counter() - begin
    answer, made = found.associated, found.associated.certificate
    worst = max(made.equilibrium, made.friction, made.flow)
    numbers = f"{found.problem.points.count} | {answer.factor:.5f} | {answer.optimum.iterations} | {answer.seconds:.1f} | {whole:.1f}"
    return f"| {length:g} | {assembly.count} | {numbers} | {made.gap:.0e} | {worst:.0e} |"


def searched_row(path: Path, push: str) -> str:
    """The check of a scene under a push: with all blocks free in every round of its search, and with those that move and touch them."""
    few, cells = neighbours.FEW, list[str]()
    for share in (0.0, few):
        neighbours.FEW = share
        begin, spent = time.perf_counter(), time.process_time()
        least = facts(limit_case(path, (f'limit.push="{push}"', f"limit.mechanism={json.dumps([])}")))["least"]
        found = "none" if least is None else f"{least['factor']:.4f}, {least['agreeing']} of {least['starts']}"
        cells.append(f"{time.perf_counter() - begin:.1f} ({time.process_time() - spent:.1f}) | {found}")
    return f"| {path.stem} | {push} | {' | '.join(cells)} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables requested."""
    raw = argparse.RawTextHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m benchmarks.limit", description=__doc__, formatter_class=raw)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"of {', '.join(NAMES)}; all when none is named")
    parser.add_argument("--share", type=float, default=0.01, help="width of the bracket of the dynamics, as a share of the factor")
    parser.add_argument("--along", choices=WAYS, help="one direction of the push; both when not given")
    parser.add_argument("--jobs", type=int, default=1, help="trials of the dynamics at a time, each in a process of its own")
    parser.add_argument("--within", type=float, default=math.inf, help="seconds of the clock for the trials of each row")
    parser.add_argument("--between", type=float, nargs=2, metavar="FACTOR", help="where to look; by limit analysis when not given")
    parser.add_argument("--starts", type=int, default=2, help="of the search for the least factor")
    parser.add_argument("--friction", type=float, default=FRICTION, help="of the joints; where it is great, nothing slides")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="JSON with all trials, written as they go")
    parser.add_argument("--sizes", type=float, nargs="+", metavar="LENGTH", help="of the blocks of churches [m]: what the solver takes")
    parser.add_argument("--searched", type=Path, nargs="+", metavar="SCENE", help="with a check: what its search takes")
    parser.add_argument("--walls", action="store_true", help="the dry walls of Ferris & Tin-Loi, three starts each")
    asked = parser.parse_args(arguments)
    unknown = [kind for kind in asked.kinds if kind not in NAMES]
    if unknown or not math.isfinite(asked.share) or asked.share <= 0.0:
        parser.error(f"no such kind: {', '.join(unknown)}" if unknown else "--share is above 0")
    if asked.jobs < 1 or asked.starts < 0 or not asked.within > 0.0:
        parser.error("--jobs is 1 or more, --starts 0 or more, --within above 0")
    if not 0.0 <= asked.friction < math.inf:
        parser.error("--friction is 0 or more")
    if asked.between and not 0.0 < asked.between[0] <= asked.between[1] < math.inf:
        parser.error("--between takes two factors above 0, the smaller one first")
    if asked.walls:
        print(head("wall", "associated", "least found", "published", "dynamics stands, moves"))
        for number in dry_walls.ROWS:
            print(wall_row(number, asked.share), flush=True)
        return
    if asked.searched:
        print(head("scene", "push", "all: seconds (processor)", "least, starts agree", "some: seconds (processor)", "least, starts agree"))
        for path in asked.searched:
            for way in [asked.along] if asked.along else WAYS:
                print(searched_row(path, way), flush=True)
        return
    if asked.sizes:
        heads = ("blocks", "points", "factor", "iterations", "seconds", "with the check at rest", "gap", "residual")
        print(head("block length [m]", *heads))
        for length in asked.sizes:
            try:
                print(size_row(length), flush=True)
            except InputError as error:
                parser.error(f"--sizes {length:g}: {error}")
        return
    print(head("structure", "push", "blocks", "least found", "associated", "dynamics stands, moves", "associated mechanism"))
    between = tuple(asked.between) if asked.between else None
    how = Asked(asked.share, asked.jobs, asked.within, asked.starts, between, asked.friction, asked.output)
    rows: list[dict[str, Any]] = []
    for kind in asked.kinds or USUAL:
        for way in [asked.along] if asked.along else WAYS:
            print(row(kind, way, how, rows), flush=True)


if __name__ == "__main__":
    main()
