"""The layers of a map: the shape at rest, the blocks, and the bands of the joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.mechanics.model.joints import Joints
from reports.drawing.palette import CRUSHED
from reports.drawing.render import Layer, Lines, Surface
from reports.drawing.structure_picture import EDGE, SUPPORT, face_layers, rgb, stone_colours
from reports.maps.bands import Bands, band_corners, dashed, face_plates, joint_bands
from reports.maps.crack_key import FALLEN, PARTED, SHADOW, STONE, Marks, Scale
from reports.maps.cut import caps_of, clipped, clipped_lines, traces
from reports.maps.framing import Framing, largest_displacement

BAND = 6.0  # width of a closed joint's band [pixels]
BAND_OF_BLOCK = 0.2  # ... but no more than this share of a block's smallest extent
LEAST_BAND = 2.5  # ... and no less than this [pixels]
STRONG = "#1b2a6b"  # of joints that a map points out
CAP = 0.82  # faces of a cut are darker than others by this factor


@dataclass(frozen=True, eq=False)
class Subject:
    """What a sheet shows."""

    framed: Framing
    joints: Joints
    solids: Solids
    snapshot: DamageSnapshot
    last: bool  # the last frame
    marks: Marks
    drawn: np.ndarray  # (V, 3) vertices where they are drawn [m]
    provisional: str  # of the last frame: why it is not the end, in words
    suffered: str  # of the last frame: the damage over all steps, in words
    tint: np.ndarray | None = None  # (B, 3) colours of the blocks, 0..1; None: by their state
    face_tint: np.ndarray | None = None  # (F, 3) colours of the faces of meshed blocks, NaN of others; None: no block is meshed
    strong: np.ndarray | None = None  # (J,) joints drawn in one dark colour; None: those that opened or slid, by how far

    @property
    def pose(self) -> Pose:
        """Where the blocks are."""
        return self.snapshot.pose

    @property
    def down(self) -> np.ndarray:
        """(B,) fallen blocks."""
        return self.snapshot.down

    @property
    def largest(self) -> float:
        """Largest displacement of a free block relative to the base at this frame [m]."""
        return largest_displacement(self.pose, self.solids)


def shadow(subject: Subject) -> Surface:
    """The free blocks at rest, pale, behind everything: seen only where the structure has moved away."""
    solids, framed = subject.solids, subject.framed
    towards = framed.view.towards
    behind = float((solids.vertices @ towards).max() - (subject.drawn @ towards).min()) + 0.01 * framed.window.height
    colours = np.tile((255 * rgb(SHADOW)).astype(np.uint8), (len(solids.face_block), 1))
    faces = Surface(solids.vertices, solids.loops, solids.loop_start, colours, lit=False)
    free = some_polygons(faces, ~solids.fixed[solids.face_block])
    left = clipped(free, framed.cut) if framed.cut is not None else free
    return Surface(left.points - behind * towards, left.loops, left.loop_start, left.colours, lit=False)


def some_polygons(surface: Surface, chosen: np.ndarray) -> Surface:
    """The polygons chosen (F,) of a surface."""
    sides = np.diff(surface.loop_start)
    loops = surface.loops[np.repeat(chosen, sides)]
    return Surface(surface.points, loops, np.cumsum([0, *sides[chosen]]), surface.colours[chosen], surface.lit)


def block_colours(subject: Subject) -> np.ndarray:
    """(B, 3) colours of the blocks, 0..1."""
    colours = np.where(subject.down[:, None], rgb(FALLEN), rgb(STONE)) if subject.tint is None else subject.tint.copy()
    colours[subject.solids.fixed] = rgb(SUPPORT)
    return np.asarray(colours)


def face_colours(subject: Subject) -> np.ndarray:
    """(F, 3) colours of the faces, 0..1, as stones of one colour differ."""
    colours = stone_colours(subject.solids, block_colours(subject))
    return colours if subject.face_tint is None else np.where(np.isnan(subject.face_tint), colours, subject.face_tint)


def block_layers_of(subject: Subject) -> list[Layer]:
    """Faces and edges of the blocks; where they are cut, with caps in a darker tone."""
    solids, framed, colours = subject.solids, subject.framed, block_colours(subject)
    whole = face_layers(solids, subject.drawn, face_colours(subject), framed.view, framed.window)
    if framed.cut is None:
        return list(whole)
    layers: list[Layer] = [
        clipped(layer, framed.cut) if isinstance(layer, Surface) else clipped_lines(layer, framed.cut) for layer in whole
    ]
    caps = caps_of(solids, subject.drawn, framed.cut)
    shade = (255 * CAP * colours[caps.block]).astype(np.uint8)
    lift = 5e-4 * framed.window.height * framed.view.towards
    outline = caps.outline(EDGE, 1.2 if len(caps.block) < 2000 else 0.7)
    return [
        *layers,
        Surface(caps.points, caps.loops, caps.loop_start, shade, lit=False),
        Lines(outline.points + lift, outline.pairs, outline.colour, outline.width),
    ]


def joint_layers(subject: Subject, scales: tuple[Scale, Scale]) -> list[Surface]:
    """One surface for the bands of opened and slid joints, one for the parted faces of blocks that still stand."""
    joints, solids, framed = subject.joints, subject.solids, subject.framed
    standing = standing_faces(subject)
    layers = coloured_bands(subject, *marked_joints(subject, scales))
    if np.any(standing):
        width = band_width(subject)
        dark = np.tile((255 * rgb(PARTED)).astype(np.uint8), (joints.count, 1))
        plates = dashed(face_plates(joints, standing, solids, subject.pose, framed.factor, 0.7 * width), dark, dark, width)
        layers.append(lifted(plates, framed, cut=True))
    return layers


def coloured_bands(subject: Subject, drawn: np.ndarray, first: np.ndarray, second: np.ndarray) -> list[Surface]:
    """The bands of the joints drawn (J,), dashed in two colours (J, 3) uint8; where it is cut, in its plane as well."""
    if not drawn.any():
        return []
    framed, width = subject.framed, band_width(subject)
    bands = joint_bands(subject.joints, drawn, subject.solids, subject.pose, framed.factor, width)
    layers = [lifted(dashed(bands, first, second, width), framed, cut=True)]
    if framed.cut is not None:
        layers.append(lifted(dashed(trace_bands(subject, drawn, width), first, second, width), framed, cut=False))
    return layers


def standing_faces(subject: Subject) -> list[np.ndarray]:
    """(J,) whether the face on block a, and that on block b, of a separated joint is drawn: that of a block which stands."""
    blocks = (subject.joints.block_a, subject.joints.block_b)
    return [subject.marks.separated & ~subject.down[block] for block in blocks]


def band_width(subject: Subject) -> float:
    """Of a closed joint [m]."""
    solids, pixel = subject.solids, subject.framed.pixel
    smallest = float(np.median(solids.sizes[~solids.fixed].min(axis=1))) if not solids.fixed.all() else np.inf
    return max(LEAST_BAND * pixel, min(BAND * pixel, BAND_OF_BLOCK * smallest))


def marked_joints(subject: Subject, scales: tuple[Scale, Scale]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which joints are drawn (J,) bool, and the two colours (J, 3) that the dashes of each alternate between."""
    marks = subject.marks
    if subject.strong is None:
        crushed = np.zeros_like(marks.opened) if marks.crushed is None else marks.crushed
        return (marks.opened | marks.slid | crushed, *band_colours(marks, scales))
    dark = np.tile((255 * rgb(STRONG)).astype(np.uint8), (subject.joints.count, 1))
    return subject.strong, dark, dark


