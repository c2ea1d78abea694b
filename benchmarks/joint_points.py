r"""How exact the points of elastic joints that open are, by their number over the depth: a table for docs/validation.md.

    python -m benchmarks.joint_points

A bed without tension of depth 2, turned by the angle 1 on springs of stiffness 1/2, that touches over a depth c has the force
N = c^2 / 4, and the moment N (1 - c/3) about its middle. All beds are similar to this one.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.contact.joint_points import MOST, rule

IN_CONTACT = np.linspace(0.1, 1.0, 901)  # shares of the depth
POINTS = range(3, MOST + 1, 2)


def on_the_depth(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Places from -1 to 1 and shares of the area, each (points,), of a rule along the depth of a rectangle."""
    way, share = rule(points)
    half = share / 6.0
    return np.concatenate([way, -way, [0.0]]), np.concatenate([half, half, [1.0 - 2.0 * half.sum()]])


def errors(points: int) -> np.ndarray:
    """Errors (C,) of the moment, as shares of the exact one, by the share of the depth in contact."""
    place, weight = on_the_depth(points)
    order = np.argsort(-place)
    depth, weight = 1.0 - place[order], weight[order]
    carried, lever = np.cumsum(weight), np.cumsum(weight * depth)
    out = []
    for c in 2.0 * IN_CONTACT:
        force = c * c / 4.0
        sunk = (force + lever) / carried  # of the edge, if so many points touch
        touching = int(np.flatnonzero(sunk <= np.append(depth[1:], np.inf) + 1e-12)[0]) + 1
        pressure = weight[:touching] * (sunk[touching - 1] - depth[:touching])
        out.append(pressure @ (1.0 - depth[:touching]) / (force * (1.0 - c / 3.0)) - 1.0)
    return np.array(out)


def table() -> str:
    """The lines of the table."""
    lines = ["| `joint_points` | least error | largest error |", "|---|---|---|"]
    for points in POINTS:
        found = 100.0 * errors(points)
        lines.append(f"| {points} | {found.min():.1f} % | +{found.max():.1f} % |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
