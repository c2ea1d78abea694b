# SPDX-License-Identifier: GPL-3.0-or-later
"""A tie: a bar between a point of one block and a point of another, that pulls and never pushes, and yields at a given force if it has one.

Its law, and how it acts in the step, are in :mod:`loads.bars`; how stiff a bar may be, in :mod:`loads.bar_frequency`.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from loads.bar_frequency import check_phase, felt_mass
from loads.bars import Tie
from loads.motion import LoadAction, LoadKind, LoadTable, Positive, RunGrid, Static
from loads.supports import one_block
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Flag, Vector, check_tension, two_blocks
from masonry_cd.foundation.quantities import force, stiffness
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.place_on_block import require_on_block
from masonry_cd.mechanics.model.usual import DIAMETER, SECTION, TENSION, TIE_MODULUS, YIELDING

LONGEST_TIE = 1e6  # [m]
SOFTEST, STIFFEST = 1e-9, 1e18  # [N/m]


def _ends(value: object) -> object:
    """Say what is expected of two points before pydantic speaks of tuples."""
    if value is not None and (not isinstance(value, (list, tuple)) or len(value) != 2):
        raise ValueError("must be two points, e.g. [[0, 0, 3], [4, 0, 3]]")
    return value if value is None else tuple(value)


class TieTable(LoadTable):
    """Keys of ``kind = "tie"``."""

    kind: Literal["tie"] = "tie"
    blocks: Annotated[tuple[str, str], BeforeValidator(two_blocks)]
    """Names of the two blocks."""
    points: Annotated[tuple[Vector, Vector] | None, Unit("m"), BeforeValidator(_ends)] = None
    """Its two end points as built; the centres of mass when not given."""
    diameter: Annotated[Positive, Unit("m"), DIAMETER] | None = None
    """Diameter of its section."""
    area: Annotated[Positive, Unit("m2"), SECTION] | None = None
    """Area of its section, instead of a diameter."""
    modulus: Annotated[Positive, Unit("Pa"), TIE_MODULUS] = 2.1e11
    """Young's modulus, by default that of steel."""
    tension: Annotated[float, Unit("N"), TENSION, Field(ge=0.0)] = 0.0
    """At the start."""
    yield_force: Annotated[Positive, Unit("N"), YIELDING] | None = None
    """At which it yields: beyond, it stretches for good and pulls no more than this; it never yields when not given."""
    from_start: Flag = False
    """Stretch the tie while elastic joints take up the weight; otherwise it keeps its tension meanwhile, as under a jack."""
    name: str | None = None
    """Name in reports; the names of its blocks when not given."""
    damping: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.02
    """Share of the critical damping."""

    @model_validator(mode="after")
    def _one_section(self) -> Self:
        if (self.diameter is None) == (self.area is None):
            raise ValueError("give exactly one of diameter and area")
        check_tension(self.tension, self.yield_force)
        return self

    @property
    def section(self) -> float:
        """A [m2]."""
        return self.area if self.area is not None else 0.25 * np.pi * (self.diameter or 0.0) ** 2


def tie(table: TieTable, grid: RunGrid, where: str) -> LoadAction:
    """A tie whose ends lie on its blocks.

    Raises:
        InputError: an end off its block; see :func:`bar`.
    """
    made = _on_blocks(table, grid, where)
    yields = "" if table.yield_force is None else f", yields at {force(made.limit)}"
    about = f"{made.length:.4g} m, {stiffness(made.stiffness)}, tension {force(table.tension)}{yields}"
    return LoadAction(
        forces=(made,),
        lines=(f'{where} tie from "{table.blocks[0]}" to "{table.blocks[1]}": {about}',),
        summary=table.facts("blocks", "section", "tension", "yield_force") | {"length": made.length, "stiffness": made.stiffness},
    )


def _on_blocks(table: TieTable, grid: RunGrid, where: str) -> Tie:
    made = bar(table, grid, where)
    for end, (block, place) in enumerate(zip(made.blocks, table.points or (), strict=False)):
        require_on_block(grid.blocks(where).blocks[block], place, f"{where}.points[{end}]")
    return made


def bar(table: TieTable, grid: RunGrid, where: str) -> Tie:
    """A tie from anywhere: those that a structure makes of a plate end at the mean of what it covers, which a block may go round.

    Raises:
        InputError: unknown blocks, two supports, ends at one point, or a bar too stiff for the time step.
    """
    assembly = grid.blocks(where)
    ends = (one_block(table.blocks[0], assembly, f"{where}.blocks"), one_block(table.blocks[1], assembly, f"{where}.blocks"))
    if assembly.fixed[list(ends)].all():
        raise InputError(f"{where}.blocks", "both are fixed, a tie between them does nothing")
    centres = assembly.centre[list(ends)]
    points = centres if table.points is None else np.array(table.points)
    length = math.hypot(*(points[1] - points[0]))
    if length == 0.0:
        raise InputError(f"{where}.points", "both ends are at one point")
    if not length <= LONGEST_TIE:
        raise InputError(f"{where}.points", f"the ends are {length:.3g} m apart, at most {LONGEST_TIE:g} m are allowed")
    along = table.modulus * table.section / length
    if not SOFTEST <= along <= STIFFEST:
        raise InputError(
            where, f"its modulus and section make {stiffness(along)}, {stiffness(SOFTEST)} to {stiffness(STIFFEST)} are allowed"
        )
    omega = float(np.sqrt(along / felt_mass(assembly, ends, points)))
    check_phase(omega, table.damping, grid, f"{where}, a bar of {table.section:.3g} m2 between these blocks")
    damping = 2.0 * table.damping * along / omega  # 2 xi sqrt(k m_e)
    limit = math.inf if table.yield_force is None else table.yield_force
    name, early = table.name or "", table.from_start
    return Tie(ends, points - centres, length, table.section, along, table.tension, damping, limit, name, early)


KINDS = {
    "tie": LoadKind(
        TieTable,
        tie,
        slow=lambda table: True,
        static=lambda table, grid, where: Static(where, ties=(_on_blocks(table, grid, where),)),
        gentle=True,
        starter={"blocks": ["v1", "v27"], "diameter": 0.02},
    )
}
