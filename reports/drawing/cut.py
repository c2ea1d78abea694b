# SPDX-License-Identifier: GPL-3.0-or-later
r"""Cuts a drawn structure by a plane, so that a crack map shows what goes on inside: vaults, infill, the back of a wall.

The plane is x, y or z = value. What lies on the viewer's side of it is taken away and the blocks it runs through are closed by a cap.

Polygons are clipped by :mod:`masonry_cd.mechanics.model.polygon`: a corner stays where its signed distance from the plane is above 0.
A face that is cut leaves one edge in the plane; on a closed block these edges join into loops, which are the caps. Corners in
the plane are taken to lie a little behind it, so no case is left over.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import finite_number
from masonry_cd.foundation.units import UnitError, begins_as_number, number_in
from masonry_cd.mechanics.model.polygon import clip_loops, next_in_loop
from reports.drawing.bands import Bands, DrawnJoints
from reports.drawing.parts import Lines, Surface, Ties, View, replaced

AXES = "xyz"
FACING = {"x": "side", "y": "front", "z": "top"}  # the views that look along an axis
ON_PLANE = 1e-9  # [m] corners nearer than this count as behind the plane
CAP = 0.82  # faces of a cut are darker than others by this factor
EDGE_ON = 0.05  # a plane whose normal is nearer to perpendicular to the view than this shows nothing


@dataclass(frozen=True, eq=False)
class CutPlane:
    """A plane: points X with X[axis] = value; what is kept lies on the side of ``normal``, away from the viewer."""

    axis: str
    value: float
    normal: np.ndarray  # (3,)

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance of points (N, 3) from the plane, positive where they are kept; never zero [m]."""
        d = (points[:, AXES.index(self.axis)] - self.value) * self.normal[AXES.index(self.axis)]
        return np.where(np.abs(d) < ON_PLANE, ON_PLANE, d)

    @property
    def text(self) -> str:
        """``y = 1.5 m``, to the millimetre"""
        return f"{self.axis} = {round(self.value, 3) + 0.0:g} m"


def cut_named(text: str, solids: Solids, view: View) -> CutPlane:
    """The cut that a text asks for: ``y=1.5``, or ``y`` for the middle of the structure.

    Raises:
        InputError: no such plane, one that the view sees edge-on, or one that leaves nothing of the structure.
    """
    axis, value = plane_of(text)
    k = AXES.index(axis)
    free = solids.vertices[~solids.fixed[solids.vertex_block]] if not solids.fixed.all() else solids.vertices
    low, high = float(free[:, k].min()), float(free[:, k].max())
    if value is None:
        value = (low + high) / 2.0
    if not low < value < high:
        raise InputError("cut", f"{axis} = {value:g} m does not pass through the structure, which spans {low:.4g} to {high:.4g} m")
    if abs(view.towards[k]) < EDGE_ON:
        raise InputError("cut", f"the {view.name} view sees the plane {axis} = {value:g} m edge-on; {FACING[axis]} and isometric show it")
    normal = np.zeros(3)
    normal[k] = -np.sign(view.towards[k])
    return CutPlane(axis, float(value), normal)


def plane_of(text: str) -> tuple[str, float | None]:
    """Axis and place [m] of a cut given as ``y``, without a place, or ``y=1.5``.

    Raises:
        InputError: anything else.
    """
    axis, equals, place = (part.strip() for part in text.partition("="))
    number = finite_number(place)
    known = axis in tuple(AXES)
    if known and (number is not None or not equals):
        return axis, number
    if known and begins_as_number(place):
        try:
            return axis, number_in(place, "m")
        except UnitError as fault:
            raise InputError("cut", f'"{text}" is not a plane: {fault}') from None
    raise InputError(
        "cut", f'"{text}" is not a plane; write x, y or z for the middle of the structure, or a position: y=1.5 (in m) or "y=150 cm"'
    )


def clipped(surface: Surface, cut: CutPlane) -> Surface:
    """Return the rest of a surface at a plane; caps are extra."""
    if surface.spared is None:
        return surface
    d = cut.distance(surface.points) + surface.spared
    points, start, kept = clip_loops(surface.points[surface.loops], surface.loop_start, d[surface.loops])
    owner = None if surface.owner is None else surface.owner[..., kept]
    return replaced(surface, points=points, loops=np.arange(len(points)), loop_start=start, colours=surface.colours[kept], owner=owner)


