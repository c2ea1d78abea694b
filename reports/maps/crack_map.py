r"""The crack map: the structure as it stands at a frame, its joints coloured by what is left open and what has slid.

An open joint is a solid band coloured by its opening, a slid one is dashed and coloured by its sliding, in another hue; where
both happened the dashes lie on the band. So the two are told apart in colour, by a colour-blind reader, and in grey print. The
classes of both scales run 1-2-5 from the threshold of damage to ``largest``: equal thresholds give equal colours, and the maps of
two runs can be laid side by side. Faces of standing blocks that have parted are dark. Where nothing would be seen at true scale,
displacements relative to the base are drawn amplified by a factor that the sheet states; the shape at rest lies behind as a pale
shadow. A cut takes away what lies before a plane (:mod:`reports.maps.cut`); the forces are drawn on request (:mod:`reports.maps.thrust`).

The maps of one :class:`Framing` share view, amplification, window and colours: what changes between them is damage.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from masonry_cd.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.model.joints import Joints
from reports.damage.definitions import Thresholds
from reports.damage.end_state import end_state
from reports.damage.joint_damage import fallen, in_words, joint_damage
from reports.damage.macro_elements import DamageSnapshot
from reports.deformed import Pose, Solids, frame_index, solids_of
from reports.drawing.figure import Layout, Sheet, in_metres, layout, nice
from reports.drawing.render import SAMPLES, Canvas, Layer, Lines, Surface, View, Window, view_named
from reports.drawing.structure_picture import EDGE, SUPPORT, auto_view, block_layers, rgb, structure_window
from reports.drawing.tie_lines import ties_at
from reports.maps.bands import Bands, band_corners, dashed, face_plates, joint_bands
from reports.maps.crack_key import (
    FALLEN,
    OPENING_COLOURS,
    PARTED,
    SHADOW,
    SLIDING_COLOURS,
    STONE,
    Key,
    Marks,
    Scale,
    draw_scales,
    draw_signs,
)
from reports.maps.cut import FACING, Cut, axis_of, caps_of, clipped, clipped_lines, cut_named, traces
from reports.maps.thrust import WIDEST, ribbons

BAND = 6.0  # width of a closed joint's band [pixels]
BAND_OF_BLOCK = 0.2  # ... but no more than this share of a block's smallest extent
LEAST_BAND = 2.5  # ... and no less than this [pixels]
SEEN = 0.02  # amplified displacements reach at most this share of the picture
REACH = 0.35  # the picture follows blocks by at most this share of the structure's extent
COLLAPSE = 1.0  # ... and where blocks have fallen, so that a heap of rubble is held
MOST = 1000.0  # largest amplification
CAP = 0.82  # faces of a cut are darker than others by this factor


@dataclass(frozen=True)
class MapStyle:
    """How crack maps are drawn.

    Attributes:
        view: auto (front where all blocks are prisms across y, else isometric), front, back, side, top or isometric.
        scale: amplification of the displacements; None picks 1, or what makes the largest one visible.
        thresholds: where an opening and a sliding begin to be drawn.
        largest: where the last class of the colour scales begins [m].
        cut: a plane to cut by, ``y=1.5`` or ``y`` for the middle; empty for none. The view is then by default the one that faces it.
        thrust: draw the line of thrust.
    """

    view: str = "auto"
    scale: float | None = None
    thresholds: Thresholds = field(default_factory=Thresholds)
    largest: float = 0.05
    cut: str = ""
    thrust: bool = False

    def __post_init__(self) -> None:
        if self.scale is not None and not (np.isfinite(self.scale) and self.scale > 0):
            raise InputError(f"scale: must be positive, got {self.scale!r}")
        if not self.largest > max(self.thresholds.opened, self.thresholds.slid):
            raise InputError(f"largest: must lie above the thresholds, got {self.largest!r}")


def crack_map(results: Results, path: Path, *, frame: int = -1, style: MapStyle | None = None) -> None:
    """Draw the crack map of a frame into a PNG.

    Args:
        results: of a run.
        path: of the PNG.
        frame: which; negative ones count from the end.
        style: view, amplification, thresholds and so on.

    Raises:
        InputError: no such frame, view or plane, no off-screen OpenGL, or a path that cannot be written.
    """
    style = style or MapStyle()
    frame = frame_index(results, frame)
    sheet_of(results, frame, framing(results, [frame], style)).save(path)


@dataclass(frozen=True, eq=False)
class Framing:
    """What all maps of a sequence have in common."""

    style: MapStyle
    view: View
    cut: Cut | None
    factor: float  # amplification of displacements
    window: Window
    plan: Layout
    alone: bool  # a single map, whose key names only what it shows

    @property
    def pixel(self) -> float:
        """Size of a pixel [m]."""
        return self.window.width / self.plan.pixels[0]


def view_and_cut(solids: Solids, style: MapStyle) -> tuple[View, Cut | None]:
    """The view that a style asks for, and its cut.

    Raises:
        InputError: no such view or plane, or one that shows nothing of the structure.
    """
    facing = FACING[axis_of(style.cut)] if style.cut else auto_view(solids)
    view = view_named(facing if style.view == "auto" else style.view)
    return view, cut_named(style.cut, solids, view) if style.cut else None


def framing(results: Results, frames: Sequence[int], style: MapStyle) -> Framing:
    """Choose view, amplification and window so that they suit all frames.

    Raises:
        InputError: no such view or plane.
    """
    solids = solids_of(results.blocks)
    view, cut = view_and_cut(solids, style)
    rest = structure_window(solids, view)
    poses = [Pose.of(results, solids, frame) for frame in frames]
    farthest = max(range(len(frames)), key=lambda k: largest_displacement(poses[k], solids))
    fell = np.any([fallen(results, style.thresholds, frames[k]) for k in {farthest, len(frames) - 1}], axis=0)
    factor = style.scale if style.scale is not None else amplification(poses[farthest], solids, fell, max(rest.width, rest.height))
    free, window = ~solids.fixed[solids.vertex_block], rest
    for pose in poses:
        moved = pose.moved(solids, solids.vertices[free], solids.vertex_block[free], factor)
        window = window.joined(followed(rest, view.plane(moved), COLLAPSE if fell.any() else REACH))
    plan = layout(window.width / window.height)
    return Framing(style, view, cut, factor, window.fitted(plan.pixels), plan, alone=len(frames) == 1)


def sheet_of(results: Results, frame: int, framed: Framing, samples: int = SAMPLES) -> Sheet:
    """The sheet of a frame; ``samples`` as in :func:`reports.drawing.render.render`."""
    with Canvas(framed.view, framed.plan.pixels, samples) as canvas:
        sheet, key = sheet_and_key(results, frame, framed, canvas)
    draw_scales(sheet, key)
    return sheet


def sheet_and_key(results: Results, frame: int, framed: Framing, canvas: Canvas) -> tuple[Sheet, Key]:
    """The sheet of a frame without the scales of its key, which a sequence draws once, and what the key says."""
    subject = _subject(results, frame, framed)
    thresholds, largest = framed.style.thresholds, framed.style.largest
    scales = Scale(thresholds.opened, largest, OPENING_COLOURS), Scale(thresholds.slid, largest, SLIDING_COLOURS)
    layers = [_shadow(subject), *_block_layers(subject), *_joint_layers(subject, scales)]
    force = None
    if framed.style.thrust:
        thrust, force = _thrust_layer(results, frame, subject)
        layers.append(thrust)
    ties = ties_at(results, subject.solids, subject.pose, framed.factor)
    layers += ties.layers(framed.view, float((subject.drawn @ framed.view.towards).max()) + 0.02 * framed.window.height)
    sheet = Sheet(framed.plan)
    sheet.model(ties.labelled(canvas.draw(layers, framed.window), framed.view, framed.window))
    sheet.head(results.title or "Crack map", _facts(subject))
    key = Key(
        marks=subject.marks,
        scales=scales,
        when="Present" if not (subject.last and framed.alone) else "Provisional" if subject.provisional else "Residual",
        down=int(subject.down.sum()),
        outside=_outside(subject),
        moved=framed.factor * subject.largest > 2 * framed.pixel,
        alone=framed.alone,
        force=force,
        pixel=framed.pixel,
        view=framed.view,
        ties=len(ties.ends),
    )
    draw_signs(sheet, key)
    return sheet, key


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
        """Largest displacement of a free block relative to the base [m]."""
        return largest_displacement(self.pose, self.solids)


def _subject(results: Results, frame: int, framed: Framing) -> Subject:
    """Collect what a frame shows."""
    solids, thresholds = solids_of(results.blocks), framed.style.thresholds
    snapshot, last = DamageSnapshot.at(results, frame, thresholds), frame == results.frames - 1
    return Subject(
        framed=framed,
        joints=results.joints,
        solids=solids,
        snapshot=snapshot,
        last=last,
        marks=Marks.of(snapshot),
        drawn=snapshot.pose.moved(solids, solids.vertices, solids.vertex_block, framed.factor),
        provisional=end_state(results, thresholds).provisional if last else "",
        suffered=in_words(joint_damage(results, thresholds)) if last and framed.alone else "",
    )


def largest_displacement(pose: Pose, solids: Solids) -> float:
    """Largest displacement of a free block's centre relative to the base [m]."""
    return float(np.linalg.norm(pose.displacement(solids)[~solids.fixed], axis=1).max(initial=0.0))


