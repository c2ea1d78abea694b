# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[[links]]`` of a scene, and the links between the blocks of an assembly that it asks for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from pydantic import BeforeValidator, model_validator

from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import Table, Vector, two_blocks
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.links import IN_PLANE, Link, clusters

if TYPE_CHECKING:  # scenes are checked before numba is loaded
    from masonry_cd.mechanics.model.blocks import Assembly

MOST_UNKNOWNS = 600  # of blocks that links hang together, of which a step factorises a full matrix


class LinkTable(Table):
    """Keys of ``[[links]]``."""

    kind: Literal["hinge", "slider", "rigid"]
    """hinge: a point is shared, with an axis it turns about that alone; slider: free along the axis, without turning; rigid: one body."""
    blocks: Annotated[tuple[str, str], BeforeValidator(two_blocks)]
    """Names of the two blocks, one of which may be a support."""
    point: Annotated[Vector | None, Unit("m")] = None
    """Point of the hinge, on one of the blocks as built; else where the force is reported, by default the first block's centre."""
    axis: Vector | None = None
    """Axis of a hinge in space, or along which a slider is free; in a plane a hinge needs none."""

    @model_validator(mode="after")
    def _one_of_its_kind(self) -> Self:
        if self.kind == "hinge" and self.point is None:
            raise ValueError("a hinge needs a point")
        if (self.kind == "slider" and self.axis is None) or (self.axis is not None and not any(self.axis)):
            raise ValueError("a slider needs an axis, and an axis has a direction, e.g. axis = [1, 0, 0]")
        if self.kind == "rigid" and self.axis is not None:
            raise ValueError("a rigid link has no axis")
        return self


def links_of(tables: Sequence[LinkTable], assembly: Assembly) -> tuple[Link, ...]:
    """The links of a scene between the blocks of an assembly.

    Raises:
        InputError: unknown blocks, two supports, a point that is on neither block, a link given twice, blocks that deform, or too many
            blocks that hang together.
    """
    made: list[Link] = []
    if tables and assembly.deformation is not None:
        raise InputError("links", 'blocks that deform have no links; material.deformable = "rigid" makes them rigid')
    for i, table in enumerate(tables):
        place = f"links[{i}]"
        for name in table.blocks:
            if name not in assembly.names:
                raise InputError(f"{place}.blocks", f'no block "{name}"{suggest(name, assembly.names)}')
        first, second = (assembly.names.index(name) for name in table.blocks)
        if assembly.fixed[[first, second]].all():
            raise InputError(f"{place}.blocks", "both are supports, which move as prescribed: a link between them does nothing")
        point = assembly.centre[first] if table.point is None else np.array(table.point)
        if table.point is not None:
            _require_on_one(assembly, (first, second), point, f"{place}.point")
        axis = np.zeros(3) if table.axis is None else np.array(table.axis) / math.hypot(*table.axis)
        link = Link(table.kind, (first, second), point, axis)
        twin = next((k for k, other in enumerate(made) if _repeats(link, other)), None)
        if twin is not None:
            raise InputError(place, f"holds nothing that links[{twin}] does not hold already")
        made.append(link)
    _require_few(made, assembly)
    return tuple(made)


def _require_few(links: Sequence[Link], assembly: Assembly) -> None:
    """Refuse more blocks that hang together than a step can take at once."""
    most = 6 * int(np.bincount(clusters(links, assembly.fixed)).max())
    if most > MOST_UNKNOWNS:
        raise InputError("links", f"{most // 6} blocks hang together, at most {MOST_UNKNOWNS // 6} do: a step treats them as one body")


def _require_on_one(assembly: Assembly, ends: tuple[int, int], point: np.ndarray, place: str) -> None:
    """Refuse a point (3,) [m] that is on neither of two blocks."""
    from masonry_cd.mechanics.model.place_on_block import OFF, outside_block  # of the kernels, which a scene is checked without

    blocks = [assembly.blocks[b] for b in ends]
    beyond = [float(outside_block(block, point)) for block in blocks]
    size = [float(np.linalg.norm(np.ptp(block.vertices, axis=0))) for block in blocks]
    if all(off > OFF * extent for off, extent in zip(beyond, size, strict=True)):
        at, names = ", ".join(f"{x:.6g}" for x in point), " and ".join(f'"{block.name}"' for block in blocks)
        raise InputError(place, f"({at}) m lies {min(beyond):.3g} m outside both {names}; it has to be on one of them")


def _repeats(link: Link, other: Link) -> bool:
    """True where a link between the blocks of another one holds nothing more than that."""
    if set(link.blocks) != set(other.blocks):
        return False
    same = link.kind == other.kind and np.allclose(np.cross(link.axis, other.axis), 0.0, atol=IN_PLANE)
    return other.kind == "rigid" or bool(same and (link.kind == "slider" or np.allclose(link.point, other.point, atol=IN_PLANE)))
