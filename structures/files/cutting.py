"""A solid cut into the shells of its stones by the OpenCASCADE kernel, in a child process, see :mod:`structures.files.foreign`.

The volumes of a CAD model or of a gmsh script are cut by the level planes of the beds, and each body of a course by upright planes across
the plan. What comes back are facets, each with corners of its own, in the units and axes of the file: :mod:`structures.kinds.solid`
says how the planes are chosen, and makes blocks of them. This module imports nothing but numpy, and gmsh when it is called.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.gmsh_session import gmsh_session
from structures.files.foreign import Answer, Faces, Piece, Refused
from structures.size import MOST, beyond

NARROW = 0.25  # no joint closer to the end of a body, or to the face of a wall along it, than this share of a stone
ALONG = 0.75  # a plane runs along a wall that ends near it where, so far beside it, there is less than this share of what it cuts
TRIANGLE = 2  # gmsh's number of this type of element
FINEST = 64  # most facets along one curve
FORMATS = {".step": "step", ".stp": "step", ".brep": "brep"}  # as gmsh calls them; it would go by the file's name


@dataclass(frozen=True)
class Asked:
    """How a solid is to be cut."""

    scale: float  # metres per unit of the file
    up: str  # axis of the file that points upwards
    course_height: float  # aimed at [m]
    unit_length: float  # of a stone [m]
    running: bool  # every second course is shifted by half a stone
    chord: float | None  # how far a flat facet may be off its curved face [m]
    tolerance: float  # corners this close to a joint's plane lie in it [m]
    most_blocks: int = MOST  # about how many stones are allowed


@dataclass(frozen=True)
class Cutting:
    """How a solid is cut, in the units and axes of its file."""

    beds: np.ndarray  # levels of the bed joints, from the foot to the top
    unit: float  # length of a stone
    shift: float  # of every second course
    up: int  # axis that points upwards
    plan: tuple[int, int]  # the other two
    origin: np.ndarray  # (3,) lowest corner of the whole
    reach: np.ndarray  # (3,) its extents
    chord: float | None
    tolerance: float


def cut(path: Path, **asked: Any) -> Answer:
    """Cut the solids of a file.

    Args:
        asked: the keys of :class:`Asked`.

    Returns:
        the stones, each with its course, its group and its facets, whose corners are not joined yet; and three figures: the volume of the
        solids, how many faces are curved, and how far facets are off them, in units of the file.

    Raises:
        Refused: a file that cannot be read, curved faces without ``chord``, or facets that stay farther off.
    """
    with _opened(path) as gmsh:
        cutting = _cutting(gmsh, Asked(**asked))
        whole = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.occ.getEntities(3))
        curved = [tag for _, tag in gmsh.model.getEntities(2) if gmsh.model.getType(2, tag) != "Plane"]
        if curved and cutting.chord is None:
            where = ", ".join(f"{x:.4g}" for x in gmsh.model.occ.getCenterOfMass(2, curved[0]))
            raise Refused(
                f"structure.chord: missing; {path.name} has {len(curved)} curved face{'s' if len(curved) > 1 else ''}, the first at "
                f"({where}): say how far flat facets may be off"
            )
        stones, off = _stones(gmsh, cutting, path.name)
    return stones, (whole, float(len(curved)), off)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The kernel with the volumes of a file in it.

    Raises:
        Refused: the file cannot be read, or holds no volume.
    """
    with gmsh_session() as gmsh:
        try:
            if path.suffix.lower() == ".geo":
                gmsh.merge(str(path))
            else:
                gmsh.option.setString("Geometry.OCCTargetUnit", "M")
                gmsh.model.occ.importShapes(str(path), format=FORMATS[path.suffix.lower()])
            gmsh.model.occ.synchronize()
            found = gmsh.model.occ.getEntities(3)
        except Exception as failure:  # gmsh raises bare exceptions
            raise Refused(f"{path.name}: cannot be read: {(str(failure).splitlines() or [''])[0]}") from None
        if not found:
            hint = '; a .geo file begins with SetFactory("OpenCASCADE");' if path.suffix.lower() == ".geo" else ""
            raise Refused(f"{path.name}: no volume of the OpenCASCADE kernel in it{hint}")
        yield gmsh


