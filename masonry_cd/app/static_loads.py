# SPDX-License-Identifier: GPL-3.0-or-later
r"""The loads of a scene as a limit analysis takes them: what stays constant, and the pattern that is multiplied by the factor.

Constant are gravity, ties and point loads (:mod:`loads.static`). The pattern is named in ``[limit]``, or is the one load of the scene that
has one. A push lambda |g| d, or a tilt, gravity turned by phi, cos(phi) (g + lambda |g| d) with lambda = tan(phi), acts on the masses of
the blocks, and on those whose weights ``[limit] masses`` names among the point loads. What shakes is left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from loads import fill
from loads.bars import PointLoad, Tie
from loads.motion import LEVEL, Direction, RunGrid, Static, multiplied
from loads.static import NO_STEP, StaticTable, static_tables, ties_of
from masonry_cd.analysis.limit.problem import Arms, Bars, BlockLoads, PointMasses
from masonry_cd.app.limit_table import LimitTable
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import Fill

NO_LOAD = -1  # number of forces that are of no table of [[loads]]
OF_FILL = -2  # likewise, of those that grow with a push


@dataclass(frozen=True, eq=False)
class StaticLoads:
    """Loads on B blocks, and which pattern is multiplied."""

    kind: str  # push, tilt, live or settlement
    words: str
    direction: tuple[float, float, float] | None  # of push and tilt
    gravity: np.ndarray  # (B, 6) of blocks and point masses [N, N m]
    constant: np.ndarray  # (B, 6) of the other point loads [N, N m]
    live: np.ndarray  # (B, 6)
    bars: Bars
    tie_names: tuple[str, ...]  # of the bars; those of one name are one tie
    support_velocity: np.ndarray | None
    arms: Arms  # where the point loads act
    notes: tuple[str, ...]
    masses: PointMasses = field(default_factory=PointMasses.none)  # which a push moves next to the blocks

    @property
    def has_only_gravity(self) -> bool:
        """Return True if gravity alone is constant and nothing but friction resists: a tilt is then a push."""
        return not self.constant.any() and not len(self.bars.strength)

    def at(self, cosine: float = 1.0) -> BlockLoads:
        """The loads of a limit analysis; those of a tilt at the cosine of its angle."""
        turned = cosine if self.kind == "tilt" else 1.0
        return BlockLoads(turned * self.gravity + self.constant, turned * self.live, self.bars, self.support_velocity, self.arms)


def static_loads(
    tables: Sequence[Mapping[str, Any]],
    limit: LimitTable,
    gravity: Sequence[float],
    folder: Path,
    assembly: Assembly,
    made: Sequence[tuple[str, Mapping[str, Any]]] = (),
    fills: Sequence[Fill] = (),
    shaken_by: float = 0.0,
) -> StaticLoads:
    """The loads of a scene's tables ``[[loads]]`` and ``[limit]``, and the ties ``made`` by its structure (see :func:`loads.build`).

    Of ``fills``, those of bridges, the pressures are constant, active where they fall as walls move; their resistance is that of ties. With
    ``shaken_by`` times gravity along a push they grow linearly with it, up to what they are then.

    Raises:
        InputError: no pattern, several, one that needs gravity where there is none, or a bad table.
    """
    down, free, count = np.asarray(gravity, dtype=float), ~assembly.fixed, assembly.count
    grid = RunGrid(NO_STEP, 1, down, folder, assembly, fills=fills)
    every = static_tables(tables, grid)
    _check_numbers(limit, every)
    kind, pattern, at = _pattern(every, limit, grid)
    points = [(i, force) for i, one in enumerate(every) for force in one.does.points if i not in limit.masses]
    masses = _masses([(i, every[i].does.points[0]) for i in limit.masses], pattern.direction, down)
    shake = None if kind != "push" or pattern.direction is None else shaken_by * np.array(pattern.direction.vector)
    filled = [fill.at_collapse(each, grid, pattern.direction is not None, shake) for each in fills]
    pressing = [
        (number, force) for part in filled for number, each in ((NO_LOAD, part.static.points), (OF_FILL, part.live)) for force in each
    ]
    arms = _arms([*points, *pressing], (*limit.live, OF_FILL))
    weight, live, constant = np.zeros((count, 6)), arms.wrenches(arms.live, count), arms.wrenches(arms.dead, count)
    for i, load in points:
        if load.moment is not None:
            (live if i in limit.live else constant)[load.block, 3:] += load.moment
    weight[free, :3] = assembly.mass[free, None] * down
    weight += masses.under(down, count)
    size, way = math.hypot(*down), np.array((0.0, 0.0, 0.0) if pattern.direction is None else pattern.direction.vector)
    live[free, :3] += size * assembly.mass[free, None] * way
    live += masses.under(size * way, count)
    ties = [tie for one in every for tie in one.does.ties] + ties_of(made, grid)
    ties += [tie for part in filled for tie in part.static.ties]
    left = [one.label for i, one in enumerate(every) if one.left_out or (one.does.velocity is not None and i != at)]
    notes = [part.static.words for part in filled if part.static.words]
    notes += [f"{', '.join(left)}: left out, a limit analysis is static"] if left else []
    notes += _without_mass([(i, force) for i, force in points if every[i].does.weighs and i not in limit.live], down) if limit.check else []
    return StaticLoads(
        kind,
        pattern.words,
        None if pattern.direction is None else pattern.direction.vector,
        weight,
        constant,
        live,
        _bars(ties, assembly),
        tuple(tie.name for tie in ties),
        pattern.velocity,
        arms.with_more(Arms(masses.block, masses.arm, masses.mass[:, None] * down, masses.mass[:, None] * size * way)),
        tuple(notes),
        masses,
    )


def live_alone(load: Mapping[str, Any], gravity: Sequence[float], folder: Path, assembly: Assembly, fills: Sequence[Fill]) -> np.ndarray:
    """Return the forces of one table ``[[loads]]`` by itself on B blocks: (B, 6) [N, N m].

    Raises:
        InputError: a bad table.
    """
    (one,) = static_tables([load], RunGrid(NO_STEP, 1, np.asarray(gravity, dtype=float), folder, assembly, fills=fills))
    arms = _arms([(0, force) for force in one.does.points], (0,))
    return arms.wrenches(arms.live, assembly.count)


def _check_numbers(limit: LimitTable, every: Sequence[StaticTable]) -> None:
    """Refuse numbers in limit.live and limit.masses that are of no table with such forces."""
    fitting = {"live": [bool(one.does.points) for one in every], "masses": [one.does.weighs for one in every]}
    for key, fits in fitting.items():
        for i in getattr(limit, key):
            if i >= len(fits) or not fits[i]:
                what = "has forces on blocks" if key == "live" else "is a point load, whose force could be a weight"
                raise InputError(f"limit.{key}", f"loads[{i}]: no load of this scene that {what}")


def _pattern(every: Sequence[StaticTable], limit: LimitTable, grid: RunGrid) -> tuple[str, Static, int]:
    """The kind of the one pattern, what it does, and the number of its table, NO_LOAD of none."""
    if limit.push is not None:
        return "push", multiplied("push", limit.push, grid, "limit.push"), NO_LOAD
    if limit.tilt is not None:
        return "tilt", multiplied("tilt", limit.tilt, grid, "limit.tilt"), NO_LOAD
    if limit.live:
        return "live", Static(f"live loads: {', '.join(every[i].does.words for i in limit.live)}"), NO_LOAD
    there = [i for i, one in enumerate(every) if one.pattern not in ("", "live")]
    if not there:
        raise InputError("limit", 'no load to multiply; give one in [limit], e.g. push = "x", or a load of kind push or tilt')
    if len(there) > 1:
        which = ", ".join(every[i].label for i in there)
        raise InputError("limit", f"{which} are several patterns, a limit analysis takes one; name it in [limit]")
    return every[there[0]].pattern, every[there[0]].does, there[0]


def _masses(points: Sequence[tuple[int, PointLoad]], direction: Direction | None, down: np.ndarray) -> PointMasses:
    """The masses whose weights point loads by number are.

    Raises:
        InputError: one that does not act along gravity, or a pattern that moves no masses.
    """
    if not points:
        return PointMasses.none()
    if direction is None:
        raise InputError("limit.masses", "a push or a tilt moves masses; live loads and supports that move do not")
    for i, load in points:
        turns = load.moment is not None and load.moment.any()
        if float(load.force @ down) < (1.0 - LEVEL) * math.hypot(*load.force) * math.hypot(*down) or not load.force.any() or turns:
            raise InputError(
                "limit.masses", f"loads[{i}] is not a weight: its force {load.force.tolist()} does not act along gravity alone"
            )
    each = [load for _, load in points]
    mass = np.array([math.hypot(*load.force) for load in each]) / math.hypot(*down)
    return PointMasses(np.array([load.block for load in each]), np.array([load.arm for load in each]), mass)


def _without_mass(points: Sequence[tuple[int, PointLoad]], down: np.ndarray) -> list[str]:
    """A line on constant point loads that press downwards and count as forces without mass."""
    some = [i for i, load in points if float(load.force @ down) > 0.5 * math.hypot(*load.force) * math.hypot(*down)]
    if not some:
        return []
    which, verb = ", ".join(f"loads[{i}] (point)" for i in some), "act as forces" if len(some) > 1 else "acts as a force"
    return [f"{which} {verb} without mass, which a push does not move; limit.masses = {some} counts what weighs as P and Q of [C8.7.1.1]"]


def _arms(points: Sequence[tuple[int, PointLoad]], live: Sequence[int]) -> Arms:
    """Where loads by number act, those that are ``live`` and the others."""
    forces = np.array([load.force for _, load in points]).reshape(-1, 3)
    lives = np.array([i in live for i, _ in points], dtype=bool)[:, None]
    block, arm = np.array([load.block for _, load in points], dtype=np.int64), np.array([load.arm for _, load in points]).reshape(-1, 3)
    return Arms(block, arm, np.where(lives, 0.0, forces), np.where(lives, forces, 0.0))


def _bars(ties: Sequence[Tie], assembly: Assembly) -> Bars:
    """The ties, each with the force at which it yields."""
    if not ties:
        return Bars.none()
    blocks = np.array([tie.blocks for tie in ties])
    return Bars(blocks, assembly.centre[blocks] + np.array([tie.arms for tie in ties]), np.array([tie.limit for tie in ties]))