def amplification(pose: Pose, solids: Solids, down: np.ndarray, size: float) -> float:
    """1 where a displacement can be seen in a picture of a size [m] or blocks have fallen, else a round factor that shows it."""
    largest = largest_displacement(pose, solids)
    if down.any() or MOST * largest < SEEN / 10 * size:
        return 1.0  # what has fallen is seen as it is, and what no amplification shows is left alone
    return float(np.clip(nice(SEEN * size / largest), 1.0, MOST))


def followed(rest: Window, moved: np.ndarray, share: float = REACH) -> Window:
    """The window at rest, extended to points (N, 2) that have moved out of it, but for those flung farther than a share of its size."""
    reach, pad = share * max(rest.width, rest.height), 0.03 * max(rest.width, rest.height)
    low, high = np.array([rest.left, rest.bottom]), np.array([rest.right, rest.top])
    near = moved[((moved > low - reach) & (moved < high + reach)).all(axis=1)]
    if not len(near):
        return rest
    (left, bottom), (right, top) = near.min(axis=0) - pad, near.max(axis=0) + pad
    return Window(min(rest.left, float(left)), max(rest.right, float(right)), min(rest.bottom, float(bottom)), max(rest.top, float(top)))


def _shadow(subject: Subject) -> Surface:
    """The free blocks at rest, pale, behind everything: seen only where the structure has moved away."""
    solids, framed = subject.solids, subject.framed
    towards = framed.view.towards
    behind = float((solids.vertices @ towards).max() - (subject.drawn @ towards).min()) + 0.01 * framed.window.height
    free = ~solids.fixed[solids.face_block]
    sides = np.diff(solids.loop_start)
    colours = np.tile((255 * rgb(SHADOW)).astype(np.uint8), (int(free.sum()), 1))
    loops = solids.loops[np.repeat(free, sides)]
    whole = Surface(solids.vertices, loops, np.cumsum([0, *sides[free]]), colours, lit=False)
    left = clipped(whole, framed.cut) if framed.cut is not None else whole
    return Surface(left.points - behind * towards, left.loops, left.loop_start, left.colours, lit=False)