def _cutting(gmsh: Any, asked: Asked) -> Cutting:
    """The planes of the joints in the units of the file."""
    corners = np.concatenate([gmsh.model.getValue(0, tag, []) for _, tag in gmsh.model.getEntities(0)]).reshape(-1, 3)
    boxes = np.array([gmsh.model.occ.getBoundingBox(3, tag) for _, tag in gmsh.model.occ.getEntities(3)])
    low, high = boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)
    low = np.where(
        np.abs(corners.min(axis=0) - low) < asked.tolerance / asked.scale, corners.min(axis=0), low
    )  # the boxes are a little wide
    high = np.where(np.abs(corners.max(axis=0) - high) < asked.tolerance / asked.scale, corners.max(axis=0), high)
    up = "xyz".index(asked.up)
    stone = (
        asked.course_height * asked.unit_length * asked.unit_length / asked.scale**3
    )  # at most: walls may be thinner than a stone is long
    whole = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.occ.getEntities(3))
    courses = float((high - low)[up] * asked.scale / asked.course_height)
    too_many = beyond(max(courses, whole / stone if stone > 0.0 else np.inf), "course_height", asked.most_blocks)
    if too_many:
        raise Refused(too_many)
    count = max(1, round(courses))
    unit = asked.unit_length / asked.scale
    return Cutting(
        beds=np.linspace(low[up], high[up], count + 1),
        unit=unit,
        shift=0.5 * unit if asked.running else 0.0,
        up=up,
        plan=(0, 2) if up == 1 else (0, 1),
        origin=low,
        reach=high - low,
        chord=None if asked.chord is None else asked.chord / asked.scale,
        tolerance=asked.tolerance / asked.scale,
    )


def _stones(gmsh: Any, cutting: Cutting, source: str) -> tuple[list[Piece], float]:
    """Cut all volumes, first by the beds, then each body of a course across the plan; the stones, and how far facets are off.

    A course leaves the kernel when its shells are read: the cost of an operation grows with all that is in there.
    """
    outlines = _outlines(gmsh, cutting)
    groups = {}
    for volume in outlines:
        names = [gmsh.model.getPhysicalName(3, tag) for tag in gmsh.model.getPhysicalGroupsForEntity(3, volume)]
        groups[volume] = next((name for name in names if name), "block")
    done: list[Piece] = []
    off = 0.0
    for volume, plans in outlines.items():
        courses: dict[int, list[int]] = {}
        for body in _split(gmsh, volume, cutting.up, cutting.beds[1:-1], cutting)[0]:
            course = int(np.searchsorted(cutting.beds, gmsh.model.occ.getCenterOfMass(3, body)[cutting.up])) - 1
            courses.setdefault(course, []).append(body)
        for course, bodies in courses.items():
            stones, loose = bodies, []
            for axis in cutting.plan:
                cuts = [_split(gmsh, piece, axis, _heads(gmsh, piece, axis, course, plans[course], cutting), cutting) for piece in stones]
                stones = [stone for pieces, _ in cuts for stone in pieces]
                loose += [entity for _, rest in cuts for entity in rest]
            shells, here = _shells(gmsh, stones, cutting, source)
            gmsh.model.occ.remove([*((3, stone) for stone in stones), *loose], recursive=True)
            done += [Piece(course, groups[volume], *shell) for shell in shells]
            off = max(off, here)
    return done, off


def _outlines(gmsh: Any, cutting: Cutting) -> dict[int, list[np.ndarray]]:
    """The outline in plan of each volume in the middle of each course, from a rough mesh of its surface."""
    gmsh.model.occ.synchronize()
    for name, value in (("MeshSizeExtendFromBoundary", 0), ("MeshSizeMax", float(cutting.reach.max())), ("MeshSizeFromCurvature", 24)):
        gmsh.option.setNumber(f"Mesh.{name}", value)
    gmsh.model.mesh.generate(2)
    middles = 0.5 * (cutting.beds[:-1] + cutting.beds[1:])
    surfaces = {volume: _surface(gmsh, volume) for _, volume in gmsh.model.getEntities(3)}
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 0)
    return {v: [_section(surface, cutting.up, middle, cutting.plan) for middle in middles] for v, surface in surfaces.items()}


