# SPDX-License-Identifier: GPL-3.0-or-later
"""A drawing for each storey: walls of one stand on those of the storey below, and floors fill the rooms between them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.foundation.errors import Faults, InputError
from structures.plans import FilePlan, open_plan
from structures.plans.outlines import outline_of
from structures.plans.places import place

if TYPE_CHECKING:
    from structures.plans.keys import StoreyTable

CLOSED = 1e-3  # gaps between the grounds of walls that count as none [m]
LEAST_ROOM = 1.0  # an enclosed space that is smaller has no floor [m2]
CONVEX = 0.99  # share of its hull that a room fills at least: a floor is convex in plan
ADJOINS = 0.02  # walls this near to a room bound it [m]
RAISED = {"walls": "base", "columns": "base", "vaults": "springing"}  # key that is a height over the foot of the storey


def stacked(storeys: Sequence[StoreyTable], folder: Path, keys: Mapping[str, Any]) -> FilePlan:
    """The plans of all storeys as one; names end with the number of the storey.

    Args:
        storeys: from the lowest up.
        folder: of the scene.
        keys: of [structure], which say how to read drawings.

    Raises:
        InputError: what is wrong with the drawings, of each the first fault.
    """
    faults, plans = Faults(), list[FilePlan]()
    for k, storey in enumerate(storeys):
        try:
            if Path(storey.plan).suffix.lower() != ".dxf":
                raise InputError("structure.plan", f'"{storey.plan}" is not a drawing in DXF')
            plans.append(open_plan(folder / storey.plan, {**keys, "wall_height": storey.height}, plans[0].origin if plans else None))
        except InputError as error:
            own = f"structure.storeys[{k}].plan"
            faults.found += [fault._replace(place=own) if fault.place == "structure.plan" else fault for fault in error.faults]
    faults.refuse()
    whole, foot = FilePlan.of("", {})._replace(origin=plans[0].origin), 0.0
    for number, (storey, plan) in enumerate(zip(storeys, plans, strict=True), start=1):
        raised = {key: [_raised(entry, key, number, foot) for entry in entries] for key, entries in plan.tables.items()}
        for key, entries in raised.items():
            whole.tables.setdefault(key, []).extend(entries)
            where = f"{Path(storey.plan).name}, storey {number}"
            whole.entries.setdefault(key, []).extend((where, i) for i in range(len(entries)))
        whole.notes.extend(plan.notes)
        whole.left.extend(one._replace(why=f"{Path(storey.plan).name}: {one.why}") for one in plan.left)
        whole.faults.update({f"{wall}_{number}": fault for wall, fault in plan.faults.items()})
        foot += storey.height
        if storey.floor is not None:
            slab = storey.floor.model_dump(exclude_unset=True) | {"height": foot}
            rooms = _rooms(raised["walls"], number, whole.notes)
            whole.floors.extend((f"structure.storeys[{number - 1}].floor", slab | room) for room in rooms)
    return whole


def _raised(entry: Mapping[str, Any], key: str, number: int, foot: float) -> dict[str, Any]:
    """An entry of a storey, on its foot [m]."""
    up = RAISED[key]
    named = {"name": f"{entry['name']}_{number}"} if entry.get("name") else {}
    return {**entry, **named, up: round(entry.get(up, 0.0) + foot, 6)}


def _rooms(walls: Sequence[Mapping[str, Any]], number: int, notes: list[str]) -> Iterator[dict[str, Any]]:
    """The keys of a floor for each room that walls enclose: its name, its walls, a point in it."""
    import shapely

    grounds = {str(wall["name"]): outline_of(wall, (float(wall["thickness"]),) * 2).ground for wall in walls}
    whole = shapely.union_all([ground.buffer(CLOSED, join_style="mitre") for ground in grounds.values()])
    rooms = [shapely.Polygon(ring) for part in shapely.get_parts(whole) for ring in part.interiors]
    rooms = sorted((room for room in rooms if room.area > LEAST_ROOM), key=lambda room: (room.centroid.x, room.centroid.y))
    for i, room in enumerate(rooms, start=1):
        point = room.representative_point().coords[0]
        if room.area < CONVEX * room.convex_hull.area:
            at = f"the room at {place(point)} is not convex and gets no floor"
            notes.append(f"storey {number}: {at}; divide it, or give it floors of its own, [[structure.floors]]")
            continue
        around = [name for name, ground in grounds.items() if ground.distance(room) < ADJOINS]
        yield {"name": f"floor_{number}_{i}", "inside": point, "walls": around}
