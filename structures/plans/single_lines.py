# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans drawn in single lines, one for each wall: two of them next to a corridor would pass for the faces of a wall as wide as the
corridor.

Where faces are drawn, nearly all their length belongs to a wall, some wall is thinner than a metre, and no wall holds a room. So the
signs are the share of the lines on layers of walls that no wall covers, texts within thick walls that name rooms, and thick walls alone.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from structures.plans.axes import WallAxis
from structures.plans.edges import Edge
from structures.plans.entities import Entity

MOST_BARE = 0.4  # share of the lines that belong to no wall: more are no faces; of plans in faces it is a few hundredths
BARE = 0.15  # share from which on it is a sign
NEAR = 0.05  # of a line from the wall whose face it is [m]
THICK = 1.0  # a wall thinner than this holds no room, and some wall of a building is [m]
REMEDY = "single lines, one for each wall, belong to structure.layers.axes, with structure.wall_thickness"
ROOMS = re.compile(
    r"\b(corridor|corridoio|couloir|flur|hall|bath|bathroom|bagno|salle de bain|bad|wc|toilet|kitchen|cucina|cuisine|kuche|living|"
    r"soggiorno|salotto|salon|sala|wohnzimmer|bed|bedroom|camera|chambre|zimmer|schlafzimmer|room|stanza|pranzo|dining|studio|office|ingresso|entrance|"
    r"entree|atrio|disimpegno|ripostiglio|store|storage|dispensa|cantina|garage|box|cortile|court|lobby|pantry|navata|nave|sacrestia|sacristy)\b"
)
AREA = re.compile(r"\d\s*(?:m2|m²|mq|sqm|qm)\b")


def signs(edges: Sequence[Edge], walls: Sequence[WallAxis], texts: Sequence[Entity]) -> tuple[bool, str]:
    """Judge if a drawing is likely in single lines, so much so that its walls are none; and why; empty where no sign is found.

    Args:
        edges: on layers of walls [m].
        walls: that come out of them.
        texts: of the drawing.
    """
    bare, rooms, thinnest = bare_share(edges, walls), _rooms(walls, texts), min(wall.thickness for wall in walls)
    found = [f"{100.0 * bare:.0f} % of the length of the lines on layers of walls is not a face of a wall"] if bare > BARE else []
    found += [f"{words} stands in wall {wall.name}, {wall.thickness:.3g} m thick" for words, wall in rooms[:2]]
    found += [f"no wall is thinner than {thinnest:.3g} m"] if edges and thinnest > THICK else []
    sure = bare > MOST_BARE or (bool(rooms) and (bare > BARE or thinnest > THICK))
    return sure, f"{'; '.join(found)}: {REMEDY}" if found else ""


def bare_share(edges: Sequence[Edge], walls: Sequence[WallAxis]) -> float:
    """Share of the length of some lines that no wall covers."""
    import shapely

    lines = shapely.union_all([_line(edge) for edge in edges]) if edges else None
    if lines is None or not lines.length > 0.0:
        return 0.0
    return float(lines.difference(shapely.union_all([wall.ground(NEAR, "square") for wall in walls])).length / lines.length)


def _line(edge: Edge) -> Any:
    import shapely

    return shapely.LineString(np.concatenate([edge.points(), edge.end[None]]))


def _rooms(walls: Sequence[WallAxis], texts: Sequence[Entity]) -> list[tuple[str, WallAxis]]:
    """Texts that name a room, or its area, within walls that are thick enough for one."""
    thick = [(wall, wall.ground()) for wall in walls if wall.thickness > THICK]
    named = [text for text in texts if ROOMS.search(text.text.lower()) or AREA.search(text.text.lower())]
    return [(f'"{" ".join(text.text.split())[:30]}"', wall) for wall, ground in thick for text in named if ground.intersects(text.line)]
