# SPDX-License-Identifier: GPL-3.0-or-later
"""A force on a single block, which keeps its direction and acts at a point that moves with its block, or a moment.

It is there at once, grows over ``ramp``, or goes through stages, shares of it that are reached one after the other over ``ramp`` each and
last for ``hold``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import model_validator

from loads.acted import Acted, share_of
from loads.bars import PointLoad
from loads.motion import LoadAction, LoadKind, LoadTable, RunGrid, Static, lifts
from loads.supports import one_block
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Instant, Numbers, Vector
from masonry_cd.foundation.quantities import force
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.place_on_block import require_on_block
from masonry_cd.mechanics.model.usual import FORCES

FORCE = (
    Usual(0.05, math.inf, "a force below a twentieth of its block's weight changes little", FORCES, "weight of its block", size=True),
    Usual(0.0, 3e7, "few masonries bear 30 MPa", over="section of its block", size=True),
    Usual(0.0, 200.0, "even proof loads are a few tens of times the weight of what bears them", over="weight of all blocks", size=True),
)


class PointLoadTable(LoadTable):
    """Keys of ``kind = "point"``."""

    kind: Literal["point"] = "point"
    block: str
    """Its name."""
    force: Annotated[Vector, Unit("N"), *FORCE] = (0.0, 0.0, 0.0)
    """A vector; none where there is a moment alone."""
    moment: Annotated[Vector | None, Unit("N m")] = None
    """A vector in the world axes, which keeps its direction, in addition to that of the force about the centre of mass."""
    point: Annotated[Vector | None, Unit("m")] = None
    """Point of attack, as built, in the world; the centre of mass when not given."""
    start: Instant = 0.0
    """When the force begins."""
    ramp: Instant = 0.0
    """Time in which it grows linearly; with stages from each to the next."""
    stages: Numbers | None = None
    """Shares of the force that are reached one after the other, 1 being all of it, e.g. [0.5, 1, 0, 1.5]."""
    hold: Instant = 0.0
    """Time for which each stage but the last is held."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if "force" not in self.model_fields_set and self.moment is None:
            raise ValueError("force: missing; a force, a moment or both act on the block")
        if self.point is not None and not any(self.force):
            raise ValueError("point: needs a force: a moment has no point of attack")
        if self.hold and not self.stages:
            raise ValueError("hold: needs stages")
        if self.stages is not None and not any(self.stages):
            raise ValueError("stages: none is away from 0")
        if len(self.stages or ()) > 1 and not self.ramp + self.hold > 0.0:
            raise ValueError("stages: ramp and hold are 0, so that all of them would be at one time")
        return self

    @property
    def end(self) -> float:
        """When the last stage is reached [s]."""
        count = len(self.stages or (1.0,))
        return self.start + count * self.ramp + (count - 1) * self.hold

    def factor(self, times: np.ndarray) -> np.ndarray:
        """The share of the force at times (n,) [s]."""
        changes = np.diff([0.0, *(self.stages or (1.0,))])
        return np.asarray(sum(change * done for change, done in zip(changes, self._stages_at(times), strict=True)))

    def reached(self, time: float) -> float:
        """The share of all its changes, up and down, that has been made at a time [s]."""
        changes = np.abs(np.diff([0.0, *(self.stages or (1.0,))]))
        made = [float(done[0]) for done in self._stages_at(np.array([time]))]
        return share_of(float(np.sum(changes * made)), float(changes.sum()))

    def _stages_at(self, times: np.ndarray) -> list[np.ndarray]:
        """How far each stage has been reached at times (n,) [s], 0 to 1."""
        found, since = list[np.ndarray](), times - self.start
        for _ in self.stages or (1.0,):
            found.append(np.clip(since / self.ramp, 0.0, 1.0) if self.ramp > 0.0 else (since >= 0.0).astype(float))
            since = since - self.ramp - self.hold
        return found


def point(table: PointLoadTable, grid: RunGrid, where: str) -> LoadAction:
    """A point load.

    Raises:
        InputError: see :func:`_load`.
    """
    load, assembly = _load(table, grid, where), grid.blocks(where)
    size, weight = math.hypot(*load.force), assembly.mass[load.block] * math.hypot(*grid.gravity)
    relation = f", {size / weight:.3g} times its weight" if weight > 0.0 and size else ""
    turns = f"{math.hypot(*load.moment):.4g} N m" if load.moment is not None else ""
    acts = " and ".join(part for part in (force(size) if size or not turns else "", turns) if part)
    stages = f", in {len(table.stages)} stages up to {table.end:.4g} s" if table.stages else ""
    return LoadAction(
        forces=(load,),
        lines=(f'{where} point load of {acts} on "{table.block}"{relation}{stages}',),
        acted=Acted(where, "force", table.end, table.reached),
        summary=table.facts(
            "block", "force", "point", "start", "ramp", *(("stages", "hold") if table.stages else ()), *(("moment",) if turns else ())
        ),
    )


def _load(table: PointLoadTable, grid: RunGrid, where: str) -> PointLoad:
    """The force on its block.

    Raises:
        InputError: an unknown block, a support, or a point off the block.
    """
    assembly = grid.blocks(where)
    block = one_block(table.block, assembly, f"{where}.block")
    if assembly.fixed[block]:
        raise InputError(f"{where}.block", f'"{table.block}" is fixed, a force cannot move it')
    if table.point is not None:
        require_on_block(assembly.blocks[block], table.point, f"{where}.point")
    arm = np.zeros(3) if table.point is None else np.array(table.point) - assembly.centre[block]
    moment = None if table.moment is None else np.array(table.moment)
    return PointLoad(block, arm, np.array(table.force), table.factor(grid.times), moment)


def _senses(table: PointLoadTable, down: np.ndarray, where: str) -> Iterator[tuple[str, str]]:
    if lifts(table.force, down):
        yield f"{where}.force", f"{where}.force = {list(table.force)} N lifts its block: weights act along -z"


KINDS = {
    "point": LoadKind(
        PointLoadTable,
        point,
        static=lambda table, grid, where: Static(where, (_load(table, grid, where),), weighs=True),
        gentle=True,
        senses=_senses,
        starter={"block": "v14", "force": [0.0, 0.0, -5e3], "ramp": 0.5},
    )
}
