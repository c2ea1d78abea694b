# SPDX-License-Identifier: GPL-3.0-or-later
"""Foundations in pieces: the fixed blocks of a structure cut by upright planes, so that a part of a footing can settle or spread.

    foundations = "whole"                    as the kind makes them, by default
    foundations = "corners"                  in four, through the middle of what stands on them: NAME.sw, .se, .nw, .ne
    foundations = "parts"                    a piece under each group of blocks, NAME.GROUP.1, .2 ...; what bears nothing is NAME.rest.1 ...
    foundations = { x = 4 }                  in four equal strips along x: NAME.x1 to NAME.x4; likewise y, or both: NAME.x1y2
    foundations = { x = [-1.5, 2.0] }        cut at these places [m]

x points east and y north. A block that stands across a cut bears on both pieces.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.geometry.convex import halves
from structures.geometry.prism import box
from structures.schema import Table

KEY = "foundations"
NAMES = ("whole", "corners", "parts")
AXES = "xy"
ON = 1e-6  # of the size of a footing: closer to its top than this stands on it
MOST = 1000  # pieces along an axis
Cuts = tuple[float, ...]


class FoundationsTable(Table):
    """The table ``structure.foundations``."""

    x: int | Annotated[list[float], Unit("m")] | None = None
    """number of strips along x, or where to cut"""
    y: int | Annotated[list[float], Unit("m")] | None = None
    """number of strips along y, or where to cut"""


def in_pieces(blocks: Sequence[Block], asked: object) -> list[Block]:
    """The blocks of a structure with its foundations in pieces.

    Args:
        blocks: sound ones.
        asked: the value of ``structure.foundations``.

    Raises:
        InputError: no such division, no support, or a place outside the foundations.
    """
    if asked not in NAMES if isinstance(asked, str) else not isinstance(asked, dict):
        raise InputError(f"structure.{KEY}", f"should be one of {', '.join(NAMES)}, or a table {{ x = 4 }}, got {asked!r}")
    if asked == "whole":
        return list(blocks)
    supports = [block for block in blocks if block.fixed]
    if not supports:
        raise InputError(f"structure.{KEY}", "no block of the structure is fixed")
    if any(block.parts for block in supports):
        raise InputError(f"structure.{KEY}", "only supports that are convex can be cut")
    if asked == "parts":
        made = [piece for block in blocks for piece in (_by_parts(block, blocks) if block.fixed else [block])]
        if len(made) == len(blocks):
            raise InputError(f"structure.{KEY}", 'a single group stands on each support; "corners" or { x = 4 } divides one')
        return made
    cuts = _cuts(asked, *_footprint(blocks, supports))
    size.check_size((len(cuts[0]) + 1) * (len(cuts[1]) + 1), KEY)
    made = [piece for block in blocks for piece in (_pieces(block, cuts, asked == "corners") if block.fixed else [block])]
    if len(made) == len(blocks):
        raise InputError(f"structure.{KEY}", "no cut meets a support")
    return made


def _cuts(asked: object, low: np.ndarray, high: np.ndarray) -> tuple[Cuts, Cuts]:
    """Where to cut along x and y [m], for a footprint between two corners."""
    if asked == "corners":
        middle = 0.5 * (low + high)
        return (float(middle[0]),), (float(middle[1]),)
    keys = parse_table(FoundationsTable, asked if isinstance(asked, dict) else {}, f"structure.{KEY}")
    if keys.x is None and keys.y is None:
        raise InputError(f"structure.{KEY}", "give x or y, the number of strips or the places of cuts")
    return _places(keys.x, low[0], high[0], "x"), _places(keys.y, low[1], high[1], "y")


def _footprint(blocks: Sequence[Block], supports: Sequence[Block]) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest corner (3,) of what stands on the supports: of the free blocks at their height, or of all free ones."""
    top = max(float(block.vertices[:, 2].max()) for block in supports)
    size = max(float(np.ptp(block.vertices, axis=0).max()) for block in supports)
    free = [block.vertices for block in blocks if not block.fixed] or [block.vertices for block in supports]
    feet = [points for points in free if points[:, 2].min() <= top + ON * size] or free
    points = np.concatenate(feet)
    return points.min(axis=0), points.max(axis=0)


def _places(asked: int | list[float] | None, low: float, high: float, axis: str) -> Cuts:
    """Where to cut along an axis [m]."""
    if asked is None:
        return ()
    if isinstance(asked, int):
        if not 2 <= asked <= MOST:
            raise InputError(f"structure.{KEY}.{axis}", f"should be 2 to {MOST} strips, or a list of places, got {asked}")
        return tuple(float(low + (high - low) * k / asked) for k in range(1, asked))
    if not asked or len(asked) >= MOST or not all(map(math.isfinite, asked)) or sorted(set(asked)) != list(asked):
        raise InputError(f"structure.{KEY}.{axis}", f"should be places [m] that rise, got {asked}")
    return tuple(map(float, asked))


