"""The crack map as polygons, in SVG and PDF: sharp at any size, and open to a drawing program.

It shows what :mod:`reports.maps.crack_map` shows. Instead of a depth buffer it paints the farther polygons first: blocks in the order of
:mod:`reports.maps.painter`, of each the faces that look at the viewer, the band of a joint as soon as both of its blocks are painted. Of a
cut structure the caps and the joints in the plane come last, since nothing lies before them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.deformed import frame_index
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.geometry import area_vectors
from masonry_cd.mechanics.model.polygon import next_in_loop
from reports.drawing.figure import Sheet
from reports.drawing.render import AMBIENT, LIGHTS, Surface, View
from reports.drawing.structure_picture import EDGE, rgb
from reports.drawing.tie_lines import PULLING, SLACK, DrawnTies
from reports.maps.bands import Bands, dashes, face_plates, joint_bands
from reports.maps.crack_key import PARTED, draw_scales
from reports.maps.crack_map import draw_around, subject_of, thrust_layer, ties_of
from reports.maps.cut import Cut, caps_of, clipped
from reports.maps.framing import MapStyle, framing
from reports.maps.layers import (
    CAP,
    Subject,
    band_width,
    block_colours,
    face_colours,
    marked_joints,
    shadow,
    some_polygons,
    standing_faces,
    trace_bands,
)
from reports.maps.painter import EDGE_ON, painting_order, rows_by_block

NAMES = ("crack_map.svg", "crack_map.pdf")
OUTLINE = 0.55  # width of the edges of blocks [points]
NEAR = 1e-3  # how far beside a joint it is asked what covers it, as a share of the joint's extent
FIXED_TEXTS: dict[Any, Any] = {"svg.hashsalt": "masonry_cd", "svg.fonttype": "path", "pdf.fonttype": 42}


@dataclass(eq=False)
class _Painting:
    """Polygons with the rank in which they are painted."""

    view: View
    rank: list[float] = field(default_factory=list)
    polygons: list[np.ndarray] = field(default_factory=list)  # (n, 2) each, in the plane of the picture [m]
    colours: list[np.ndarray] = field(default_factory=list)  # (3,) each, 0..1
    outlined: list[bool] = field(default_factory=list)

    def add(self, surface: Surface, colours: np.ndarray, rank: np.ndarray, outlined: bool = False) -> None:
        """Add the polygons of a surface, with colours (F, 3) 0..1 and ranks (F,)."""
        flat = self.view.plane(surface.points)
        for loop, colour, place in zip(np.split(surface.loops, surface.loop_start[1:-1]), colours, rank.tolist(), strict=True):
            self.polygons.append(flat[loop])
            self.colours.append(colour)
            self.rank.append(place)
            self.outlined.append(outlined)


def vector_maps(results: Results, folder: Path, style: MapStyle, frame: int = -1) -> list[Path]:
    """Draw the crack map of a frame into ``crack_map.svg`` and ``crack_map.pdf``; return the files.

    Raises:
        InputError: no such frame, view or plane, or a folder that cannot be written into.
    """
    frame = frame_index(results, frame)
    framed = framing(results, [frame], style)
    subject = subject_of(results, frame, framed)
    sheet = Sheet(framed.plan)
    ties = ties_of(results, subject)
    force = draw_polygons(sheet, results, frame, subject, ties)
    key = draw_around(sheet, subject, results.title, force, len(ties.ends))
    draw_scales(sheet, key)
    return save_vector(sheet, [folder / name for name in NAMES], results.title or "Crack map")


def draw_polygons(sheet: Sheet, results: Results, frame: int, subject: Subject, ties: DrawnTies) -> float | None:
    """Draw the model into a sheet as polygons; return the force of the widest ribbon [N], None where forces are not drawn."""
    painting, force = _painted(results, frame, subject)
    axes = _place(sheet, painting, subject)
    for (start, end), text, tension in zip(ties.ends, ties.texts, ties.tension, strict=True):
        _draw_tie(axes, subject.framed.view.plane(np.stack([start, end])), text, tension > 0.0)
    return force


def save_vector(sheet: Sheet, paths: list[Path], title: str) -> list[Path]:
    """Write a sheet of polygons as SVG and PDF, by the endings of the paths; return these.

    Raises:
        InputError: a file that cannot be written.
    """
    import matplotlib

    with matplotlib.rc_context(FIXED_TEXTS):
        for path in paths:
            undated: dict[str, Any] = {"Date": None} if path.suffix == ".svg" else {"CreationDate": None}
            try:
                with replacing(path) as part:
                    sheet.figure.savefig(part, format=path.suffix[1:], metadata={"Title": title} | undated)
            except OSError as error:
                raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    return paths


def _painted(results: Results, frame: int, subject: Subject) -> tuple[_Painting, float | None]:
    """All polygons of a sheet, and the force of the widest ribbon [N]."""
    framed, solids = subject.framed, subject.solids
    painting, last = _Painting(framed.view), float(len(solids.centre))
    behind = shadow(subject)
    painting.add(behind, behind.colours / 255.0, np.full(len(behind.loop_start) - 1, -1.0))
    normals = area_vectors(subject.drawn, solids.loops, solids.loop_start)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    rank = painting_order(solids, subject.drawn, normals, framed.view).astype(float)
    _add_faces(painting, subject, normals, rank)
    _add_joints(painting, subject, rank)
    if framed.cut is not None:
        _add_cut(painting, subject, framed.cut, last)
    if not framed.style.thrust:
        return painting, None
    ribbons, force = thrust_layer(results, frame, subject)
    painting.add(ribbons, ribbons.colours / 255.0, np.full(len(ribbons.loop_start) - 1, last + 3.0))
    return painting, force


def _kept(surface: Surface, cut: Cut | None) -> tuple[Surface, np.ndarray]:
    """What a cut leaves of a surface, and which of its polygons (P,) each was."""
    numbered = Surface(surface.points, surface.loops, surface.loop_start, np.arange(len(surface.loop_start) - 1), lit=False)
    left = clipped(numbered, cut) if cut is not None else numbered
    return left, left.colours


def _add_faces(painting: _Painting, subject: Subject, normals: np.ndarray, rank: np.ndarray) -> None:
    """The faces of the blocks that look at the viewer, shaded as in the picture; edges with them."""
    solids, view = subject.solids, subject.framed.view
    colours = face_colours(subject)
    seen = normals @ view.towards > 1e-6
    light = np.full(len(normals), AMBIENT)
    for (right, up, towards), strength in LIGHTS:
        direction = right * view.right + up * view.up + towards * view.towards
        light += strength * np.maximum(normals @ (direction / np.linalg.norm(direction)), 0.0)
    faces = Surface(subject.drawn, solids.loops, solids.loop_start, colours)
    left, which = _kept(some_polygons(faces, seen), subject.framed.cut)
    face = np.flatnonzero(seen)[which]
    painting.add(left, np.clip(colours[face] * light[face, None], 0.0, 1.0), rank[solids.face_block[face]], outlined=True)


def _add_joints(painting: _Painting, subject: Subject, rank: np.ndarray) -> None:
    """The bands of opened and slid joints, and the dark faces of separated ones, after both of their blocks."""
    joints, solids, framed, width = subject.joints, subject.solids, subject.framed, band_width(subject)
    marked, first, second = marked_joints(subject, subject.framed.scales)
    standing = standing_faces(subject)
    after = np.maximum(rank[joints.block_a], rank[joints.block_b]) + 0.5
    dark = np.tile((255 * rgb(PARTED)).astype(np.uint8), (joints.count, 1))
    hidden_a, hidden_b = hidden_sides(subject)
    corner_joint = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    pieces = []
    if marked.any():
        bands = joint_bands(joints, marked, solids, subject.pose, framed.factor, width)
        pieces.append((bands, (hidden_a | hidden_b)[marked[corner_joint]], (first, second)))
    if np.any(standing):
        plates = face_plates(joints, standing, solids, subject.pose, framed.factor, 0.7 * width)
        hidden = np.concatenate([side[drawn[corner_joint]] for side, drawn in zip((hidden_a, hidden_b), standing, strict=True)])
        pieces.append((plates, hidden, (dark, dark)))
    for every, hidden, (first, second) in pieces:
        bands = _seen(Bands(every.corners[~hidden], every.joint[~hidden]), framed.view)
        surface, side = dashes(bands, first, second, width)
        left, which = _kept(surface, framed.cut)
        painting.add(left, surface.colours[which] / 255.0, after[bands.joint[side[which]]])


def hidden_sides(subject: Subject) -> tuple[np.ndarray, np.ndarray]:
    """(N,) each: whether the side of a joint's polygon that begins at a corner lies behind block a of its joint, and behind block b.

    The block on the viewer's side of a joint hides a side over which it reaches out, as a stone does above a head joint.
    """
    joints, solids, towards = subject.joints, subject.solids, subject.framed.view.towards
    joint = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    middle = (joints.polygon + joints.polygon[next_in_loop(joints.polygon_start)]) / 2.0
    outward = middle - joints.centres()[joint]
    faces = rows_by_block(solids.face_block, len(solids.centre))
    foot = np.einsum("fi,fi->f", solids.face_normals, solids.vertices[solids.loops[solids.loop_start[:-1]]])
    out = []
    for block, sign in ((joints.block_a, -1.0), (joints.block_b, 1.0)):
        normal = sign * np.einsum("jik,jk->ji", subject.pose.rotation[block], joints.normal)
        towards_viewer = normal @ towards > EDGE_ON
        inside = middle + NEAR * outward + NEAR * sign * joints.normal[joint] * np.linalg.norm(outward, axis=1, keepdims=True)
        hidden = np.zeros(len(joint), bool)
        for k in np.flatnonzero(towards_viewer[joint]).tolist():
            own = faces[block[joint[k]]]
            hidden[k] = bool((solids.face_normals[own] @ inside[k] < foot[own]).all())
        out.append(hidden)
    return out[0], out[1]


def _seen(bands: Bands, view: View) -> Bands:
    """The sides of bands that look at the viewer: outward from the middle of their joint."""
    middle = bands.corners.mean(axis=1)
    joints, row = np.unique(bands.joint, return_inverse=True)
    centre = np.stack([np.bincount(row, axis, len(joints)) for axis in middle.T], axis=1) / np.bincount(row)[:, None]
    along, across = bands.corners[:, 1] - bands.corners[:, 0], bands.corners[:, 3] - bands.corners[:, 0]
    normal = np.cross(along, across)
    normal *= np.sign(np.einsum("si,si->s", normal, middle - centre[row]))[:, None]
    seen = normal @ view.towards > 1e-6 * np.linalg.norm(normal, axis=1)
    return Bands(bands.corners[seen], bands.joint[seen])


def _add_cut(painting: _Painting, subject: Subject, cut: Cut, last: float) -> None:
    """The caps of the cut blocks, then the joints in the plane."""
    caps, width = caps_of(subject.solids, subject.drawn, cut), band_width(subject)
    surface = Surface(caps.points, caps.loops, caps.loop_start, caps.block)
    painting.add(surface, CAP * block_colours(subject)[caps.block], np.full(len(caps.block), last + 1.0), outlined=True)
    marked, first, second = marked_joints(subject, subject.framed.scales)
    lines, _ = dashes(trace_bands(subject, marked, width), first, second, width)
    painting.add(lines, lines.colours / 255.0, np.full(len(lines.loop_start) - 1, last + 2.0))


def _draw_tie(axes: Any, ends: np.ndarray, text: str, pulls: bool) -> None:
    """Draw a tie by its ends (2, 2) in the plane of the picture [m], with its label beside its middle."""
    colour = PULLING if pulls else SLACK
    axes.plot(*ends.T, color=colour, linewidth=1.6, solid_capstyle="butt")
    axes.annotate(text, ends.mean(axis=0), (0, 5), textcoords="offset points", color=colour, fontsize=6, ha="center")


def _place(sheet: Sheet, painting: _Painting, subject: Subject) -> Any:
    """Put the polygons into the model's area of the sheet; return its axes."""
    from matplotlib.collections import PolyCollection

    window, axes = subject.framed.window, sheet.axes(*sheet.plan.model)
    axes.set_xlim(window.left, window.right)
    axes.set_ylim(window.bottom, window.top)
    order = np.argsort(painting.rank, kind="stable")
    colours = np.array([painting.colours[k] for k in order]).reshape(-1, 3)
    edges = [EDGE if painting.outlined[k] else tuple(painting.colours[k]) for k in order]  # of their own colour, or seams would show
    widths = [OUTLINE if painting.outlined[k] else 0.15 for k in order]
    polygons = [painting.polygons[k] for k in order]
    axes.add_collection(PolyCollection(polygons, facecolors=colours, edgecolors=edges, linewidths=widths, joinstyle="round"))
    return axes