def _heads(gmsh: Any, body: int, axis: int, course: int, plan: np.ndarray, cutting: Cutting) -> np.ndarray:
    """Where along an axis a body of a course is cut, if it is longer than a stone: places of one grid that leave no sliver.

    Args:
        plan: outline of the section through the middle of the course.
    """
    box = gmsh.model.occ.getBoundingBox(3, body)
    if box[axis + 3] - box[axis] <= cutting.unit + 2.0 * cutting.tolerance:
        return np.zeros(0)
    first = cutting.origin[axis] + (course % 2) * cutting.shift
    places = first + cutting.unit * np.arange(-1, np.ceil(cutting.reach[axis] / cutting.unit) + 1)
    room = NARROW * cutting.unit
    inside = places[(places > box[axis] + room) & (places < box[axis + 3] - room)]
    beside = np.array([-room, -10.0 * cutting.tolerance, 10.0 * cutting.tolerance, room])
    other = next(k for k in cutting.plan if k != axis)
    column = cutting.plan.index(axis)
    lengths = [_length(plan, column, place + d, box[other], box[other + 3]) for place in inside for d in beside]
    far, near, here, beyond = np.maximum(np.reshape(lengths, (-1, 4)), cutting.tolerance).T
    return inside[np.minimum(far / near, beyond / here) >= ALONG]


def _surface(gmsh: Any, volume: int) -> np.ndarray:
    """A rough triangulation (n, 3, 3) of the surface of a volume, from a mesh of the model."""
    tags, places, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    number[tags] = np.arange(len(tags))
    faces = [tag for _, tag in gmsh.model.getBoundary([(3, volume)], oriented=False)]
    corners = np.concatenate([gmsh.model.mesh.getElementsByType(TRIANGLE, face)[1] for face in faces])
    return places.reshape(-1, 3)[number[corners]].reshape(-1, 3, 3)


def _section(surface: np.ndarray, up: int, level: float, plan: tuple[int, int]) -> np.ndarray:
    """The outline of a level section, as segments (m, 2, 2) in plan."""
    height = surface[:, :, up] - level
    segments = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        share = np.divide(height[:, i], height[:, i] - height[:, j], out=np.zeros(len(height)), where=height[:, i] != height[:, j])
        segments.append(surface[:, i] + share[:, None] * (surface[:, j] - surface[:, i]))
    above = height >= 0.0
    crossed = np.stack([above[:, 0] != above[:, 1], above[:, 1] != above[:, 2], above[:, 2] != above[:, 0]], axis=1)
    cut = crossed.any(axis=1)  # such triangles have two crossed sides
    return np.stack(segments, axis=1)[cut][crossed[cut]].reshape(-1, 2, 3)[:, :, list(plan)]


def _length(outline: np.ndarray, column: int, place: float, low: float, high: float) -> float:
    """How much of a straight line across one axis of the plan lies within an outline, between two ends."""
    along = outline[:, :, column] - place
    met = (along[:, 0] >= 0.0) != (along[:, 1] >= 0.0)
    share = along[met, 0] / (along[met, 0] - along[met, 1])
    ends = outline[met, 0, 1 - column] + share * (outline[met, 1, 1 - column] - outline[met, 0, 1 - column])
    return float(np.diff(np.clip(np.sort(ends), low, high).reshape(-1, 2), axis=1).sum())


def _split(gmsh: Any, volume: int, axis: int, places: np.ndarray, cutting: Cutting) -> tuple[list[int], list[tuple[int, int]]]:
    """Cut a volume by planes across an axis: the numbers of its pieces, and the faces made, some of which belong to no piece."""
    if not len(places):
        return [volume], []
    planes = [(2, _plane(gmsh.model.occ, axis, float(place), cutting)) for place in places]
    made, pieces_of = gmsh.model.occ.fragment([(3, volume)], planes)
    return [tag for dim, tag in pieces_of[0] if dim == 3], [entity for entity in made if entity[0] == 2]


def _plane(occ: Any, axis: int, place: float, cutting: Cutting) -> int:
    """A rectangle across an axis that reaches beyond the whole solid."""
    low, high = cutting.origin - 0.1 * cutting.reach.max(), cutting.origin + cutting.reach + 0.1 * cutting.reach.max()
    i, j = (k for k in range(3) if k != axis)
    tags = []
    for a, b in ((low[i], low[j]), (high[i], low[j]), (high[i], high[j]), (low[i], high[j])):
        point = np.empty(3)
        point[[axis, i, j]] = place, a, b
        tags.append(occ.addPoint(*point))
    sides = [occ.addLine(a, b) for a, b in zip(tags, tags[1:] + tags[:1], strict=True)]
    return int(occ.addPlaneSurface([occ.addCurveLoop(sides)]))


