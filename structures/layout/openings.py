# SPDX-License-Identifier: GPL-3.0-or-later
"""Openings as kinds with keys of their own draw them, and the measures that heads have by default.

Their frames are those of all buildings (:mod:`structures.building.frames`). Heights are absolute, places count along the wall.
"""

from __future__ import annotations

from dataclasses import dataclass

from structures.schema import HeadShape, OpeningTable


@dataclass(frozen=True)
class Opening:
    """The measures of one opening [m]."""

    key: str  # that draws it, for messages: "structure.openings[0]" or "structure.door_width"
    centre: float
    width: float
    sill: float
    height: float  # clear, to the crown of the intrados
    head: HeadShape
    depth: float  # of the lintel or of the ring
    rise: float | None = None  # of a segmental intrados
    bearing: float | None = None  # of a lintel

    @property
    def crown(self) -> float:
        """Height of the top of the lintel or of the crown of the extrados."""
        return self.sill + self.height + self.depth


def opening_of(table: OpeningTable, key: str, course: float) -> Opening:
    """An opening in a wall whose foot is at z = 0, from its table, with the depth of its head filled in."""
    depth = table.depth or (course if table.head in ("lintel", "flat") else natural_ring(table.width, course))
    return Opening(key, table.centre, table.width, table.sill, table.height, table.head, depth, table.rise, table.bearing)


def natural_bearing(width: float, unit: float) -> float:
    """Of a lintel on each jamb [m]."""
    return max(unit / 3.0, 0.15 * width)


def natural_ring(width: float, course: float) -> float:
    """Thickness of the voussoirs of an arch: a fifth of its span, for a small one up to a course [m]."""
    return max(0.2 * width, min(0.8 * course, 0.35 * width))


def voussoir_width(ring: float, course: float) -> float:
    """Aimed at [m]."""
    return max(0.6 * ring, min(0.8 * course, 1.2 * ring))