def _block_layers(subject: Subject) -> list[Layer]:
    """Faces and edges of the blocks; where they are cut, with caps in a darker tone."""
    solids, framed = subject.solids, subject.framed
    colours = np.where(subject.down[:, None], rgb(FALLEN), rgb(STONE))
    colours[solids.fixed] = rgb(SUPPORT)
    whole = block_layers(solids, subject.drawn, colours, framed.view, framed.window)
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


def _joint_layers(subject: Subject, scales: tuple[Scale, Scale]) -> list[Surface]:
    """One surface for the bands of opened and slid joints, one for the parted faces of blocks that still stand."""
    joints, marks, solids, framed = subject.joints, subject.marks, subject.solids, subject.framed
    smallest = float(np.median(solids.sizes[~solids.fixed].min(axis=1))) if not solids.fixed.all() else np.inf
    width = max(LEAST_BAND * framed.pixel, min(BAND * framed.pixel, BAND_OF_BLOCK * smallest))
    marked = marks.opened | marks.slid
    standing = [marks.separated & ~subject.down[block] for block in (joints.block_a, joints.block_b)]
    layers: list[Surface] = []
    if marked.any():
        first, second = _band_colours(marks, scales)
        bands = joint_bands(joints, marked, solids, subject.pose, framed.factor, width)
        layers.append(_lifted(dashed(bands, first, second, width), framed, cut=True))
        if framed.cut is not None:
            layers.append(_lifted(dashed(_traces(subject, marked, width), first, second, width), framed, cut=False))
    if np.any(standing):
        dark = np.tile((255 * rgb(PARTED)).astype(np.uint8), (joints.count, 1))
        plates = dashed(face_plates(joints, standing, solids, subject.pose, framed.factor, 0.7 * width), dark, dark, width)
        layers.append(_lifted(plates, framed, cut=True))
    return layers