def _shells(gmsh: Any, volumes: Sequence[int], cutting: Cutting, source: str) -> tuple[list[tuple[np.ndarray, Faces]], float]:
    """The shells of some volumes, and how far their facets are off curved faces.

    Raises:
        Refused: facets that stay farther off than the chord error allowed.
    """
    gmsh.model.mesh.clear()
    gmsh.model.occ.synchronize()
    faces = {tag: [f for _, f in gmsh.model.getBoundary([(3, tag)], oriented=False)] for tag in volumes}
    curves = {f: [abs(c) for _, c in gmsh.model.getBoundary([(2, f)], oriented=False)] for own in faces.values() for f in own}
    curved = {f for f in curves if gmsh.model.getType(2, f) != "Plane"}
    for curve in {c for own in curves.values() for c in own}:
        gmsh.model.mesh.setTransfiniteCurve(curve, 1 + _segments(gmsh, curve, cutting))
    gmsh.model.mesh.generate(1)
    nodes = {curve: _nodes(gmsh, curve) for curve in {c for own in curves.values() for c in own}}
    loops = {f: _loop([nodes[c] for c in own], cutting.tolerance) for f, own in curves.items() if f not in curved}
    facets = {f: strip for f in curved if (strip := _strip([nodes[c] for c in curves[f]], cutting.tolerance)) is not None}
    facets |= {f: [loop] for f, loop in loops.items() if loop is not None}
    facets |= _meshed(gmsh, curves.keys() - facets.keys(), curved)
    off = max((_off(gmsh, face, facets[face]) for face in curved), default=0.0)
    if curved and cutting.chord is not None and off > cutting.chord:
        raise Refused(f"structure.chord: {source}: some facets stay {off / cutting.chord:.3g} times the chord off; cut smaller stones")
    shells = []
    for volume in volumes:
        polygons = [polygon for f in faces[volume] for polygon in facets[f]]
        shells.append(_gathered([_on_planes(polygon, cutting) for polygon in polygons]))
    return shells, off


def _segments(gmsh: Any, curve: int, cutting: Cutting) -> int:
    """How many chords stand for a curve so that none is farther off than half the chord error: surfaces add as much again."""
    if gmsh.model.getType(1, curve) == "Line" or cutting.chord is None:
        return 1
    (start,), (end,) = gmsh.model.getParametrizationBounds(1, curve)
    closed = np.linalg.norm(np.subtract(*(gmsh.model.getValue(1, curve, [t]) for t in (start, end)))) <= cutting.tolerance
    count = 3 if closed else 1
    while count < FINEST:
        ends = gmsh.model.getValue(1, curve, np.linspace(start, end, count + 1)).reshape(-1, 3)
        middle = gmsh.model.getValue(1, curve, np.linspace(start, end, 2 * count + 1)[1::2]).reshape(-1, 3)
        if np.linalg.norm(middle - 0.5 * (ends[:-1] + ends[1:]), axis=1).max() <= 0.5 * cutting.chord:
            break
        count += 1
    return count


def _nodes(gmsh: Any, curve: int) -> np.ndarray:
    """The nodes of a curve from its start to its end; those of a closed one begin and end alike."""
    _, places, at = gmsh.model.mesh.getNodes(1, curve)
    start, end = (gmsh.model.getValue(1, curve, bound) for bound in gmsh.model.getParametrizationBounds(1, curve))
    return np.concatenate([[start], places.reshape(-1, 3)[np.argsort(at)], [end]])


def _loop(sides: Sequence[np.ndarray], tolerance: float) -> np.ndarray | None:
    """The corners of a face that its sides enclose in a single loop; None where there are several."""
    left = [np.asarray(side) for side in sides]
    loop = [left.pop(0)]
    while left:
        end = loop[-1][-1]
        k = next((k for k, side in enumerate(left) if min(np.linalg.norm(side[[0, -1]] - end, axis=1)) <= tolerance), None)
        if k is None:
            return None
        side = left.pop(k)
        loop.append(side if np.linalg.norm(side[0] - end) <= tolerance else side[::-1])
    return np.concatenate([side[:-1] for side in loop])


