# SPDX-License-Identifier: GPL-3.0-or-later
"""Which blocks of a file are supports: by name, by group, by place, or those that touch the ground.

    fixed = "ground"                                          blocks that reach down to the lowest level of the structure
    fixed = ["plinth*", "abutment?"]                          by name; * and ? stand for anything
    fixed = { below = 0.1 }                                   whose centre lies below a height [m]
    fixed = { box = [[-1, -1, 0], [1, 1, 0.3]] }              whose centre lies in a box [m]
    fixed = [{ group = "base*" }, { name = "pier_*" }]        several, any of which is enough

The centre is that of the box around a block, and heights are those of the structure with z up, in metres, whatever the file's unit and
axis. A block of a mesh that becomes a support is put into the group ``base``; blocks of a block file keep theirs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema, model_validator

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.table_schema import table_schema
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from structures.schema import Table

GROUND = "ground"
LEVEL = 1e-3  # of the height of the structure: feet of a scan this near to the lowest stand on the ground, too
HOW = (
    'structure.fixed = "ground" fixes those that touch the ground, { below = 0.1 } those with their centre below 0.1 m, '
    '{ box = [[x, y, z], [x, y, z]] } those with it in a box, ["plinth*"] and { group = "base*" } those of a name or group'
)  # what a message on missing supports ends with

Coordinate = Annotated[float, Unit("m"), Field(allow_inf_nan=False)]
Corner = Annotated[tuple[Coordinate, Coordinate, Coordinate], Field(strict=False)]


class SupportRule(Table):
    """One rule: what a block has to fulfil, all of what is given."""

    below: Annotated[float, Unit("m"), Field(allow_inf_nan=False)] | None = None
    """height under which its centre lies"""
    box: Annotated[tuple[Corner, Corner], Field(strict=False)] | None = None
    """two corners of a box in which its centre lies"""
    group: str | None = None
    """group of the block; * stands for anything"""
    name: str | None = None
    """name of the block; * stands for anything"""

    @model_validator(mode="after")
    def _something(self) -> Self:
        if not self.model_fields_set:
            raise ValueError("must have one of below, box, group and name")
        if self.box is not None and any(low > high for low, high in zip(*self.box, strict=True)):
            raise ValueError(f"box: must be [lowest corner, highest corner], got {[list(corner) for corner in self.box]}")
        return self

    @property
    def words(self) -> str:
        """The rule as it is written."""
        return ", ".join(f"{key} = {getattr(self, key)}" for key in ("below", "box", "group", "name") if getattr(self, key) is not None)


def _listed(value: object) -> tuple[Any, ...]:
    """A rule alone is a list of one."""
    if isinstance(value, (str, dict)):
        return (value,)
    if isinstance(value, (list, tuple)) and all(isinstance(rule, (str, dict)) for rule in value):
        return tuple(value)
    raise ValueError("must be a name, a table of below, box, group or name, or a list of them")


_RULE: dict[str, Any] = {"anyOf": [{"type": "string"}, table_schema(SupportRule)]}
Rules = Annotated[
    tuple[Any, ...], BeforeValidator(_listed), WithJsonSchema({"anyOf": [*_RULE["anyOf"], {"type": "array", "items": _RULE}]})
]


class Supports(BaseModel):
    """The key by itself."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    fixed: Rules = ()


def with_supports(blocks: Sequence[Block], rules: Sequence[str | Mapping[str, Any]], where: str, group: str | None = "base") -> list[Block]:
    """Fix the blocks that fulfil one of some rules.

    Args:
        blocks: of the structure [m].
        rules: a pattern of names, ``ground``, or a place.
        where: the key in messages.
        group: into which they are put; None leaves them in theirs.

    Raises:
        InputError: a rule that is none, or that no block fulfils.
    """
    chosen = np.zeros(len(blocks), dtype=bool)
    for i, given in enumerate(rules):
        rule = given if isinstance(given, str) else parse_table(SupportRule, given, where if len(rules) == 1 else f"{where}[{i}]")
        found = _of_rule(blocks, rule)
        if not found.any():
            raise InputError(where, f"{_none(blocks, rule)}")
        chosen |= found
    return [replace(block, fixed=True, group=group or block.group) if ours else block for block, ours in zip(blocks, chosen, strict=True)]


def _of_rule(blocks: Sequence[Block], rule: str | SupportRule) -> np.ndarray:
    """(B,) True for the blocks that fulfil a rule."""
    if isinstance(rule, str):
        named = np.array([fnmatchcase(block.name, rule) for block in blocks], dtype=bool)
        return _on_ground(blocks) if rule == GROUND and not named.any() else named
    found = np.ones(len(blocks), dtype=bool)
    if rule.below is not None or rule.box is not None:
        centre = np.array([_centre(block) for block in blocks])
        found &= centre[:, 2] < (np.inf if rule.below is None else rule.below)
        if rule.box is not None:
            low, high = np.array(rule.box)
            found &= ((centre >= low) & (centre <= high)).all(axis=1)
    for pattern, words in ((rule.group, [b.group for b in blocks]), (rule.name, [b.name for b in blocks])):
        if pattern is not None:
            found &= np.array([fnmatchcase(word, pattern) for word in words], dtype=bool)
    return found


def _on_ground(blocks: Sequence[Block]) -> np.ndarray:
    """(B,) True for the blocks that reach down to the lowest level."""
    foot = np.array([block.vertices[:, 2].min() for block in blocks])
    top = max(float(block.vertices[:, 2].max()) for block in blocks)
    return np.asarray(foot <= foot.min() + LEVEL * (top - foot.min()))


def _centre(block: Block) -> np.ndarray:
    """Return the centre of the box around a block, (3,) [m]: the shell may be unsound yet."""
    return np.asarray(0.5 * (block.vertices.min(axis=0) + block.vertices.max(axis=0)))


def _none(blocks: Sequence[Block], rule: str | SupportRule) -> str:
    """That no block fulfils a rule, and what there is."""
    first = ", ".join(block.name for block in blocks[:5])
    if isinstance(rule, str):
        return f'no block is named "{rule}"; the first are {first}'
    groups = ", ".join(list(dict.fromkeys(block.group for block in blocks))[:5])
    low = min(float(block.vertices[:, 2].min()) for block in blocks)
    return f"no block fulfils {rule.words}; the lowest corner is at z = {low:.4g} m, names are {first}, groups {groups}"
