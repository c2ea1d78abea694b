# SPDX-License-Identifier: GPL-3.0-or-later
"""Churches: one nave or three, a facade with its gable, a triumphal arch, an apse with its half dome, a bell tower.

The nave runs along x from the facade at x = 0 to the wall of the triumphal arch, and is centred on y = 0; the ground is
z = 0. All walls share their beds and are interlocked where they meet (:mod:`structures.courser.wall_plan`), the apse with the wall that it
leans on by stones that reach into it (:mod:`structures.courser.rings`). ``block_length`` steers the number of blocks: the default church
has about 2,300 of 1 m by 0.5 m, with 0.64 m about 5,000. Heights are rounded to whole courses.

The measures are those of a middle-sized Italian church with walls of squared blocks: no drawing of a real one is behind them.
Damage is reported by macro-element, which are the groups: ``facade``, ``nave_walls``, ``triumphal_arch``, ``apse``, ``half_dome``,
``tower``, ``aisle_walls``, ``arcades``, ``buttresses``, ``roof`` or ``vault``, and ``base``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.courser import wall_plan
from structures.kind import StructureKind, scaled, straight_joints
from structures.kinds import church_elements, church_parts
from structures.kinds.church_table import ChurchTable
from structures.layout.ground import ground

LEAST_DEPTH = 0.15  # of a buttress beyond its wall: one that juts out less is not a wall of its own [m]


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a church on its ground.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    from structures.building import square_plan

    keys = with_defaults(parse_table(ChurchTable, table, "structure"))
    _check_measures(keys)
    size.check_size(_estimate(keys), "gable" if (keys.gable or 0.0) > 10.0 * keys.height else "block_length")
    church = church_parts.Church.of(keys)
    walls = church_parts.walls(church)
    beds = beds_of(church, walls)
    walls, apse = church_parts.with_apse(church, walls, beds, density)
    blocks = square_plan.build(walls, beds, church.sizes, density, keys.bonded) + apse
    if keys.aisles:
        blocks += church_parts.columns(church, density)
    if keys.roof == "timber":
        blocks += church_parts.roof_plates(church)
    elif keys.roof == "vault":
        blocks += church_parts.nave_vault(church, density)
    blocks.append(ground(blocks, church.course, density))
    return blocks


def _estimate(keys: ChurchTable) -> float:
    """About how many blocks a church has: the faces of its walls over that of a block."""
    walls = (2.0 * keys.length + 4.0 * keys.width) * keys.height + keys.width * (keys.gable or 0.0)
    if keys.tower:
        walls += 4.0 * keys.tower_side * keys.tower_height
    if keys.aisles:
        walls += 2.0 * (keys.length + 2.0 * keys.aisle_width) * keys.aisle_height
    if keys.roof == "vault":
        walls += 2.0 * keys.length * keys.width
    walls += 2.0 * (keys.windows if keys.buttresses is None else keys.buttresses) * (keys.buttress_depth or 0.0) * keys.height
    return walls / keys.block_length / (keys.course_height or 0.5 * keys.block_length) * keys.leaves


def with_defaults(keys: ChurchTable) -> ChurchTable:
    """The keys with those filled in that depend on the roof."""
    vaulted = keys.roof == "vault"
    natural = {
        "thickness": 0.16 * keys.width if vaulted else 1.0,
        "gable": 0.57 * keys.width if vaulted else 2.5,
    }
    return keys.model_copy(update={key: value for key, value in natural.items() if getattr(keys, key) is None})


def beds_of(church: church_parts.Church, walls: Sequence[wall_plan.PlanWall]) -> list[float]:
    """The beds that all walls of a church share [m]."""
    from structures.building import square_plan

    return square_plan.beds_of(walls, church.sizes, {"structure.apse_height": church.apse_top} if church.keys.apse else {})


def _check_measures(keys: ChurchTable) -> None:
    """Refuse measures that exclude each other."""
    t = keys.thickness or 1.0
    clear = min(keys.height - keys.aisle_height, keys.aisle_height) if keys.aisles else keys.height
    course = keys.course_height or 0.5 * keys.block_length
    limits = [
        ("block_length", keys.block_length, keys.width / 3.0, "a third of the width"),
        ("course_height", course, keys.height / 8.0, "an eighth of the height"),
        ("thickness", t, keys.width / 3.0, "a third of the width"),
        ("window_height", keys.window_height or 0.0, 0.4 * clear, "0.4 of the wall it is in"),
        ("door_width", keys.door_width, 0.4 * keys.width, "0.4 of the width"),
        ("door_height", keys.door_height, 0.55 * keys.height, "0.55 of the height"),
    ]
    if keys.aisles and keys.aisle_height < 4.0 * course:
        raise InputError("structure.aisle_height", f"must be at least four courses, {4.0 * course:g} m, got {keys.aisle_height:g}")
    if keys.apse:
        limits.append(("apse_radius", keys.apse_radius, 0.5 * keys.width, "half the width of the nave"))
        limits.append(
            (
                "apse_height",
                keys.apse_height,
                keys.height + 0.5 * (keys.gable or 0.0) - 1.2 * keys.apse_radius,
                "what the wall behind it hides",
            )
        )
    if keys.aisles:
        limits.append(("aisle_height", keys.aisle_height, 0.7 * keys.height, "0.7 of the height"))
    if keys.roof == "vault":
        limits.append(("vault_thickness", keys.vault_thickness or 0.0, 0.7 * t, "0.7 of the thickness of the walls"))
    elif keys.vault_thickness is not None:
        raise InputError("structure.vault_thickness", f'belongs to roof = "vault", this roof is "{keys.roof}"')
    if keys.tower:
        limits.append(("tower_side", keys.tower_side, 0.4 * keys.length, "0.4 of the length"))
    for key, value, most, what in limits:
        if value > most * (1.0 + 1e-9):
            raise InputError(f"structure.{key}", f"must be at most {what}, {most:.4g} m, got {value:g}")
    bay = keys.window_width * (1.0 + 2.0 * max(0.2, min(0.8 * course / keys.window_width, 0.35))) + 0.4 * keys.block_length
    if keys.windows * bay > keys.length - 2.0 * t:
        raise InputError("structure.windows", f"must be at most {int((keys.length - 2.0 * t) / bay)} of this width, got {keys.windows}")
    if keys.tower and keys.tower_height < 1.2 * keys.height:
        raise InputError(
            "structure.tower_height", f"must be at least 1.2 of the height, {1.2 * keys.height:g} m, got {keys.tower_height:g}"
        )
    if keys.buttress_depth is not None and keys.buttress_depth < LEAST_DEPTH:
        raise InputError("structure.buttress_depth", f"must be at least {LEAST_DEPTH:g} m, got {keys.buttress_depth:g}")
    if keys.tower and keys.tower_side < 2.5 * t:
        raise InputError("structure.tower_side", f"must be at least 2.5 thicknesses, {2.5 * t:g} m, got {keys.tower_side:g}")


KIND = StructureKind(
    build, ChurchTable, first={"block_length": 1.5, "length": 24.0, "width": 9.0, "height": 10.0}, masonry="split stone",
    resized=partial(scaled, ChurchTable, lengths=("block_length", "course_height")), bonds=straight_joints, parts=church_elements.parts,
)  # fmt: skip
