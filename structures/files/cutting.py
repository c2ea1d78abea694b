# SPDX-License-Identifier: GPL-3.0-or-later
"""A solid cut into the shells of its stones by the OpenCASCADE kernel, in a child process, see :mod:`structures.files.foreign`.

The volumes of a CAD model or of a gmsh script are cut by the level planes of the beds, and each body of a course by upright planes across
the plan. What comes back are facets, each with corners of its own, in the units and axes of the file: :mod:`structures.kinds.solid`
says how the planes are chosen, and makes blocks of them. This module imports nothing but numpy, and gmsh when it is called.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from structures.files.facets import curved_faces, gathered, left_out, opened, shells_of
from structures.files.foreign import FileContents, FileShell, Refused
from structures.size import MOST, beyond

NARROW = 0.25  # no joint closer to the end of a body, or to the face of a wall along it, than this share of a stone
ALONG = 0.75  # a plane runs along a wall that ends near it where, so far next to it, there is less than this share of what it cuts
TRIANGLE = 2  # gmsh's number of this type of element


@dataclass(frozen=True)
class CuttingTask:
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


def cut(path: Path, **asked: Any) -> FileContents:
    """Cut the solids of a file.

    Args:
        asked: the keys of :class:`Asked`.

    Returns:
        the stones, each with its course, its group and its facets, whose corners are not joined yet; and three figures: the volume of the
        solids, how many faces are curved, and how far facets are off them, in units of the file.

    Raises:
        Refused: a file that cannot be read, curved faces without ``chord``, or facets that stay farther off.
    """
    with opened(path) as gmsh:
        unread = left_out(gmsh, path)
        cutting = _cutting(gmsh, CuttingTask(**asked))
        whole = sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.occ.getEntities(3))
        curved = curved_faces(gmsh, cutting.chord, path.name)
        stones, off = _stones(gmsh, cutting, path.name)
    return FileContents(stones, (whole, float(curved), off), unread)


def _cutting(gmsh: Any, asked: CuttingTask) -> Cutting:
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
    too_many = beyond(max(courses, whole / stone if stone > 0.0 else np.inf), asked.most_blocks)
    if too_many:
        raise Refused("structure.course_height", too_many)
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


def _stones(gmsh: Any, cutting: Cutting, source: str) -> tuple[list[FileShell], float]:
    """Cut all volumes, first by the beds, then each body of a course across the plan; the stones, and how far facets are off.

    A course leaves the kernel when its shells are read: the cost of an operation grows with all that is in there.
    """
    outlines = _outlines(gmsh, cutting)
    groups = {}
    for volume in outlines:
        names = [gmsh.model.getPhysicalName(3, tag) for tag in gmsh.model.getPhysicalGroupsForEntity(3, volume)]
        groups[volume] = next((name for name in names if name), "block")
    done: list[FileShell] = []
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
            shells, here = shells_of(gmsh, stones, cutting.chord, cutting.tolerance, source)
            gmsh.model.occ.remove([*((3, stone) for stone in stones), *loose], recursive=True)
            done += [FileShell(course, groups[volume], *gathered([_on_planes(facet, cutting) for facet in shell])) for shell in shells]
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
    margin = NARROW * cutting.unit
    inside = places[(places > box[axis] + margin) & (places < box[axis + 3] - margin)]
    offsets = np.array([-margin, -10.0 * cutting.tolerance, 10.0 * cutting.tolerance, margin])
    other = next(k for k in cutting.plan if k != axis)
    column = cutting.plan.index(axis)
    lengths = [_length(plan, column, place + d, box[other], box[other + 3]) for place in inside for d in offsets]
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
