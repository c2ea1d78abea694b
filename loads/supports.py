# SPDX-License-Identifier: GPL-3.0-or-later
r"""Which supports move, and when: names of blocks and groups, and the delay of a motion that travels along the structure.

A long structure is not shaken everywhere at once. A wave of apparent speed c along the unit direction d reaches a support at x after

    tau = d . (x - x_first) / c,       v(x, t) = v(t - tau),

x_first being the support it meets first (the simplest of the spatial models of EN 1998-2, annex D: wave passage without loss of
coherence or change of site). Delays may also be given by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, WithJsonSchema, model_validator

from loads.motion import DirectionKey, LoadTable, RunGrid, strict
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import Instant
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Assembly

NEAR = 1e-6  # of the largest extent of a block: boxes closer than this meet


def _names(value: object) -> tuple[str, ...] | None:
    """One name or a list of names."""
    names = [value] if isinstance(value, str) else value
    if names is None:
        return None
    if not isinstance(names, (list, tuple)) or not names or not all(isinstance(name, str) for name in names):
        raise ValueError("must be the name of a fixed block or a group, or a list of names")
    return tuple(names)


_SCHEMA: dict[str, Any] = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]}
Names = Annotated[tuple[str, ...] | None, BeforeValidator(_names), WithJsonSchema(_SCHEMA)]
NeededNames = Annotated[tuple[str, ...], BeforeValidator(_names), WithJsonSchema(_SCHEMA)]


class Delay(BaseModel):
    """The key ``delay``: either direction and speed, or seconds by names of supports or groups."""

    model_config = strict

    direction: DirectionKey | None = None
    """Direction in which the motion travels."""
    speed: Annotated[float, Unit("m/s"), Field(gt=0.0)] | None = None
    """Apparent, along the direction."""
    seconds: dict[str, Instant] | None = None
    """Lag by names of supports or groups; 0 for those not named."""

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        travels = self.direction is not None and self.speed is not None
        if travels == (self.seconds is not None) or (self.direction is None) != (self.speed is None):
            raise ValueError("give direction and speed, or seconds by names of supports")
        return self

    def of_blocks(self, grid: RunGrid, where: str) -> np.ndarray:
        """The delay at each block (B,), which only counts for supports [s]."""
        assembly = structure(grid, f"{where}.delay")
        if self.direction is not None and self.speed is not None:
            along = np.sum(assembly.centre * self.direction.vector, axis=1)
            return np.where(assembly.fixed, (along - along[assembly.fixed].min()) / self.speed, 0.0)
        out = np.zeros(assembly.count)
        for name, seconds in (self.seconds or {}).items():
            out[select_supports([name], grid, f"{where}.delay.seconds")] = seconds
        return out


class ShakingTable(LoadTable):
    """Common keys of all loads that move the base to and fro."""

    start: Instant = 0.0
    """Time of the run at which the motion begins."""
    delay: Delay | None = None
    """Lag from support to support; all move together when not given."""

    def delay_of_blocks(self, grid: RunGrid, where: str) -> np.ndarray | None:
        """(B,) [s], or None where all supports move together."""
        return None if self.delay is None else self.delay.of_blocks(grid, where)

    def latest(self, grid: RunGrid, where: str) -> float:
        """The largest lag [s]."""
        delay = self.delay_of_blocks(grid, where)
        return 0.0 if delay is None else float(delay.max())


def structure(grid: RunGrid, where: str) -> Assembly:
    """The blocks that the run is about.

    Raises:
        InputError: there is none, or no support among its blocks.
    """
    assembly = grid.blocks(where)
    if not assembly.fixed.any():
        raise InputError(where, "no block of the structure is fixed")
    return assembly


def select(names: Sequence[str], assembly: Assembly, where: str) -> np.ndarray:
    """Mask (B,) of the blocks named: each name is a block, a group, a stone that is in pieces, or a pattern with ``*``.

    Raises:
        InputError: a name that fits nothing.
    """
    mask = np.zeros(assembly.count, dtype=bool)
    groups = np.array(assembly.groups)[assembly.group_of]
    stones = [block.stone for block in assembly.blocks]
    for name in names:
        of_any = zip(assembly.names, groups, stones, strict=True)
        of_either = (any(fnmatchcase(one, name) for one in each) for each in of_any)
        found = np.fromiter(of_either, dtype=bool, count=assembly.count)
        if not found.any():
            known = [*assembly.groups, *assembly.names]
            raise InputError(where, f'"{name}" is not a block or group{suggest(name, known)}; groups: {", ".join(assembly.groups)}')
        mask |= found
    return mask


def one_block(name: str, assembly: Assembly, where: str) -> int:
    """The index of the one block of a name or pattern."""
    if name in assembly.names:
        return assembly.names.index(name)
    found = np.flatnonzero(select([name], assembly, where))
    if len(found) > 1:
        some = ", ".join(assembly.names[b] for b in found[:4])
        raise InputError(where, f'"{name}" names {len(found)} blocks ({some} ...), one is needed')
    return int(found[0])


def select_supports(names: Sequence[str] | None, grid: RunGrid, where: str) -> np.ndarray:
    """Mask (B,) of the supports named, see :func:`select`, and of those below footings named; of all supports when names is None.

    Raises:
        InputError: a name that fits no block, or none that is fixed.
    """
    assembly = structure(grid, where)
    if names is None:
        return assembly.fixed.copy()
    mask = np.zeros(assembly.count, dtype=bool)
    for name in names:
        found = select([name], assembly, where)
        found = (found if assembly.footings is None else assembly.footings.of_blocks(found)) & assembly.fixed
        if not found.any():
            fixed = [assembly.names[b] for b in np.flatnonzero(assembly.fixed)]
            some = ", ".join(fixed[:8]) + (" ..." if len(fixed) > 8 else "")
            raise InputError(where, f'"{name}" is not fixed; supports: {some}')
        mask |= found
    return mask


def bearing(assembly: Assembly) -> np.ndarray:
    """(B,) bool: supports whose box meets that of a free block; all supports where none does."""
    low, high = (np.array([getattr(block.vertices, end)(axis=0) for block in assembly.blocks]) for end in ("min", "max"))
    near = NEAR * float((high - low).max())
    free, fixed = ~assembly.fixed, np.flatnonzero(assembly.fixed)
    meets = [bool(((low[free] <= high[s] + near) & (high[free] >= low[s] - near)).all(axis=1).any()) for s in fixed]
    out = np.zeros(len(low), dtype=bool)
    out[fixed] = meets if any(meets) else True
    return out