def clipped_lines(lines: Lines, cut: CutPlane) -> Lines:
    """Return the rest of straight lines at the plane."""
    ends, _ = _kept(lines.points[lines.pairs], cut)
    return replaced(lines, points=ends.reshape(-1, 3), pairs=np.arange(2 * len(ends)).reshape(-1, 2))


def clipped_ties(ties: Ties, cut: CutPlane) -> Ties:
    """Return the rest of ties at the plane."""
    ends, kept = _kept(ties.ends, cut)
    return Ties(ends, tuple(ties.texts[i] for i in kept.tolist()), ties.tension[kept])


def _kept(ends: np.ndarray, cut: CutPlane) -> tuple[np.ndarray, np.ndarray]:
    """Return the rest of lines (E, 2, 3) at the plane, and which of them each was."""
    d = cut.distance(ends.reshape(-1, 3)).reshape(-1, 2)
    kept = np.flatnonzero((d > 0).any(axis=1))
    out, d = ends[kept].copy(), d[kept]
    for k in range(2):
        crossed = d[:, k] < 0
        share = d[crossed, 1 - k] / (d[crossed, 1 - k] - d[crossed, k])
        out[crossed, k] = out[crossed, 1 - k] + share[:, None] * (out[crossed, k] - out[crossed, 1 - k])
    return out, kept


def caps_of(surface: Surface, cut: CutPlane) -> Surface:
    """The caps of closed blocks, whose faces a surface has and owns: the cut edges of the faces, joined into loops."""
    assert surface.owner is not None and surface.inside is not None
    d = cut.distance(surface.points)
    face = np.repeat(np.arange(len(surface.loop_start) - 1), np.diff(surface.loop_start))
    a = surface.loops
    following = next_in_loop(surface.loop_start)
    b = a[following]
    leaves, enters = (d[a] > 0) & (d[b] < 0), (d[a] < 0) & (d[b] > 0)
    share = (d[a] / np.where(leaves | enters, d[a] - d[b], 1.0))[:, None]
    place = surface.points[a] + share * (surface.points[b] - surface.points[a])
    edge = {(int(a[k]), int(b[k])): k for k in np.flatnonzero(enters).tolist()}
    out_of = {int(face[k]): k for k in np.flatnonzero(leaves).tolist()}  # a convex face is left once
    loops: list[list[int]] = []
    seen: set[int] = set()
    for first in np.flatnonzero(enters).tolist():  # walk: along the cut of a face, over the edge, into the neighbour that shares it
        loop: list[int] = []
        at = first
        while at >= 0 and at not in seen:
            seen.add(at)
            loop.append(at)
            leave = out_of.get(int(face[at]), -1)
            at = edge.get((int(b[leave]), int(a[leave])), -1) if leave >= 0 else -1
        if len(loop) >= 3:
            loops.append(loop)
    flat = np.array([k for loop in loops for k in loop], dtype=np.int64)
    start = np.cumsum([0, *map(len, loops)])
    block = surface.owner[face[flat[start[:-1]]]] if loops else np.zeros(0, dtype=np.int64)
    colours = (CAP * surface.inside[block]).astype(np.uint8)
    return Surface(place[flat], np.arange(len(flat)), start, colours, lit=False, owner=block, spared=None)


def outline(surface: Surface, colour: str, width: float) -> Lines:
    """The edges of the polygons of a surface, just before them."""
    pairs = np.stack([surface.loops, surface.loops[next_in_loop(surface.loop_start)]], axis=1)
    return Lines(surface.points, pairs, colour, width, lift=5e-4, outline=True)


def traces(joints: DrawnJoints, cut: CutPlane) -> Bands:
    """Where the plane runs through the joints shown: a quadrilateral each, from the cut of the band on a to that on b."""
    on_a, on_b = joints.band_corners()
    d = cut.distance((on_a + on_b) / 2.0)
    following = next_in_loop(joints.start)
    k = np.flatnonzero(joints.shown[joints.owner] & (d * d[following] < 0))
    _, count = np.unique(joints.owner[k], return_counts=True)
    k = k[np.repeat(count == 2, count)]  # interface polygons are convex: crossed twice or not at all
    share = (d[k] / (d[k] - d[following[k]]))[:, None]
    a, b = (side[k] + share * (side[following[k]] - side[k]) for side in (on_a, on_b))
    corners = np.stack([a[0::2], a[1::2], b[1::2], b[0::2]], axis=1)
    corners[..., AXES.index(cut.axis)] = cut.value
    return Bands(corners, joints.owner[k[0::2]])
