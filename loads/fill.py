# SPDX-License-Identifier: GPL-3.0-or-later
r"""Action of the fill of a bridge on blocks in addition to its weight, which rides on them (:mod:`masonry_cd.mechanics.model.fill`).

**Pressure.** On a wall, and on the back of an abutment of blocks, K gamma (depth) at right angles to the face: as built K_0 = 1 - sin(phi)
(Jaky 1944) or, where requested, Rankine's K_a. With D the depth of the lower edge of a face, and u by how far it has moved away,

    K = (K_0 - K_a) (1 - u / (a D)) + K_a (1 - u / (g D)),        each bracket 0 at least and 1 at most,

where a (``active_at``) is the movement at which soil is active, and g (``gone_at``) that at which the fill has run out: derived in
:meth:`masonry_cd.mechanics.model.fill.Fill.reach`. Each bracket is the law of a bar (:mod:`loads.bars`) that pulls the wall outwards, with
its thrust as built as first tension and yield force: it slackens on the way out, and gives no more than it has stored. Its far end is on
the block that carries the fill there, an arch or a pier, which so bears the reaction and takes the fill along; beyond the arches, on the
support nearest to it. At collapse, in limit analysis, what is pressed is on the point of moving away: K_a, a constant force. Under a push
of a factor lambda along d the fill is shaken as well: K_AE(lambda d . f) of Mononobe and Okabe for a face pressed along f
(:meth:`masonry_cd.mechanics.model.fill.Fill.shaken`), of which K_AE - K_a is multiplied as the push is, by its secant, and K_PE in place
of K_p.

**Passive resistance.** An extrados, or the back of an abutment, that moves into the fill meets along the level part of its normal

    P = m K_p gamma integral(depth |dA_level|),        K_p = (1 + sin phi) / (1 - sin phi),

of which a back that is pressed meets K before it moves. Here m is the share that is mobilised at most: by default a third, and under loads
that shake or push a share of its own, by default 0.3. Both are assumptions of this program. P grows linearly with the displacement, is
capped, and is none where the face moves away: the law of a bar that pulls, never pushes, and yields. So each such face has a bar that pulls
it out of the fill, FAR long so that its direction stays, whose other end is the support nearest to it: the fill far away moves with the
ground. In limit analysis the bar adds P times the rate at which its face moves into the fill to the work. The bars' energy is accounted as
that of ties.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from loads.bar_frequency import bar_of
from loads.bars import PointLoad, Tie
from loads.motion import LoadAction, RunGrid, Static
from masonry_cd.foundation.quantities import force
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import BARS, Fill, FillFace

FAR = 1000.0  # length of the bars [m]: a face that rises by 0.3 m stretches one by 45 um
FARTHER = 1e5  # of those that press [m]: a stone that falls by 10 m stretches one by 0.5 mm
DAMPING = 0.05  # of the bars, share of the critical damping
ADJACENT = 1e-3  # [m]: a wall farther than this from what carries the fill stands beyond it
LEAST = 1e-6  # of the largest resistance of a face: faces that are all but level have none


class FillPressure(NamedTuple):
    """Pressure of the fill on a face with K = 1."""

    face: FillFace
    block: int
    place: np.ndarray  # (3,) of the resultant, as built [m]
    force: np.ndarray  # (3,) on the block [N]


def part(fill: Fill, grid: RunGrid, shaken: bool) -> LoadAction:
    """Return the action of a fill in a run: bars that press, and bars that resist."""
    assembly = grid.blocks(fill.where)
    pressed, carriers = _thrusts(fill, assembly, math.hypot(*grid.gravity)), _carriers(fill, assembly)
    pressing = [bar for thrust in pressed for bar in _slackening(fill, thrust, carriers, assembly)]
    bars = _passive(fill, grid, shaken, fill.coefficients[fill.pressure])
    total, most = sum(bar.tension for bar in pressing), sum(bar.limit for bar in bars)
    lines = [f"{fill.where}: {force(total)} press on walls and backs, {_in_words(fill)}"] if pressing else []
    if bars:
        why = " (loads shake or push)" if shaken else ""
        share = _share(fill, shaken)
        lines.append(f"{fill.where}: {len(bars)} faces that move into the fill meet at most {share:.3g} K_p{why}, {force(most)} in all")
    summary = {"kind": "fill", "pressure": total, "passive_share": _share(fill, shaken), "passive_most": most, "shaken": shaken}
    falling = {"active_at": fill.active_at, "gone_at": fill.reach} if pressing else {}
    return LoadAction(forces=(*pressing, *bars), lines=tuple(lines), summary=summary | falling)


def beyond(fill: Fill, velocity: np.ndarray, grid: RunGrid) -> str:
    """Return a warning where the fill, shaken as its supports are, would press more than the run has it press; else nothing.

    Args:
        velocity: (N + 1, S, 3) of the supports [m/s].
    """
    assembly, k = grid.blocks(fill.where), fill.coefficients[fill.pressure]
    level, gravity = np.diff(velocity[..., :2], axis=0) / grid.dt, math.hypot(*grid.gravity)
    if not _thrusts(fill, assembly, gravity):
        return ""
    size = float(np.sqrt((level**2).sum(axis=-1)).max(initial=0.0)) / gravity
    active = fill.shaken(size)[0]
    if active <= k:
        return ""
    return (
        f"{fill.where}: shaken by up to {size:.3g} g the fill presses walls and backs with K_AE = {active:.3g} (Mononobe and Okabe), "
        f"but the run applies at most K = {k:.3g}; check the walls in limit analysis with limit.push, which has K_AE"
    )


class AtCollapse(NamedTuple):
    """The action of a fill as a mechanism begins to move."""

    static: Static  # pressure as constant forces, bars that resist, a line on both
    live: tuple[PointLoad, ...]  # what is multiplied by the factor of a push


def at_collapse(fill: Fill, grid: RunGrid, shaken: bool, push: np.ndarray | None = None) -> AtCollapse:
    """Return the action of a fill as a mechanism begins to move, ``push`` (3,) being the acceleration over gravity that shakes it."""
    assembly = grid.blocks(fill.where)
    k = fill.coefficients["active" if fill.pressure == "at_rest" else fill.pressure]
    pressed = _thrusts(fill, assembly, math.hypot(*grid.gravity)) if k > 0.0 else []
    shake = np.zeros(3) if push is None else push
    size = math.hypot(*shake)

    def loads(shares: Sequence[float]) -> tuple[PointLoad, ...]:
        once, centre = np.ones(len(grid.times)), assembly.centre
        each = zip(pressed, shares, strict=True)
        return tuple(PointLoad(one.block, one.place - centre[one.block], share * one.force, once) for one, share in each)

    more = [(fill.shaken(_along(one.force, shake))[0] - k) / size for one in pressed] if size else []
    words = f"{fill.where}: walls and backs, on the point of moving away, are pressed by K_a = {k:.3g}" if pressed else ""
    resists = tuple(_passive(fill, grid, shaken, k, shake))
    if size and (pressed or resists):
        active, passive = fill.shaken(size)
        ends = f"; above {fill.slides_at:.3g} it slides by itself, and they are those there" if size > fill.slides_at else ""
        by = f"shaken by {size:.3g} g, by Mononobe and Okabe: K_AE = {active:.3g}, K_PE = {passive:.3g}{ends}"
        words = f"{words}; {by}" if words else f"{fill.where}: {by}"
    return AtCollapse(Static(words, loads([k] * len(pressed)), resists), loads(more) if size else ())


def _along(force: np.ndarray, shake: np.ndarray) -> float:
    """The part of a shaking (3,) along the level direction of a force (3,)."""
    level = math.hypot(*force[:2])
    return float(np.sum(force[:2] * shake[:2])) / level if level > 0.0 else 0.0


def _in_words(fill: Fill) -> str:
    """The law of the pressure, which is an assumption of a run."""
    k, goes = fill.coefficients, f"nothing {fill.reach:.3g} of the depth of its lower edge"
    if fill.pressure == "active":
        return f"K_a = {k['active']:.3g}, which falls as a face moves away, to {goes} on"
    return (
        f"K_0 = {k['at_rest']:.3g}, which falls as a face moves away: to K_a = {k['active']:.3g} within {fill.active_at:.3g}, to {goes} on"
    )


def _share(fill: Fill, shaken: bool) -> float:
    return fill.passive_shaken if shaken else fill.passive


def _thrusts(fill: Fill, assembly: Assembly, gravity: float) -> list[FillPressure]:
    """On walls and backs that may move, none where nothing presses."""
    found, number = list[FillPressure](), _numbers(assembly)
    for face in fill.faces if fill.coefficients[fill.pressure] * gravity > 0.0 else ():
        if face.kind in ("wall", "back") and not _is_fixed(face, assembly, number):
            depth, place = face.pressed(fill.level)
            found.append(FillPressure(face, number[face.block], place, -fill.density * gravity * depth * face.area))
    return found


def _slackening(fill: Fill, thrust: FillPressure, carriers: _Carriers, assembly: Assembly) -> list[Tie]:
    """The bars of one face: what K_0 has over K_a, and K_a."""
    size, deepest = math.hypot(*thrust.force), fill.level - float(thrust.face.corners[:, 2].min())
    if not size * deepest > 0.0:
        return []
    k = fill.coefficients
    shares = [(k["at_rest"] - k["active"], fill.active_at)] if fill.pressure == "at_rest" else []
    ends = (thrust.block, _bearer(fill, thrust, carriers, assembly))
    points = np.stack([thrust.place, thrust.place + FARTHER * thrust.force / size])
    name = f"{BARS}{thrust.face.block}, pressure"
    pulls = [(share * size, share * size / (over * deepest)) for share, over in (*shares, (k["active"], fill.reach)) if share > 0.0]
    made = [(pull, bar_of(assembly, ends, points, stiffness, pull, DAMPING, name)) for pull, stiffness in pulls]
    return [replace(bar, tension=pull, from_start=True) for pull, bar in made]


class _Carriers(NamedTuple):
    """The F faces on which the fill lies, along the springings."""

    block: np.ndarray  # (F,)
    low: np.ndarray  # (F,) where they begin and end along the road [m]
    high: np.ndarray
    across: np.ndarray  # (F,) their middles across it [m]


def _carriers(fill: Fill, assembly: Assembly) -> _Carriers:
    number = _numbers(assembly)
    under = [face for face in fill.faces if face.kind in ("extrados", "top") and face.block in number]
    own = [_over_feet(fill, face.corners) for face in under]
    ends = np.array([(c[:, 0].min(), c[:, 0].max(), c[:, 1].mean()) for c in own]).reshape(-1, 3)
    return _Carriers(np.array([number[face.block] for face in under], dtype=np.int64), *ends.T)


def _bearer(fill: Fill, thrust: FillPressure, carriers: _Carriers, assembly: Assembly) -> int:
    """The block that carries the fill at the same place along the road; of the fill beyond the arches the nearest support."""
    ((along, across),) = _over_feet(fill, thrust.place[None])
    adjacent = (carriers.low - ADJACENT <= along) & (along <= carriers.high + ADJACENT) & (carriers.block != thrust.block)
    if thrust.face.kind == "wall" and adjacent.any():
        return int(carriers.block[np.argmin(np.where(adjacent, np.abs(carriers.across - across), np.inf))])
    return _nearest_support(assembly, thrust.place)


def _over_feet(fill: Fill, points: np.ndarray) -> np.ndarray:
    """Coordinates along the road where a line along the springings meets its middle, and across it, (n, 2) [m]."""
    own = fill.along(points)
    return np.stack([own[:, 0] - fill.slant * own[:, 1], own[:, 1]], axis=1)


def _passive(fill: Fill, grid: RunGrid, shaken: bool, pressed: float, shake: np.ndarray | None = None) -> list[Tie]:
    """The bars of the faces that may move into the fill, one to a face; backs are ``pressed`` already by so much of gamma times depth.

    ``shake`` (3,) is the acceleration over gravity that shakes it.
    """
    assembly = grid.blocks(fill.where)
    number = _numbers(assembly)
    gamma, share = fill.density * math.hypot(*grid.gravity), _share(fill, shaken)
    some = [face for face in fill.faces if face.kind in ("extrados", "back") and not _is_fixed(face, assembly, number)]
    every = [(face, *_resistance(face, fill)) for face in some]
    most = max((size for _, size, _, _ in every), default=0.0)
    found = []
    for face, size, place, way in every:
        along = 0.0 if shake is None else _along(way, shake)
        most_k = share * (fill.shaken(along)[1] if along > 0.0 else fill.coefficients["passive"])
        rate = gamma * (most_k if face.kind == "extrados" else max(0.0, most_k - pressed))
        if rate <= 0.0 or size <= LEAST * most:
            continue
        ends = (number[face.block], _nearest_support(assembly, place))
        stiffness = rate * size / fill.mobilised_at
        points = np.stack([place, place - FAR * way])
        name = f"{BARS}{face.block.split('.')[0]}, {'left' if way[0] < 0.0 else 'right'}"
        found.append(bar_of(assembly, ends, points, stiffness, rate * size, DAMPING, name))
    return found


def _nearest_support(assembly: Assembly, place: np.ndarray) -> int:
    supports = np.flatnonzero(assembly.fixed)
    return int(supports[int(np.argmin(np.abs(assembly.centre[supports] - place).max(axis=1)))])


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