def _band_colours(marks: Marks, scales: tuple[Scale, Scale]) -> tuple[np.ndarray, np.ndarray]:
    """(J, 3) the two colours that the dashes of each joint alternate between."""
    opening, sliding = scales[0](marks.opening), scales[1](marks.sliding)
    first = np.where(marks.opened[:, None], opening, sliding)
    white = np.full_like(first, 255)
    return first, np.where(~marks.slid[:, None], opening, np.where(marks.opened[:, None], sliding, white))


def _traces(subject: Subject, marked: np.ndarray, width: float) -> Bands:
    """The bands of the joints in the plane of the cut."""
    framed = subject.framed
    assert framed.cut is not None
    on_a, on_b = band_corners(subject.joints, subject.solids, subject.pose, framed.factor, width)
    return traces(subject.joints, on_a, on_b, marked, framed.cut)


def _lifted(surface: Surface, framed: Framing, cut: bool) -> Surface:
    """A surface a little before the blocks; clipped first if it is to be cut."""
    lift = 1e-3 * framed.window.height * framed.view.towards
    left = clipped(surface, framed.cut) if cut and framed.cut is not None else surface
    return Surface(left.points + lift, left.loops, left.loop_start, left.colours, lit=False)


def _thrust_layer(results: Results, frame: int, subject: Subject) -> tuple[Surface, float]:
    """The line of thrust, before everything else, and the force of the widest ribbon [N]."""
    framed, towards = subject.framed, subject.framed.view.towards
    surface, largest = ribbons(results, subject.solids, subject.pose, subject.snapshot, frame, framed.factor, framed.view, framed.pixel)
    if framed.cut is not None:
        towards_viewer = -float(framed.cut.normal @ np.ones(3))  # of a plane across an axis
        nearer = replace(framed.cut, value=framed.cut.value + towards_viewer * WIDEST * framed.pixel)
        surface = clipped(surface, nearer)  # what runs in the plane itself, as in the middle of an arch, stays whole
    if not len(surface.points):
        return surface, largest
    before = float((subject.drawn @ towards).max() - (surface.points @ towards).min()) + 0.01 * framed.window.height
    return Surface(surface.points + before * towards, surface.loops, surface.loop_start, surface.colours, lit=False), largest


def _facts(subject: Subject) -> str:
    """Time, view, amplification and the largest displacement, in a line."""
    framed = subject.framed
    shape = "true shape" if framed.factor == 1 else f"displacements × {framed.factor:g}"
    cut = f", cut at {framed.cut.text}" if framed.cut else ""
    return (
        f"t = {subject.pose.time:.4g} s{' (last frame)' if subject.last else ''} · {framed.view.name} view{cut} · {shape}, relative to the "
        f"base · largest displacement {in_metres(subject.largest)}"
        + (f"\nover all time steps: {subject.suffered}" if subject.suffered else "")
        + (f" · {subject.provisional}" if subject.provisional else "")
    )


def _outside(subject: Subject) -> int:
    """Number of free blocks of which nothing is in the picture."""
    solids, window = subject.solids, subject.framed.window
    x, y = subject.framed.view.plane(subject.drawn).T
    inside = (x > window.left) & (x < window.right) & (y > window.bottom) & (y < window.top)
    seen = np.bincount(solids.vertex_block, inside, minlength=len(solids.centre)) > 0
    return int((~seen & ~solids.fixed).sum())
