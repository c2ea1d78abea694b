# SPDX-License-Identifier: GPL-3.0-or-later
r"""How exact the points of elastic joints that open are, by their number over the depth: a table for docs/validation.md.

    python -m benchmarks.joint_points
    python -m benchmarks.joint_points --search    # the rules of 5, 7 and 9 points again: those of least largest error
    python -m benchmarks.joint_points --cost benchmarks/church_laquila.toml --records FOLDER --set material.joints.normal_stiffness=1e10

What rings cost, and what is saved where joints that carry less than LIGHT of their lighter block's weight keep their corners: a scene is
stepped with several numbers of points, and with nine in all joints, by turns; the table has contacts, seconds of the processor and motion.

A bed without tension of depth 2 and area 1, turned by the angle 1 on springs of stiffness 1, that touches over a depth c has the force
and the moment about its middle

    N = integral of (c - x) b(x) dx,      M = integral of (c - x) (1 - x) b(x) dx,      x from 0 to c,

with b = 1/2 for a rectangle about an axis along its sides, and b = min(x, 2 - x) for a square about its diagonal. All beds are similar to
these.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from unittest.mock import patch

import numpy as np
from scipy.optimize import differential_evolution, minimize

from benchmarks.ours import stepper_of_file
from benchmarks.profile import records_in
from masonry_cd.mechanics.contact import detector
from masonry_cd.mechanics.contact.joint_points import LEAST_ERROR, LIGHT, MOST, rule

IN_CONTACT = np.linspace(0.03, 1.0, 971)  # shares of the depth
COARSE = IN_CONTACT[::10]  # likewise, while a rule is searched
POINTS = range(3, MOST + 1, 2)
POLISHED = 6  # times that a search goes on from what it found
STRIPS = 2000  # of a bed whose moment is integrated
Rule = tuple[np.ndarray, np.ndarray]  # shares of the way from the centroid to a corner, and of its area


def on_the_depth(found: Rule) -> Rule:
    """Places from -1 to 1 and shares of the area, each (points,), of a rule along the depth of a rectangle."""
    way, half = found[0], found[1] / 6.0
    return np.concatenate([way, -way, [0.0]]), np.concatenate([half, half, [1.0 - 2.0 * half.sum()]])


def on_the_diagonal(found: Rule) -> Rule:
    """Those along the diagonal of a square: two of its four corners, and their rings, are in the middle."""
    way, corner = found[0], found[1] / 12.0
    return np.concatenate([way, -way, [0.0]]), np.concatenate([corner, corner, [1.0 - 2.0 * corner.sum()]])


def rectangle(c: float) -> tuple[float, float]:
    """Force and moment of a rectangle that touches over a depth c."""
    return 0.25 * c * c, 0.25 * c * c * (1.0 - c / 3.0)


def square(c: float) -> tuple[float, float]:
    """Those of a square about its diagonal, by strips."""
    x = (np.arange(STRIPS) + 0.5) * c / STRIPS
    pressed = (c - x) * np.minimum(x, 2.0 - x) * c / STRIPS
    return float(pressed.sum()), float(pressed @ (1.0 - x))


def errors(points: Rule, exact: Callable[[float], tuple[float, float]] = rectangle, shares: np.ndarray = IN_CONTACT) -> np.ndarray:
    """Errors (C,) of the moment, as shares of the exact one, of places and shares of the area, by the share of the depth in contact."""
    order = np.argsort(-points[0], kind="stable")
    depth, weight = 1.0 - points[0][order], points[1][order]
    carried, lever = np.cumsum(weight), np.cumsum(weight * depth)
    out = []
    for c in 2.0 * shares:
        force, moment = exact(c)
        sunk = (force + lever) / carried  # of the edge, if that number of points touch
        touching = int(np.flatnonzero(sunk <= np.append(depth[1:], np.inf) + 1e-12)[0]) + 1
        pressure = weight[:touching] * (sunk[touching - 1] - depth[:touching])
        out.append(pressure @ (1.0 - depth[:touching]) / moment - 1.0)
    return np.array(out)


def table() -> str:
    """The lines of the table."""
    lines = ["| `joint_points` | along its side: least error | largest | square, diagonal: least | largest |", "|---|---|---|---|---|"]
    rules = [(str(points), rule(points)) for points in POINTS]
    fitted = [points for points in LEAST_ERROR if points > min(LEAST_ERROR)]
    with patch.dict(LEAST_ERROR, clear=True):
        rules += [(f"{points}, Gauss and Lobatto", rule(points)) for points in fitted]
    for name, found in rules:
        along, across = 100.0 * errors(on_the_depth(found)), 100.0 * errors(on_the_diagonal(found), square)
        lines.append(f"| {name} | {along.min():.1f} % | +{along.max():.1f} % | {across.min():.1f} % | +{across.max():.1f} % |")
    return "\n".join(lines)


def search(points: int, seed: int = 0) -> Rule:
    """The rule of 5, 7 or 9 points whose largest error is least, with sum s_k r_k^2 = 1."""
    inner = points // 2 - 1

    def of(x: np.ndarray) -> Rule:
        way, share = np.append(1.0, x[:inner]), x[inner:]
        return way, np.append(1.0 - share @ way[1:] ** 2, share)

    def worst(x: np.ndarray, shares: np.ndarray) -> float:
        made = on_the_depth(of(x))
        return 10.0 if made[1].min() <= 0.0 else float(np.abs(errors(made, shares=shares)).max())

    bounds = [(0.1, 0.99)] * inner + [(0.1, 3.0)] * inner
    found = differential_evolution(worst, bounds, args=(COARSE,), seed=seed, maxiter=400, tol=1e-9).x
    for _ in range(POLISHED):
        found = minimize(worst, found, args=(IN_CONTACT,), method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-9}).x
    way, share = of(found)
    order = np.argsort(-way)
    return way[order], share[order]


def costs(path: Path, changes: Sequence[str], steps: int) -> str:
    """The lines of the table of what rings cost in a scene on elastic joints, which are stepped by turns.

    Raises:
        InputError: anything wrong with the scene.
    """
    ways = {**{str(points): (points, LIGHT) for points in (3, 7, 9, 11)}, "9 in all joints": (9, 0.0)}
    made = {}
    for name, (points, light) in ways.items():
        with patch.object(detector, "LIGHT", light):
            made[name] = stepper_of_file(path, ["run.threads=1", *changes, f"material.joints.joint_points={points}"])
    spent, contacts, moved = dict.fromkeys(ways, 0.0), dict.fromkeys(ways, 0), dict.fromkeys(ways, 0.0)
    placed = {name: machine.state.position.copy() for name, machine in made.items()}
    for _ in range(steps):
        for name, machine in made.items():
            with patch.object(detector, "LIGHT", ways[name][1]):
                begin = time.process_time()
                contacts[name] += machine.step().contacts
                spent[name] += time.process_time() - begin
            moved[name] = max(moved[name], float(np.linalg.norm(machine.state.position - placed[name], axis=1).max()))
    lines = ["| `joint_points` | contacts | seconds a step | over 3 points | motion [mm] |", "|---|---|---|---|---|"]
    for name in ways:
        each = f"{contacts[name] / steps:.0f} | {spent[name] / steps:.4f} | {spent[name] / spent['3']:.2f} | {1e3 * moved[name]:.1f}"
        lines.append(f"| {name} | {each} |")
    return "\n".join(lines)


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="How exact the points of elastic joints that open are.")
    parser.add_argument("--search", action="store_true", help="the rules of 5, 7 and 9 points again")
    parser.add_argument("--cost", type=Path, metavar="SCENE", help="what rings cost in a scene on elastic joints")
    parser.add_argument("--records", type=Path, metavar="FOLDER", help="where its records are")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes", help="a change of the scene")
    parser.add_argument("--steps", type=int, default=100, help="of the scene")
    asked = parser.parse_args()
    if asked.cost is not None:
        records = [] if asked.records is None else records_in(asked.records, asked.cost)
        print(costs(asked.cost, [*records, *asked.changes], asked.steps))
        return
    if not asked.search:
        print(table())
        return
    for points in (5, 7, 9):
        found, used = search(points), rule(points)
        for name, each in (("found", found), ("used", used)):
            worst = 100.0 * np.abs(errors(on_the_depth(each))).max()
            print(f"{points} points, {name}: r = {each[0].round(6)}, s = {each[1].round(6)}, error up to {worst:.2f} %")


if __name__ == "__main__":
    main()
