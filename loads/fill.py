# SPDX-License-Identifier: GPL-3.0-or-later
r"""What the fill of a bridge does to blocks beside its weight, which rides on them (:mod:`masonry_cd.mechanics.model.fill`).

**Pressure.** On a wall, and on the back of an abutment of blocks, K gamma (depth) at right angles to the face, K_0 = 1 - sin(phi) (Jaky
1944) or Rankine's K_a: a force that stays as the wall moves, which for a wall that gives way is on the safe side.

**Passive resistance.** An extrados, or the back of an abutment, that moves into the fill meets along the level part of its normal

    P = m K_p gamma integral(depth |dA_level|),        K_p = (1 + sin phi) / (1 - sin phi),

where m is the share that is mobilised at most: by default a third, and under loads that shake or push a share of its own, by default 0.3.
Both are assumptions of this program. P grows linearly with the displacement, is capped, and is none where the face moves away: the law of a
bar that pulls, never pushes, and yields (:mod:`loads.bars`). So each such face has a bar that pulls it out of the fill, FAR long so that
its direction stays, whose other end is the support nearest to it: the fill far away moves with the ground. In limit analysis the bar adds P
times the rate at which its face moves into the fill to the work. The bars' energy is accounted as that of ties.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from loads.bars import PointLoad, Tie
from loads.kinds.forces import bar_of
from loads.motion import LoadTable, Part, RunGrid
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import BARS, Fill, FillFace

FAR = 1000.0  # length of the bars [m]: a face that rises by 0.3 m stretches one by 45 um
DAMPING = 0.05  # of the bars, share of the critical damping
LEAST = 1e-6  # of the largest resistance of a face: faces that are all but level have none
QUIET = ("gravity", "point", "tie", "vehicle", "settlement", "spreading", "prop")  # loads that neither shake nor push


def shakes(tables: Sequence[LoadTable]) -> bool:
    """Whether loads shake or push, so that the passive resistance of an earthquake holds."""
    return any(table.kind not in QUIET for table in tables)


def part(fill: Fill, grid: RunGrid, shaken: bool) -> Part:
    """The forces of a fill: point loads and bars."""
    assert grid.assembly is not None
    pressed = _pressures(fill, grid.assembly, math.hypot(*grid.gravity), len(grid.times))
    bars = _passive(fill, grid, shaken)
    total = sum(float(np.sqrt((load.force**2).sum())) for load in pressed)
    most = sum(bar.limit for bar in bars)
    share = fill.passive_shaken if shaken else fill.passive
    lines = [f"{fill.where}: {total:.4g} N press on walls and backs"] if pressed else []
    if bars:
        why = " (loads shake or push)" if shaken else ""
        lines.append(f"{fill.where}: {len(bars)} faces that move into the fill meet at most {share:.3g} K_p{why}, {most:.4g} N in all")
    summary = {"kind": "fill", "pressure": total, "passive_share": share, "passive_most": most, "shaken": shaken}
    return Part(forces=(*pressed, *bars), lines=tuple(lines), summary=summary)


def _pressures(fill: Fill, assembly: Assembly, gravity: float, times: int) -> list[PointLoad]:
    """The thrusts on walls and backs."""
    k, found, number = fill.coefficients[fill.pressure], list[PointLoad](), _numbers(assembly)
    for face in fill.faces if k * gravity > 0.0 else ():
        block = number.get(face.block)
        if face.kind not in ("wall", "back") or block is None or assembly.fixed[block]:
            continue
        depth, place = face.pressed(fill.level)
        force = -k * fill.density * gravity * depth * face.area
        found.append(PointLoad(block, place - assembly.centre[block], force, np.ones(times)))
    return found


def _passive(fill: Fill, grid: RunGrid, shaken: bool) -> list[Tie]:
    """The bars of the faces that may move into the fill, one to a face."""
    assembly, number = grid.assembly, _numbers(grid.assembly) if grid.assembly else {}
    assert assembly is not None
    share = fill.passive_shaken if shaken else fill.passive
    rate = share * fill.coefficients["passive"] * fill.density * math.hypot(*grid.gravity)
    some = [face for face in fill.faces if face.kind in ("extrados", "back") and not _is_fixed(face, assembly, number)]
    every = [(face, *_resistance(face, fill)) for face in some]
    most = max((size for _, size, _, _ in every), default=0.0)
    supports = np.flatnonzero(assembly.fixed)
    found = []
    for face, size, place, way in every:
        if rate <= 0.0 or size <= LEAST * most:
            continue
        block = number[face.block]
        nearest = supports[int(np.argmin(np.abs(assembly.centre[supports] - place).max(axis=1)))]
        stiffness = rate * size / fill.mobilised_at
        points = np.stack([place, place - FAR * way])
        name = f"{BARS}{face.block.split('.')[0]}, {'left' if way[0] < 0.0 else 'right'}"
        found.append(bar_of(assembly, (block, int(nearest)), points, stiffness, rate * size, DAMPING, name))
    return found


def _resistance(face: FillFace, fill: Fill) -> tuple[float, np.ndarray, np.ndarray]:
    """The integral of depth over the level part of a face [m3], where it acts, and the level direction into the fill."""
    level = face.area * [1.0, 1.0, 0.0]
    size = float(np.sqrt((level**2).sum()))
    depth, place = face.pressed(fill.level)
    return depth * size, place, level / size if size > 0.0 else np.array([1.0, 0.0, 0.0])


def _numbers(assembly: Assembly) -> dict[str, int]:
    return {name: b for b, name in enumerate(assembly.names)}


def _is_fixed(face: FillFace, assembly: Assembly, number: dict[str, int]) -> bool:
    return face.block not in number or bool(assembly.fixed[number[face.block]])