def _strip(sides: Sequence[np.ndarray], tolerance: float) -> list[np.ndarray] | None:
    """The facets of a face around a body, such as a drum's: between two closed curves of as many nodes; None for any other face."""
    if len(sides) != 2 or len(sides[0]) != len(sides[1]) or any(np.abs(side[0] - side[-1]).max() > tolerance for side in sides):
        return None
    below, above = sides[0][:-1], sides[1][:-1]
    turns = [np.roll(run, k, axis=0) for run in (above, above[::-1]) for k in range(len(above))]
    facing = min(turns, key=lambda turn: float(np.linalg.norm(turn - below, axis=1).sum()))
    corners = np.stack([below, np.roll(below, -1, axis=0), np.roll(facing, -1, axis=0), facing], axis=1)
    return [flat for quadrilateral in corners for flat in _flat(quadrilateral)]


def _meshed(gmsh: Any, faces: set[int], curved: set[int]) -> dict[int, list[np.ndarray]]:
    """Flat facets by gmsh's mesher, for curved faces and flat ones with holes: their corners are nodes of their sides, if it can be."""
    if not faces:
        return {}
    for name, value in (("MeshSizeExtendFromBoundary", 0), ("MeshSizeMax", 1e22), ("MeshOnlyVisible", 1)):
        gmsh.option.setNumber(f"Mesh.{name}", value)
    gmsh.model.setVisibility(gmsh.model.getEntities(), 0)
    gmsh.model.setVisibility([(2, face) for face in faces], 1, recursive=True)
    for face in faces & curved:
        if len(gmsh.model.getBoundary([(2, face)], oriented=False)) == 4:
            gmsh.model.mesh.setTransfiniteSurface(face)
            gmsh.model.mesh.setRecombine(2, face)
    gmsh.model.mesh.generate(2)
    gmsh.option.setNumber("Mesh.MeshOnlyVisible", 0)
    tags, places, _ = gmsh.model.mesh.getNodes()
    place_of = dict(zip(tags, places.reshape(-1, 3), strict=True))
    out: dict[int, list[np.ndarray]] = {}
    for face in faces:
        out[face] = []
        kinds, _, numbers = gmsh.model.mesh.getElements(2, face)
        for kind, nodes in zip(kinds, numbers, strict=True):
            corners = gmsh.model.mesh.getElementProperties(kind)[3]
            out[face] += [flat for row in nodes.reshape(-1, corners) for flat in _flat(np.array([place_of[node] for node in row]))]
    return out


def _off(gmsh: Any, face: int, facets: Sequence[np.ndarray]) -> float:
    """How far the middles of facets are off their curved face at most."""
    centres = np.array([facet.mean(axis=0) for facet in facets])
    nearest = np.reshape(gmsh.model.getClosestPoint(2, face, centres.ravel())[0], (-1, 3))
    return float(np.linalg.norm(centres - nearest, axis=1).max())


def _flat(polygon: np.ndarray) -> list[np.ndarray]:
    """A quadrilateral whose corners lie in a plane stays one; otherwise its two triangles."""
    if len(polygon) == 3:
        return [polygon]
    a, b, c, d = polygon
    size = np.linalg.norm(c - a) * np.linalg.norm(d - b)
    if abs(np.linalg.det([b - a, c - a, d - a])) <= 1e-7 * size * np.sqrt(size):
        return [polygon]
    return [polygon[[0, 1, 2]], polygon[[0, 2, 3]]]


def _on_planes(polygon: np.ndarray, cutting: Cutting) -> np.ndarray:
    """Corners put onto the planes of joints that they are close to."""
    out = polygon.copy()
    for axis in range(3):
        if axis == cutting.up:
            near = cutting.beds[np.abs(polygon[:, axis, None] - cutting.beds).argmin(axis=1)]
        else:
            half = cutting.shift or cutting.unit
            near = cutting.origin[axis] + half * np.round((polygon[:, axis] - cutting.origin[axis]) / half)
        close = np.abs(polygon[:, axis] - near) <= cutting.tolerance
        out[close, axis] = near[close]
    return out


def _gathered(polygons: Sequence[np.ndarray]) -> tuple[np.ndarray, Faces]:
    """Polygons as vertices, each corner by itself, and faces."""
    ends = np.cumsum([0, *map(len, polygons)])
    return np.concatenate(polygons), tuple(tuple(range(a, b)) for a, b in pairwise(ends))