def band_colours(marks: Marks, scales: tuple[Scale, Scale]) -> tuple[np.ndarray, np.ndarray]:
    """(J, 3) the two colours that the dashes of each joint alternate between."""
    opening, sliding = scales[0](marks.opening), scales[1](marks.sliding)
    first = np.where(marks.opened[:, None], opening, sliding)
    white = np.full_like(first, 255)
    second = np.where(~marks.slid[:, None], opening, np.where(marks.opened[:, None], sliding, white))
    if marks.crushed is not None:
        first = np.where((marks.crushed & ~marks.opened & ~marks.slid)[:, None], white, first)
        second = np.where(marks.crushed[:, None], (255 * rgb(CRUSHED)).astype(np.uint8), second)
    return first, second


def trace_bands(subject: Subject, marked: np.ndarray, width: float) -> Bands:
    """The bands of the joints in the plane of the cut."""
    framed = subject.framed
    assert framed.cut is not None
    on_a, on_b = band_corners(subject.joints, subject.solids, subject.pose, framed.factor, width)
    return traces(subject.joints, on_a, on_b, marked, framed.cut)


def lifted(surface: Surface, framed: Framing, cut: bool) -> Surface:
    """A surface a little before the blocks; clipped first if it is to be cut."""
    lift = 1e-3 * framed.window.height * framed.view.towards
    left = clipped(surface, framed.cut) if cut and framed.cut is not None else surface
    return Surface(left.points + lift, left.loops, left.loop_start, left.colours, lit=False)
