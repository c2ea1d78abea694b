# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contacts that are not there: gaps that change by more than their pair can have moved, over all examples and scenes of the benchmarks.

    python -m benchmarks.false_contacts
    python -m benchmarks.false_contacts --steps 200 --seconds 60 examples/church_sine.toml tower50 other.toml
    PYTHONPATH=TREE python benchmarks/false_contacts.py      # of another tree of the program, from its root

From one detection to the next no point of b moves farther, as a sees it, than the two centres move apart plus what their turn moves at the
radius of b. So the least gap of a pair that had contacts before is at least what it was less that motion, and a pair that had none is not
deeper in each other than it has moved. A pair that breaks this is a false overlap where its gap is below zero, else an early contact: its
points are where it is only going to be, or lie along another axis. What springs do not feel of an overlap, and shortenings of joints that
crush, change the gaps of their contacts by themselves; such pairs count only where they overlap.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.ours import stepper, stepper_of_file
from benchmarks.scenes import scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped, Stepper

HERE = Path(__file__).parent
NAMED = ("block", "arch27", "tower50", "wall10x10", "arcade3", "arcade50", "church900")
ALLOWED = 0.01  # share of the smaller part's width by which a gap may change more than its pair moves: faces are preferred to edges


@dataclass
class Count:
    """Counts over the detections of a scene."""

    steps: int = 0
    pairs: int = 0  # with contacts, over all steps
    overlaps: int = 0  # false ones
    deepest: float = 0.0  # by how much more than the motion allows [m]
    early: int = 0
    steps_with_overlaps: int = 0
    penetration: float = 0.0  # of the run [m]
    ended: str = ""


class Watch:
    """Looks at each detection of a stepper."""

    def __init__(self, machine: Stepper, count: Count) -> None:
        self._shapes, self._count, self._detect = machine.assembly.shapes, count, machine.detector.detect
        self._last: tuple[np.ndarray, np.ndarray, dict[int, float]] | None = None
        vars(machine.detector)["detect"] = self.detect
        self._pairs: Callable[[], np.ndarray] = lambda: machine.detector.pairs

    def detect(self, position: np.ndarray, rotation: np.ndarray, *rest: Any) -> Any:
        """Detect contacts, and compare them with those before."""
        found, shapes = self._detect(position, rotation, *rest), self._shapes
        rows, at = np.unique(found.pair, return_inverse=True)
        least = np.full(len(rows), np.inf)
        np.minimum.at(least, at, found.gap)
        parts = self._pairs()[rows]
        key = parts @ [len(shapes.part_block), 1]
        if self._last is not None and len(rows):
            old_position, old_rotation, known = self._last
            a, b = shapes.part_block[parts].T
            shift = _relative(position, rotation, a, b) - _relative(old_position, old_rotation, a, b)
            turn = np.linalg.norm(_turn(rotation, a, b) - _turn(old_rotation, a, b), axis=(1, 2))
            moved = np.linalg.norm(shift, axis=1) + shapes.radius[parts[:, 1]] * turn
            before = np.array([known.get(int(k), 0.0) for k in key])
            allowed = ALLOWED * shapes.size[parts].min(axis=1)
            more = before - moved - allowed - least
            false = (more > 0.0) & (least < -allowed)
            had = np.array([int(k) in known for k in key])
            self._count.overlaps += int(false.sum())
            self._count.steps_with_overlaps += bool(false.any())
            self._count.early += int(((more > 0.0) & ~false & had).sum())
            self._count.deepest = max(self._count.deepest, float(more[false].max(initial=0.0)))
        self._count.pairs += len(rows)
        self._last = position.copy(), rotation.copy(), dict(zip(key.tolist(), least.tolist(), strict=True))
        return found


def _relative(position: np.ndarray, rotation: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Centres of blocks b seen from blocks a, (n, 3) [m]."""
    return np.einsum("nij,ni->nj", rotation[a], position[b] - position[a])


def _turn(rotation: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Rotations of blocks b seen from blocks a, (n, 3, 3)."""
    return np.einsum("nij,nik->njk", rotation[a], rotation[b])


def count(machine: Stepper, steps: int, seconds: float) -> Count:
    """Step a scene, for some steps and seconds at the most."""
    out, begin = Count(), time.monotonic()
    Watch(machine, out)
    while out.steps < min(steps, machine.settings.steps) and time.monotonic() - begin < seconds:
        try:
            report = machine.step()
        except RunStopped as reason:
            out.ended = str(reason)
            break
        out.steps += 1
        out.penetration = max(out.penetration, report.penetration)
    return out


def begun(name: str, steps: int, changes: Sequence[str]) -> Stepper:
    """A stepper at the start of a scene file, or of one by its name."""
    if name.endswith(".toml"):
        return stepper_of_file(Path(name), changes)
    return stepper(scene(name), steps, tolerance=1e-4)


def main(words: Sequence[str] | None = None) -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help="files or names; by default all examples, and scenes of the benchmarks")
    parser.add_argument("--steps", type=int, default=1000, help="at the most of each")
    parser.add_argument("--seconds", type=float, default=20.0, help="at the most for each")
    parser.add_argument("--set", dest="changes", action="append", default=[], metavar="KEY=VALUE", help="a key of the scene files")
    asked = parser.parse_args(words)
    files = [path for folder in ("examples", "benchmarks", "benchmarks/bits") for path in sorted((HERE.parent / folder).glob("*.toml"))]
    print("| scene | steps | pairs with contacts | false overlaps | in steps | deepest [mm] | early contacts | penetration [mm] |")
    print("|---|---|---|---|---|---|---|---|")
    for name in asked.scenes or [*map(str, files), *NAMED]:
        try:
            found = count(begun(name, asked.steps, asked.changes), asked.steps, asked.seconds)
        except InputError as reason:
            print(f"{Path(name).name}: {str(reason).splitlines()[0]}", file=sys.stderr)
            continue
        numbers = (
            f"{found.overlaps} | {found.steps_with_overlaps} | {1e3 * found.deepest:.3g} | {found.early} | {1e3 * found.penetration:.3g}"
        )
        print(f"| {Path(name).stem} | {found.steps} | {found.pairs} | {numbers} |{' ' + found.ended if found.ended else ''}", flush=True)


if __name__ == "__main__":
    main()
