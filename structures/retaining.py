# SPDX-License-Identifier: GPL-3.0-or-later
r"""Stability of walls that retain fill: rigid statics, bed by bed.

What stands over the stones of one bed, with weight W at a lever b from the outer face of the wall and the thrust K T of the fill at a
height z over the bed, overturns about its outer edge or slides on the bed unless

    sum(W b) / (K sum(T z)) >= 1,        mu sum(W) / (K sum(T)) >= 1.

Stones next to these count with the part of their length that is over them. The bond, by which a wall leans on what stands next to it, is
left out, and so is the arch: a wall that does not pass may stand, which a run shows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import COVERED, Fill, FillFace

SAME = 1e-6  # [m]: beds nearer than this are one


class Weakest(NamedTuple):
    """Where a wall is nearest to moving away."""

    group: str
    ratio: float  # of what resists and what drives, with K = 1
    slides: bool  # else it overturns
    depth: float  # of the bed under the road [m]


class _Stones(NamedTuple):
    """Those of a wall and of the parapet on it, in its upright section and along it."""

    start: np.ndarray  # (n,) along the wall [m]
    end: np.ndarray
    bed: np.ndarray  # (n,) height of the lower edge [m]
    weight: np.ndarray  # (n,) [N per m/s2]
    lever: np.ndarray  # (n,) of the weight about the outer face [m]
    thrust: np.ndarray  # (n,) with K = 1 [N per m/s2]
    moment: np.ndarray  # (n,) of the thrust about z = 0 [N m per m/s2]

    def over(self, own: np.ndarray) -> np.ndarray:
        """The share of each stone that stands over those of one bed, ``own`` (n,) bool."""
        covered, reached = np.zeros(len(own)), -math.inf
        for start, end in sorted(zip(self.start[own].tolist(), self.end[own].tolist(), strict=True)):
            begin, reached = max(start, reached), max(end, reached)
            covered += np.maximum(0.0, np.minimum(self.end, reached) - np.maximum(self.start, begin)) if reached > begin else 0.0
        return np.asarray(np.where(self.bed >= self.bed[own].min() - SAME, covered / (self.end - self.start), 0.0))


def warnings(assembly: Assembly, fills: Sequence[Fill]) -> list[str]:
    """Lines on the walls that do not stand by themselves under their fill."""
    lines: dict[str, list[str]] = {}
    for fill in fills:
        for weakest in weakest_of(assembly, fill):
            if _ratio(weakest, fill) < 1.0:
                lines.setdefault(_line(weakest, fill), []).append(f'"{weakest.group}"')
    return [f"{', '.join(named)}: {line}" for line, named in lines.items()]


def weakest_of(assembly: Assembly, fill: Fill) -> list[Weakest]:
    """The weakest bed of each wall next to a fill, by groups; none where nothing presses."""
    number = {name: b for b, name in enumerate(assembly.names)}
    walls: dict[str, list[FillFace]] = {}
    for face in fill.faces if fill.pressure != "none" else ():
        pressed = face.kind == "wall" and face.block in number and face.pressed(fill.level)[0] * math.hypot(*face.area) > 0.0
        if pressed and not assembly.fixed[number[face.block]]:
            walls.setdefault(assembly.groups[assembly.group_of[number[face.block]]], []).append(face)
    borne = {face.block for face in fill.faces}
    carrying = {int(assembly.group_of[number[f.block]]) for f in fill.faces if f.kind in COVERED and f.block in number}
    return [_weakest(group, _stones(faces, borne, assembly, fill), carrying, assembly, fill) for group, faces in walls.items()]


def _stones(faces: Sequence[FillFace], borne: set[str], assembly: Assembly, fill: Fill) -> _Stones:
    """The stones of a wall, and those that stand on it above the road."""
    out = -np.sum([face.area for face in faces], axis=0)
    out /= math.hypot(*out)
    along = np.cross([0.0, 0.0, 1.0], out)
    thrust, moment = np.zeros(assembly.count), np.zeros(assembly.count)  # about z = 0
    walled = {face.block for face in faces}
    blocks = [b for b, name in enumerate(assembly.names) if name in walled]
    number = {assembly.names[b]: b for b in blocks}
    for face in faces:
        depth, place = face.pressed(fill.level)
        size = fill.density * depth * math.hypot(*face.area)
        thrust[number[face.block]] += size
        moment[number[face.block]] += size * place[2]
    corners = {b: assembly.blocks[b].vertices for b in range(assembly.count) if not assembly.fixed[b]}
    toe = max(float((corners[b] @ out).max()) for b in blocks)
    heel = min(float((corners[b] @ out).min()) for b in blocks)
    begin, end = min(float((corners[b] @ along).min()) for b in blocks), max(float((corners[b] @ along).max()) for b in blocks)
    for b, own in corners.items():
        alongside = begin < float((own @ along).max()) and float((own @ along).min()) < end
        on = alongside and float(own[:, 2].min()) >= fill.level - SAME and heel < float(assembly.centre[b] @ out) < toe
        blocks += [b] if on and assembly.names[b] not in borne else []
    return _Stones(
        np.array([(corners[b] @ along).min() for b in blocks]), np.array([(corners[b] @ along).max() for b in blocks]),
        np.array([corners[b][:, 2].min() for b in blocks]), assembly.mass[blocks], toe - assembly.centre[blocks] @ out,
        thrust[blocks], moment[blocks],
    )  # fmt: skip


def _weakest(group: str, stones: _Stones, carrying: set[int], assembly: Assembly, fill: Fill) -> Weakest:
    """The bed with the least ratio, of a wall that stands on groups ``carrying`` the fill."""
    mine = assembly.groups.index(group)
    friction = min(float(assembly.friction[mine, other]) for other in {mine, *carrying})
    found = []
    for bed in np.unique(np.round(stones.bed[stones.thrust > 0.0], 6)):
        own = (np.abs(stones.bed - bed) <= SAME) & (stones.thrust > 0.0)
        share = stones.over(own)
        drives, resists = float(share @ stones.thrust), float(share @ stones.weight)
        turns = float(share @ (stones.moment - stones.thrust * bed))
        ratios = (float(share @ (stones.weight * stones.lever)) / turns, friction * resists / drives)
        found.append((min(ratios), ratios[1] < ratios[0], fill.level - float(bed)))
    ratio, slides, depth = min(found)
    return Weakest(group, ratio, slides, depth)


def _ratio(weakest: Weakest, fill: Fill) -> float:
    return weakest.ratio / fill.coefficients[fill.pressure]


def _line(weakest: Weakest, fill: Fill) -> str:
    """How a wall does not stand, and the key to change."""
    first, last = _ratio(weakest, fill), weakest.ratio / fill.coefficients["active"]
    how = "slides under its fill on" if weakest.slides else "overturns under its fill about the outer edge of"
    if fill.pressure == "at_rest" and last >= 1.0:
        ends = f"what resists is {first:.2g} of the pressure at rest, K_0, but {last:.2g} of K_a, to which it falls as the wall moves"
    else:
        ends = f"what resists is {last:.2g} of the active pressure, K_a"
    thicker = 1.0 / first if weakest.slides else first**-0.5
    table = fill.where.removesuffix(".fill")
    remedy = (
        f"{fill.where}.pressure says how it presses"
        if table == fill.where
        else f"{table}.walls.thickness {thicker:.3g} times as large would do"
    )
    return f"dry and by itself, the wall {how} its bed {weakest.depth:.3g} m below the road: {ends}; {remedy}"
