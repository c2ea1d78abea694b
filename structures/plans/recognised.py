# SPDX-License-Identifier: GPL-3.0-or-later
"""A drawing becomes a plan: its entities by layer, walls from faces, openings in walls, heights from texts; what is left over is listed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.errors import Fault, InputError
from structures.plans import marks, single_lines
from structures.plans.axes import WallAxis, walls_of
from structures.plans.bands import WallStretch, bands_of
from structures.plans.edges import Faces, edges_of, faces_of
from structures.plans.entities import INSERT, OTHER, PATH, TEXT, Entity
from structures.plans.fitted import READ_AT, Drawn, column_table, drawn, fit, neighbour_of, opening_tables, vault_table
from structures.plans.heights import Note, height_keys, nearest_wall
from structures.plans.keys import PlanKeys
from structures.plans.places import place

MOST_EDGES = 8000  # on layers of walls: a plan of one floor has hundreds
SHOWN = 4  # places that a line on many of them gives
LEFT_OVER = 0.05  # of the ground of walls a piece this wide is worth a word [m]


LEAST_LEFT = 0.01  # and of this area [m2]


class Left(NamedTuple):
    """An entity that is not understood."""

    handle: str
    layer: str
    drawn_as: str
    why: str


class Recognised(NamedTuple):
    """A plan as tables of a building, and what was left."""

    tables: dict[str, Any]
    notes: list[str]
    left: list[Left]
    faults: dict[str, Fault]  # what walls lack, by wall


class _Roles:
    """Entities by what lies on their layer; what an insert on a layer of openings or columns brings belongs to it."""

    def __init__(self, entities: Sequence[Entity], keys: PlanKeys) -> None:
        self.inserts = {e.handle: e for e in entities if e.kind == INSERT}
        self.by_role: dict[str, list[Entity]] = {}
        self.role_of: dict[str, str] = {}  # by handle
        self.unknown: list[Entity] = []
        for entity in entities:
            home = self._home(entity, keys)
            role = keys.layers.role(home.layer)
            if entity.kind == OTHER or not role:
                self.unknown.append(entity)
                continue
            its = entity if home is entity else entity._replace(owner=home.handle, layer=home.layer)
            self.by_role.setdefault(role, []).append(its)
            self.role_of[its.handle] = role

    def _home(self, entity: Entity, keys: PlanKeys) -> Entity:
        """The outermost insert with a role of its own that brings an entity, or the entity."""
        home, up = entity, self.inserts.get(entity.owner)
        while up is not None:
            if keys.layers.role(up.layer) in ("openings", "columns"):
                home = up
            up = self.inserts.get(up.owner)
        return home

    def of(self, role: str, kind: str) -> list[Entity]:
        """Those of a role and a kind."""
        return [e for e in self.by_role.get(role, ()) if e.kind == kind]

    def all(self) -> list[Entity]:
        """Those of any role."""
        return [e for members in self.by_role.values() for e in members]


def recognise(entities: Sequence[Entity], keys: PlanKeys, name: str) -> Recognised:
    """The plan that a drawing shows.

    Args:
        entities: of the drawing [m].
        keys: how to read it.
        name: of the file, for messages.

    Raises:
        InputError: no wall comes out.
    """
    roles = _Roles(entities, keys)
    left = [
        Left(e.handle, e.layer, e.drawn_as, e.text if e.kind == OTHER and e.text else _why_unknown(e, keys)) for e in _told(roles.unknown)
    ]
    openings = drawn(roles.by_role.get("openings", []))
    walls, faces, unread = _walls(roles, keys, openings, name)
    left += unread
    texts = [e for e in roles.all() if e.kind == TEXT]
    none, doubt = single_lines.signs([*faces.edges, *faces.loose], walls, [e for e in entities if e.kind == TEXT])
    reader = _Reader(walls, keys, left, name)
    reader.notes += [f"{name}: {doubt}"] if doubt else []
    found = reader.tables(roles, openings, texts, faces)
    return found._replace(faults={wall.name: Fault(name, doubt) for wall in reader.walls}) if none else found


def _told(entities: Iterable[Entity]) -> list[Entity]:
    """Without what an insert brings that is itself listed."""
    listed = {e.handle for e in entities if e.kind == INSERT}
    return [e for e in entities if e.owner not in listed]


def _why_unknown(entity: Entity, keys: PlanKeys) -> str:
    return f"{entity.drawn_as} is nothing of a plan" if keys.layers.role(entity.layer) else "its layer has no meaning in structure.layers"


def _walls(roles: _Roles, keys: PlanKeys, openings: Sequence[Drawn], name: str) -> tuple[list[WallAxis], Faces, list[Left]]:
    """The walls, what is drawn of them, and which of that is not a wall."""
    paths = roles.of("walls", PATH)
    broad = [p for p in paths if p.width > 0.0 and not p.closed]
    faces = faces_of(p for p in paths if not (p.width > 0.0 and not p.closed))
    if len(faces.edges) + len(faces.loose) > MOST_EDGES:
        raise InputError(name, f"more than {MOST_EDGES} edges on layers of walls; name those of one floor in structure.layers.walls")
    bands = bands_of(faces, keys.thickest, [_filling(one) for one in openings])
    texts = [(e, marks.read(e.text)) for e in (*roles.of("axes", TEXT), *roles.of("heights", TEXT), *roles.of("walls", TEXT))]
    axes, left = _from_axes([*broad, *roles.of("axes", PATH)], keys, texts)
    walls = _named(walls_of([*bands, *axes], faces.ground))
    if not walls:
        on = ", ".join(sorted({e.layer for e in paths})) or "none of structure.layers.walls"
        layers = ", ".join(sorted({e.layer for e in (*roles.unknown, *roles.all())})[:12]) or "none"
        none = f"no wall comes out of what is drawn; layers of walls in it: {on}; its layers: {layers}"
        raise InputError(name, f"{none}; {single_lines.REMEDY}")
    used = {handle for wall in walls for handle in wall.handles}
    by_handle = {e.handle: e for e in paths}
    said = dict(faces.left)
    unread = [
        Left(h, e.layer, e.drawn_as, said.get(h, "no face next to it makes a wall with it"))
        for h, e in by_handle.items()
        if h not in used and (said.get(h) or not e.width)
    ]
    inserts = [Left(e.handle, e.layer, e.drawn_as, "an insert without lines") for e in _empty_inserts(roles)]
    return walls, faces, [*unread, *left, *inserts]


def _empty_inserts(roles: _Roles) -> list[Entity]:
    owners = {e.owner for e in (*roles.all(), *roles.unknown)}
    said = {e.handle for e in roles.unknown}  # damaged
    return [e for e in roles.all() if e.kind == INSERT and e.handle not in owners | said and e.owner not in roles.role_of]


def _filling(one: Drawn) -> Any:
    return one.shape if one.shape.geom_type == "Polygon" else one.shape.convex_hull


def _from_axes(
    paths: Sequence[Entity], keys: PlanKeys, texts: Sequence[tuple[Entity, marks.Marks]]
) -> tuple[list[WallStretch], list[Left]]:
    """Bands from middle lines, whose thickness is the polyline's width, a mark next to them, or the scene's."""
    import shapely

    bands, left = [], []
    for path in paths:
        for edge in edges_of(path):
            line = shapely.LineString(np.concatenate([edge.points(), edge.end[None]]))
            near = [(line.distance(e.line), read.numbers["thickness"]) for e, read in texts if "thickness" in read.numbers]
            marked = min(near, default=(np.inf, 0.0))
            thickness = path.width or (marked[1] if marked[0] < READ_AT else keys.wall_thickness)
            if not thickness:
                left.append(
                    Left(
                        path.handle, path.layer, path.drawn_as, "no thickness: neither a width, a mark t=0.60 nor structure.wall_thickness"
                    )
                )
                break
            bands.append(WallStretch(edge, float(thickness), (path.handle,)))
    return bands, left


def _named(walls: Sequence[WallAxis]) -> list[WallAxis]:
    return [wall._replace(name=f"w{k + 1}") for k, wall in enumerate(walls)]


class _Reader:
    """Fits openings, heights, vaults and columns to walls."""

    def __init__(self, walls: list[WallAxis], keys: PlanKeys, left: list[Left], name: str) -> None:
        self.walls, self.keys, self.left, self.name = walls, keys, left, name
        self.notes: list[str] = []
        self.faults: dict[str, Fault] = {}

    def tables(self, roles: _Roles, openings: Sequence[Drawn], texts: Sequence[Entity], faces: Faces) -> Recognised:
        """The tables of the plan."""
        things = {"openings": list(openings)} | {role: drawn(roles.by_role.get(role, [])) for role in ("vaults", "columns")}
        adjacent, of_walls = self._sorted_texts(texts, things, roles)
        walls = self._wall_tables(of_walls)
        self._openings(openings, adjacent, walls)
        tables: dict[str, Any] = {"walls": walls}
        for role in ("vaults", "columns"):
            made = self._elements(things[role], adjacent, role)
            if made:
                tables[role] = made
        self._remarks(faces)
        return Recognised(tables, self.notes, self.left, self.faults)

    def _sorted_texts(
        self, texts: Sequence[Entity], things: dict[str, list[Drawn]], roles: _Roles
    ) -> tuple[dict[str, list[str]], dict[int, list[Note]]]:
        """Texts by the handle of the thing that they are next to, and by wall."""
        adjacent: dict[str, list[str]] = {}
        of_walls: dict[int, list[Note]] = {}
        for text in texts:
            read, place, role = marks.read(text.text), text.line, roles.role_of[text.handle]
            home = next((d for each in things.values() for d in each if text.owner in d.handles), None)
            if home is None and (role in things or read.is_of_opening or "springing" in read.numbers):
                role = role if role in things else "vaults" if "springing" in read.numbers else "openings"
                home = neighbour_of(text, read, things[role], adjacent)
            elif home is None:
                k = nearest_wall(place, self.walls)
                if k is not None and (not read.means_nothing or marks.name_in(text.text)):
                    of_walls.setdefault(k, []).append(Note(self.walls[k].along(place.centroid.coords[0]), read, text.handle))
                    continue
            if home is None or read.means_nothing:
                where = f'"{text.text.strip()[:40]}" ' + ("stands next to nothing" if home is None else "says nothing of a plan")
                self.left.append(Left(text.handle, text.layer, text.drawn_as, where))
            else:
                adjacent.setdefault(home.handles[0], []).append(text.text)
        return adjacent, of_walls

    def _wall_tables(self, of_walls: dict[int, list[Note]]) -> list[dict[str, Any]]:
        tables, without, names = [], [], set[str]()
        for k, wall in enumerate(self.walls):
            notes = of_walls.get(k, [])
            name = next((note.marks.name for note in notes if note.marks.name and note.marks.name not in names), wall.name)
            names.add(name)
            self.walls[k] = wall = wall._replace(name=name)
            keys = height_keys(wall, k, self.walls, notes, self.keys.wall_height)
            without += [wall] if keys is None else []
            tables.append({"name": name, "axis": axis_of(wall), "thickness": round(wall.thickness, 4), **(keys or {}), "openings": []})
        if without:
            others = len(without) - 1
            more = f" nor of {others} other{'s' if others > 1 else ''}" if others else ""
            said = f"nothing says the height of wall {without[0].name} at {place(without[0].line.centroid.coords[0])}{more}: "
            said += "draw a text h=8.50 next to it, or give structure.wall_height"
            self.faults = {wall.name: Fault(self.name, said) for wall in without}
        return tables

    def _openings(self, openings: Sequence[Drawn], adjacent: dict[str, list[str]], walls: list[dict[str, Any]]) -> None:
        for one in openings:
            fitted = fit(one, self.walls)
            if fitted is None:
                self._leave(one, "no wall within 0.3 m")
                continue
            wall = walls[fitted.wall]
            made, assumed, dropped = opening_tables(fitted, one, adjacent.get(one.handles[0], []), self.walls[fitted.wall].thickness)
            wall["openings"] += made
            where = f"{one.layer} {one.handles[0]}, wall {wall['name']} at {fitted.at:.2f} m"
            self.notes += [f"{self.name}: opening {where}: {said}" for said in dropped]
            if assumed:
                self.notes.append(f"{self.name}: no text says {' and '.join(assumed)} of opening {where}: taken so")
        for wall in walls:
            wall["openings"].sort(key=lambda table: (table["at"], table["sill"]))
            if not wall["openings"]:
                del wall["openings"]

    def _elements(self, things: Sequence[Drawn], adjacent: dict[str, list[str]], role: str) -> list[dict[str, Any]]:
        made = []
        for one in things:
            texts = [marks.read(text) for text in (*adjacent.get(one.handles[0], []), one.text)]
            table = vault_table(one, texts) if role == "vaults" else column_table(one, texts, self.keys.wall_height)
            if isinstance(table, str):
                self._leave(one, table)
            else:
                made.append(table)
        return made

    def _leave(self, one: Drawn, why: str) -> None:
        self.left += [Left(handle, one.layer, one.paths[0].drawn_as if one.paths else "INSERT", why) for handle in one.handles]

    def _remarks(self, faces: Faces) -> None:
        """On ends that were brought together, on walls whose faces diverge, and on ground of walls that no wall covers."""
        import shapely

        if faces.snapped:
            most = max(distance for _, distance in faces.snapped)
            said = f"{len(faces.snapped)} ends of lines missed each other by up to {1e3 * most:.3g} mm, and are brought together, at "
            more = f" and {len(faces.snapped) - SHOWN} more" if len(faces.snapped) > SHOWN else ""
            self.notes.append(f"{self.name}: {said}{'; '.join(place(corner) for corner, _ in faces.snapped[:SHOWN])}{more}")
        for wall in self.walls:
            if wall.taper > 0.05:
                mean = f"{wall.thickness:.3g} m is its mean"
                self.notes.append(f"{self.name}: wall {wall.name} is {wall.taper:.2g} m thicker at one end than at the other; {mean}")
        if faces.ground.is_empty:
            return
        covered = shapely.union_all([wall.ground(0.02, "square") for wall in self.walls])
        rest = faces.ground.difference(covered).buffer(-0.5 * LEFT_OVER).buffer(0.5 * LEFT_OVER)
        for part in getattr(rest, "geoms", [rest]):
            if part.area > LEAST_LEFT:
                self.notes.append(f"{self.name}: {part.area:.2g} m2 of wall at {place(part.centroid.coords[0])} are in no wall")


def axis_of(wall: WallAxis) -> list[Any]:
    """The axis as the scene has it."""
    axis: list[Any] = [_point(wall.pieces[0].start)]
    for piece in wall.pieces:
        if piece.centre is None:
            axis.append(_point(piece.end))
        else:
            points = piece.points()
            middle = points[len(points) // 2]
            axis.append({"to": _point(piece.end), "through": _point(middle)})
    return axis


def _point(place: np.ndarray) -> list[float]:
    return [round(float(x), 6) + 0.0 for x in place]


def counted(left: Sequence[Left]) -> list[str]:
    """Summarise the entities that are left by layer and reason, with the first handles."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    for one in left:
        groups.setdefault((one.layer, one.drawn_as, one.why), []).append(one.handle)
    lines = []
    for (layer, kind, why), handles in groups.items():
        more = f" and {len(handles) - 4} more" if len(handles) > 4 else ""
        lines.append(f"layer {layer}: {kind} {', '.join(handles[:4])}{more}: {why}")
    return lines