def _pieces(block: Block, cuts: tuple[Cuts, Cuts], corners: bool) -> Iterator[Block]:
    """A support cut along both axes; as it is where no cut meets it."""
    columns = _cut(block, 0, cuts[0])
    pieces = [(i, j, piece) for i, column in columns for j, piece in _cut(column, 1, cuts[1])]
    for i, j, piece in pieces:
        if len(pieces) == 1:
            yield block
        elif corners:
            yield replace(piece, name=f"{block.name}.{'sn'[j]}{'we'[i]}")
        else:
            name = "".join(f"{axis}{k + 1}" for axis, k, places in zip(AXES, (i, j), cuts, strict=True) if places)
            yield replace(piece, name=f"{block.name}.{name}")


def _cut(block: Block, axis: int, places: Cuts) -> list[tuple[int, Block]]:
    """A convex block cut across an axis, with the number of the strip that each piece lies in."""
    normal, found, rest = np.eye(3)[axis], [], block
    for k, place in enumerate(places):
        below, above = halves(rest, normal, place)
        if below is not None:
            found.append((k, below))
        if above is None:
            return found
        rest = above
    return [*found, (len(places), rest)]


@dataclass(frozen=True, eq=False)
class _Plan:
    """The top of a footing as a grid: who stands on each cell."""

    x: np.ndarray  # (m + 1,) [m]
    y: np.ndarray  # (n + 1,) [m]
    owner: np.ndarray  # (m, n) index of a group, -1 where nothing stands


def _by_parts(block: Block, blocks: Sequence[Block]) -> Iterator[Block]:
    """A level footing with a piece under each group of blocks that stand on it; one under a single group stays as it is."""
    low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
    feet = _feet(blocks, low, high)
    groups = list(dict.fromkeys(group for group, _ in feet))
    if len(groups) < 2:
        yield block
        return
    if len(block.vertices) != 8 or not np.all((block.vertices == low) | (block.vertices == high)):
        raise InputError(
            f"structure.{KEY}", f'"{block.name}" is not a level box, which "parts" needs; {{ x = 4 }} and "corners" cut others too'
        )
    plan = _plan(feet, groups, low, high)
    number: dict[str, int] = {}
    for owner, x0, x1, y0, y1 in _rectangles(plan):
        part = groups[owner] if owner >= 0 else "rest"
        number[part] = number.get(part, 0) + 1
        vertices, faces = box((x0, y0, float(low[2])), (x1, y1, float(high[2])))
        yield replace(block, name=f"{block.name}.{part}.{number[part]}", vertices=vertices, faces=faces)


def _feet(blocks: Sequence[Block], low: np.ndarray, high: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Group and plan (2, 2) of each free block that stands on a footing between two corners [m]."""
    on = ON * float((high - low).max())
    feet = []
    for block in blocks:
        base = block.vertices[np.abs(block.vertices[:, 2] - high[2]) <= on]
        if not block.fixed and len(base) > 2:
            plan = np.clip([base[:, :2].min(axis=0), base[:, :2].max(axis=0)], low[:2], high[:2])
            if (plan[1] - plan[0] > on).all():
                feet.append((block.group, plan))
    return feet


def _plan(feet: Sequence[tuple[str, np.ndarray]], groups: Sequence[str], low: np.ndarray, high: np.ndarray) -> _Plan:
    """The plan of what stands on a footing, on the coarsest grid that shows it."""
    lines = []
    for axis in range(2):
        ends = np.unique(np.round([low[axis], high[axis], *(end for _, plan in feet for end in plan[:, axis])], 9))
        lines.append(ends)
    owner = np.full((len(lines[0]) - 1, len(lines[1]) - 1), -1)
    for group, plan in feet:
        (i0, i1), (j0, j1) = (np.searchsorted(lines[axis], np.round(plan[:, axis], 9)) for axis in range(2))
        owner[i0:i1, j0:j1] = groups.index(group)
    keep_x = np.concatenate([[True], (owner[1:] != owner[:-1]).any(axis=1)])
    keep_y = np.concatenate([[True], (owner[:, 1:] != owner[:, :-1]).any(axis=0)])
    x, y = (np.append(line[:-1][keep], line[-1]) for line, keep in zip(lines, (keep_x, keep_y), strict=True))
    x[[0, -1]], y[[0, -1]] = (low[0], high[0]), (low[1], high[1])  # rounding must not move its edges
    return _Plan(x, y, owner[keep_x][:, keep_y])


def _rectangles(plan: _Plan) -> Iterator[tuple[int, float, float, float, float]]:
    """Owner and x0, x1, y0, y1 of rectangles that fill the plan, each as long along x and then as wide along y as it can be."""
    owner, todo = plan.owner, np.ones(plan.owner.shape, dtype=bool)
    for j in range(owner.shape[1]):
        for i in range(owner.shape[0]):
            if not todo[i, j]:
                continue
            right = i + 1
            while right < owner.shape[0] and todo[right, j] and owner[right, j] == owner[i, j]:
                right += 1
            top = j + 1
            while top < owner.shape[1] and (todo[i:right, top] & (owner[i:right, top] == owner[i, j])).all():
                top += 1
            todo[i:right, j:top] = False
            yield int(owner[i, j]), float(plan.x[i]), float(plan.x[right]), float(plan.y[j]), float(plan.y[top])
