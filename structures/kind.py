# SPDX-License-Identifier: GPL-3.0-or-later
"""A kind of structure: all that the program knows of it, in one place. A module of :mod:`structures.kinds` ends with its ``KIND``.

    KIND = StructureKind(build, ColumnTable, first={"height": 6.0, "drums": 7}, resized=partial(scaled, ColumnTable, counts={"drums": 1}))

Upper floors ask it: starter scenes for ``first``, the assessment for what may be varied, the limit analysis for the parts. Ranges beyond
which a value is doubted stand in the table, next to the unit of the key (:class:`masonry_cd.foundation.units.Usual`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from pydantic import BaseModel

from masonry_cd.foundation.errors import Fault
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.wall_outline import WallOutline
from structures.macro_elements import BlockLayout, MacroElement, groups

if TYPE_CHECKING:
    from structures import MadeStructure

Keys: TypeAlias = dict[str, Any]  # of a table [structure], with its kind
Build: TypeAlias = "Callable[[Mapping[str, Any], float, Path], list[Block] | tuple[list[Block], list[str]] | MadeStructure]"
Assume: TypeAlias = Callable[[Keys, bool], "dict[str, Keys] | str"]


class DrawnPlan(NamedTuple):
    """The plan that a structure is built from, as far as it is understood."""

    tables: dict[str, Any]  # as plan.json has them
    walls: list[WallOutline]
    left: Sequence[Sequence[str]]  # handle, layer, kind and reason of what of a drawing was not understood
    meetings: Sequence[Sequence[object]]  # junctions and free ends
    wrong: frozenset[str]  # names of walls, vaults and columns of which faults speak


def no_other(table: Keys) -> dict[str, Keys]:
    """The other bonds of a kind that has no key for its bond."""
    return {}


@dataclass(frozen=True)
class StructureKind:
    """A kind of structure and all that is known of it; ``build`` alone is needed."""

    build: Build
    """Makes blocks, these and lines on what was changed in making them, or more, from the kind's own keys, the density of the material
    [kg/m3] and the folder of the scene, to which paths are relative; an InputError names a key that is wrong, ``structure.key``."""
    table: type[BaseModel] | None = None
    """The model of the kind's own keys, for the schema, units and doubts; None: they are not known."""
    first: Mapping[str, Any] = field(default_factory=dict)
    """Keys that a starter scene sets."""
    masonry: str = ""
    """Kind of masonry of a starter scene, of structures whose elasticity decides how they are shaken; others keep rigid joints."""
    files: Callable[[], Mapping[str, str]] = dict
    """Name and content of the files that the keys of a starter scene name."""
    remark: str = ""
    """A line that is printed where a starter scene is written."""
    resized: Callable[[Keys, float], Keys] | None = None
    """The table with blocks of other lengths, by a factor, in the same outline; None where no key says how large they are."""
    bonds: Callable[[Keys], dict[str, Keys]] = no_other
    """Other bonds of a structure: of each its name and the keys that make it."""
    assumptions: Mapping[str, Assume] = field(default_factory=dict)
    """Other assumptions on a structure, by their names: from its table, and whether something crosses it, each gives names and keys, as
    ``bonds`` does, or the reason why it is not varied."""
    parts: Callable[[BlockLayout], list[MacroElement]] = groups
    """Its macro-elements."""
    plan: Callable[[Mapping[str, Any], Path, Sequence[Fault]], DrawnPlan] | None = None
    """The plan that it is built from; of own keys, the folder of the scene, and what is wrong with it."""
    own_densities: bool = False
    """Its blocks may bring densities of their own, so that the scene may state none."""
    checks: bool = False
    """``build`` checks the blocks itself, as those of files by the names of these; others are checked where they are built."""
    grounded: bool = True
    """A ground is laid under supports with nothing between them where the scene does not say."""
    unsupported: str = ""
    """A hint how the scene names supports, for a structure that has none."""


def scaled(
    model: type[BaseModel], table: Keys, factor: float, lengths: Sequence[str] = (), counts: Mapping[str, int] | None = None
) -> Keys:
    """A table with blocks of other lengths: keys that are lengths of blocks times a factor, and numbers of blocks divided by it.

    A number is whole, so the size that comes out may differ a little. A key that the table leaves to a default which follows from others
    stays left to it.

    Args:
        model: of the table.
        table: is not changed.
        factor: larger than 1 for larger blocks.
        lengths: keys of lengths of blocks.
        counts: keys of numbers of blocks, each with its least.
    """
    made = dict(table)
    for name in (*lengths, *(counts or {})):
        given = value_of(model, table, name)
        if given is None:
            continue
        each = given if isinstance(given, (list, tuple)) else [given]
        each = [factor * value for value in each] if name in lengths else [max((counts or {})[name], round(n / factor)) for n in each]
        made[name] = each if isinstance(given, (list, tuple)) else each[0]
    return made


def value_of(model: type[BaseModel], table: Keys, name: str) -> Any:
    """The value that a table gives for a key, or else its default."""
    return table.get(name, model.model_fields[name].default)


def straight_joints(table: Keys, where: str = "where walls meet") -> dict[str, Keys]:
    """The other value of ``bonded``."""
    bonded = bool(table.get("bonded", True))
    return {f"{'straight joints' if bonded else 'bonded'} {where}": {"bonded": not bonded}}


def fewer_through_stones(table: Keys) -> dict[str, Keys]:
    """Half the through-stones of leaves that have some."""
    through = table.get("through", 3)
    return {"half the through-stones": {"through": 2 * through}} if table.get("leaves", 1) > 1 and through else {}


def other_seed(table: Keys, key: str = "seed", of: str = "") -> dict[str, Keys]:
    """The next seed."""
    return {f"other seed{of}": {key: table.get(key, 0) + 1}}
