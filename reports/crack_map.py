r"""The crack map: the structure as it stands at a frame, its joints coloured by what is left open and what has slid.

An open joint is a solid band coloured by its opening, a slid one is dashed and coloured by its sliding, in another hue; where
both happened the dashes lie on the band. So the two are told apart in colour, by a colour-blind reader, and in grey print. The
classes of both scales run 1-2-5 from the threshold of damage to ``largest``: equal thresholds give equal colours, and the maps of
two runs can be laid side by side. Faces of standing blocks that have parted are dark. Where nothing would be seen at true scale,
displacements relative to the base are drawn amplified by a factor that the sheet states; the shape at rest lies behind as a pale
shadow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.errors import InputError
from masonry_cd.joints import Joints
from masonry_cd.results import Results
from reports.bands import dashed, face_plates, joint_bands
from reports.damage import Thresholds, fallen, separated_joints
from reports.deformed import Pose, Solids, frame_index, joint_frame, solids_of
from reports.picture import SUPPORT, auto_view, block_layers, box_swatch, rgb, structure_window
from reports.render import Layer, Surface, View, Window, render, view_named
from reports.sheet import FAINT, INK, Box, Layout, Paint, Sheet, classes, in_metres, layout, nice

STONE, FALLEN, PARTED, SHADOW = "#efe8da", "#c4a491", "#2b2b2b", "#e6e9ec"
OPENING_COLOURS, SLIDING_COLOURS = ("YlGnBu", 0.4, 1.0), ("OrRd", 0.4, 1.0)  # colour map and the part of it in use
BAND = 6.0  # width of a closed joint's band [pixels]
BAND_OF_BLOCK = 0.2  # ... but no more than this share of a block's smallest extent
LEAST_BAND = 2.5  # ... and no less than this [pixels]
SEEN = 0.02  # amplified displacements reach at most this share of the picture
REACH = 0.35  # the picture follows fallen blocks by at most this share of the structure's extent
MOST = 1000.0  # largest amplification


@dataclass(frozen=True, eq=False)
class Marks:
    """What is drawn of J joints at a frame."""

    opening: np.ndarray  # (J,) [m]
    sliding: np.ndarray  # (J,) [m]
    separated: np.ndarray  # (J,)
    opened: np.ndarray  # (J,) beyond the threshold, not separated, not between two fallen blocks
    slid: np.ndarray  # (J,) likewise

    @classmethod
    def at(cls, results: Results, frame: int, thresholds: Thresholds, down: np.ndarray) -> Marks:
        """The marks at a frame whose fallen blocks are down (B,)."""
        opening, sliding = joint_frame(results, "opening", frame), joint_frame(results, "sliding", frame)
        separated = separated_joints(results, frame, thresholds)
        live = ~separated & ~(down[results.joints.block_a] & down[results.joints.block_b])
        return cls(opening, sliding, separated, live & (opening >= thresholds.opened), live & (sliding >= thresholds.slid))


class Scale:
    """Classes of a length from a threshold to a largest value, in steps of 1-2-5, each with a colour; one more class lies beyond."""

    def __init__(self, smallest: float, largest: float, colours: tuple[str, float, float]) -> None:
        from matplotlib import colormaps

        name, low, high = colours
        self.bounds = classes(smallest, largest)  # [m]
        self.colours = np.round(255 * colormaps[name](np.linspace(low, high, len(self.bounds)))[:, :3]).astype(np.uint8)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """(N, 3) uint8 colours of lengths (N,) [m]."""
        return self.colours[np.clip(np.searchsorted(self.bounds, values, side="right") - 1, 0, len(self.colours) - 1)]


def crack_map(
    results: Results,
    path: Path,
    *,
    frame: int = -1,
    view: str = "auto",
    scale: float | None = None,
    thresholds: Thresholds | None = None,
    largest: float = 0.05,
) -> None:
    """Draw the crack map of a frame into a PNG.

    Args:
        results: of a run.
        path: of the PNG.
        frame: which; negative ones count from the end.
        view: auto (front where all blocks are prisms across y, else isometric), front, back, side, top or isometric.
        scale: amplification of the displacements; None picks 1, or what makes the largest one visible.
        thresholds: where an opening and a sliding begin to be drawn.
        largest: where the last class of the colour scales begins [m].

    Raises:
        InputError: no such frame or view, a scale that is not positive, no off-screen OpenGL, or a path that cannot be written.
    """
    thresholds = thresholds or Thresholds()
    if scale is not None and not (np.isfinite(scale) and scale > 0):
        raise InputError(f"scale: must be positive, got {scale!r}")
    if not largest > max(thresholds.opened, thresholds.slid):
        raise InputError(f"largest: must lie above the thresholds, got {largest!r}")
    subject = _subject(results, frame_index(results, frame), view, scale, thresholds)
    scales = Scale(thresholds.opened, largest, OPENING_COLOURS), Scale(thresholds.slid, largest, SLIDING_COLOURS)
    colours = np.where(subject.down[:, None], rgb(FALLEN), rgb(STONE))
    colours[subject.solids.fixed] = rgb(SUPPORT)
    layers: list[Layer] = [_shadow(subject), *block_layers(subject.solids, subject.drawn, colours, subject.view, subject.window)]
    layers += _joint_layers(subject, scales)
    sheet = Sheet(subject.plan)
    sheet.model(render(layers, subject.view, subject.window, subject.plan.pixels))
    sheet.head(results.title or "Crack map", _facts(subject))
    _keys(sheet, subject, scales)
    sheet.save(path)


@dataclass(frozen=True, eq=False)
class Subject:
    """What a sheet shows, and from where."""

    joints: Joints
    solids: Solids
    pose: Pose
    last: bool  # the last frame
    down: np.ndarray  # (B,) fallen blocks
    marks: Marks
    factor: float  # amplification of displacements
    drawn: np.ndarray  # (V, 3) vertices where they are drawn [m]
    view: View
    window: Window
    plan: Layout

    @property
    def pixel(self) -> float:
        """Size of a pixel [m]."""
        return self.window.width / self.plan.pixels[0]

    @property
    def largest(self) -> float:
        """Largest displacement of a free block relative to the base [m]."""
        return largest_displacement(self.pose, self.solids)


def _subject(results: Results, frame: int, view: str, scale: float | None, thresholds: Thresholds) -> Subject:
    """Choose the view, the amplification and the window of a frame."""
    solids = solids_of(results.blocks)
    looking = view_named(auto_view(solids) if view == "auto" else view)
    pose, down = Pose.of(results, solids, frame), fallen(results, thresholds, frame)
    rest = structure_window(solids, looking)
    factor = scale if scale is not None else amplification(pose, solids, down, max(rest.width, rest.height))
    drawn = pose.moved(solids, solids.vertices, solids.vertex_block, factor)
    window = followed(rest, looking.plane(drawn[~solids.fixed[solids.vertex_block]]))
    plan = layout(window.width / window.height)
    return Subject(
        joints=results.joints,
        solids=solids,
        pose=pose,
        last=frame == results.frames - 1,
        down=down,
        marks=Marks.at(results, frame, thresholds, down),
        factor=factor,
        drawn=drawn,
        view=looking,
        window=window.fitted(plan.pixels),
        plan=plan,
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


def followed(rest: Window, moved: np.ndarray) -> Window:
    """The window at rest, extended to points (N, 2) that have moved out of it, but for those flung so far that it would become a dot."""
    reach, pad = REACH * max(rest.width, rest.height), 0.03 * max(rest.width, rest.height)
    low, high = np.array([rest.left, rest.bottom]), np.array([rest.right, rest.top])
    near = moved[((moved > low - reach) & (moved < high + reach)).all(axis=1)]
    if not len(near):
        return rest
    (left, bottom), (right, top) = near.min(axis=0) - pad, near.max(axis=0) + pad
    return Window(min(rest.left, float(left)), max(rest.right, float(right)), min(rest.bottom, float(bottom)), max(rest.top, float(top)))


def _shadow(subject: Subject) -> Surface:
    """The free blocks at rest, pale, behind everything: seen only where the structure has moved away."""
    solids, towards = subject.solids, subject.view.towards
    behind = float((solids.vertices @ towards).max() - (subject.drawn @ towards).min()) + 0.01 * subject.window.height
    free = ~solids.fixed[solids.face_block]
    sides = np.diff(solids.loop_start)
    colours = np.tile((255 * rgb(SHADOW)).astype(np.uint8), (int(free.sum()), 1))
    loops = solids.loops[np.repeat(free, sides)]
    return Surface(solids.vertices - behind * towards, loops, np.cumsum([0, *sides[free]]), colours, lit=False)


def _joint_layers(subject: Subject, scales: tuple[Scale, Scale]) -> list[Surface]:
    """One surface for the bands of opened and slid joints, one for the parted faces of blocks that still stand."""
    joints, marks, solids, pose, factor = subject.joints, subject.marks, subject.solids, subject.pose, subject.factor
    smallest = float(np.median(solids.sizes[~solids.fixed].min(axis=1))) if not solids.fixed.all() else np.inf
    width = max(LEAST_BAND * subject.pixel, min(BAND * subject.pixel, BAND_OF_BLOCK * smallest))
    layers = []
    if (marks.opened | marks.slid).any():
        white = np.full((joints.count, 3), 255, np.uint8)
        opening, sliding = scales[0](marks.opening), scales[1](marks.sliding)
        first = np.where(marks.opened[:, None], opening, sliding)
        second = np.where(~marks.slid[:, None], opening, np.where(marks.opened[:, None], sliding, white))
        bands = joint_bands(joints, marks.opened | marks.slid, solids, pose, factor, width)
        layers.append(dashed(bands, first, second, width))
    standing = [marks.separated & ~subject.down[block] for block in (joints.block_a, joints.block_b)]
    if np.any(standing):
        dark = np.tile((255 * rgb(PARTED)).astype(np.uint8), (joints.count, 1))
        layers.append(dashed(face_plates(joints, standing, solids, pose, factor, 0.7 * width), dark, dark, width))
    lift = 1e-3 * subject.window.height * subject.view.towards
    return [Surface(s.points + lift, s.loops, s.loop_start, s.colours, lit=False) for s in layers]


def _outside(subject: Subject) -> int:
    """Number of free blocks of which nothing is in the picture."""
    solids, window = subject.solids, subject.window
    x, y = subject.view.plane(subject.drawn).T
    inside = (x > window.left) & (x < window.right) & (y > window.bottom) & (y < window.top)
    seen = np.bincount(solids.vertex_block, inside, minlength=len(solids.centre)) > 0
    return int((~seen & ~solids.fixed).sum())


def _facts(subject: Subject) -> str:
    """Time, view, amplification and the largest displacement, in a line."""
    shape = "true shape" if subject.factor == 1 else f"displacements × {subject.factor:g}"
    return (
        f"t = {subject.pose.time:.4g} s{' (last frame)' if subject.last else ''} · {subject.view.name} view · {shape}, relative to the base"
        f" · largest displacement {in_metres(subject.largest)}"
    )


def _keys(sheet: Sheet, subject: Subject, scales: tuple[Scale, Scale]) -> None:
    """The two colour scales, the signs with their numbers, and the scale bar."""
    marks, boxes, when = subject.marks, sheet.plan.keys(4), "Residual" if subject.last else "Present"
    for box, scale, name, dash in zip(boxes[:2], scales, ("opening", "sliding"), (False, True), strict=True):
        _scale_key(sheet.axes(*box), box, scale, f"{when} {name} [mm]", dash)
    middle = [scale.colours[len(scale.colours) // 2] / 255.0 for scale in scales]
    both, down, outside = marks.opened & marks.slid, int(subject.down.sum()), _outside(subject)
    rows: list[tuple[Paint, str]] = [
        (partial(_band_sign, first=middle[0], second=middle[0]), f"joint open ({int((marks.opened & ~both).sum())})"),
        (partial(_band_sign, first=middle[1], second=np.ones(3)), f"joint slid ({int((marks.slid & ~both).sum())})"),
        (partial(_band_sign, first=middle[0], second=middle[1]), f"open and slid ({int(both.sum())})"),
        (partial(_band_sign, first=rgb(PARTED), second=rgb(PARTED)), f"separated ({int(marks.separated.sum())})"),
    ]
    if down:
        rows.append((partial(box_swatch, colour=FALLEN), f"fallen block ({down})" + (f", {outside} not in view" if outside else "")))
    if subject.factor * subject.largest > 2 * subject.pixel:
        rows.append((partial(box_swatch, colour=SHADOW), "shape at rest"))
    sheet.swatches(sheet.axes(*boxes[2]), rows, 0, boxes[2][3] - 4, pitch=29.0)
    sheet.scale_bar(sheet.axes(*boxes[3]), subject.pixel, 10, boxes[3][3] - 44, boxes[3][2] - 60)


def _scale_key(axes: Any, box: Box, scale: Scale, name: str, dash: bool) -> None:
    """A row of boxes with their bounds below; dashed ones leave a gap, as the dashes of the map do."""
    from matplotlib.patches import Rectangle

    top, start, width = box[3] - 66, 10, (box[2] - 40) / len(scale.bounds)
    axes.text(0, box[3] - 24, name, fontsize=14, weight="bold", color=INK, va="center")
    for k, (bound, colour) in enumerate(zip(scale.bounds, scale.colours, strict=True)):
        left = start + k * width
        axes.add_patch(Rectangle((left, top), width * (0.66 if dash else 1.0), 26, facecolor=colour / 255.0, linewidth=0))
        axes.plot([left, left], [top - 6, top], color=FAINT, linewidth=1.0)
        axes.text(left, top - 18, f"{bound * 1000:.3g}", fontsize=11, color=INK, ha="center", va="center")
    axes.text(start + len(scale.bounds) * width + 6, top + 13, "+", fontsize=14, color=INK, va="center")


def _band_sign(axes: Any, place: Box, first: np.ndarray, second: np.ndarray) -> None:
    """A piece of a band, its dashes alternating."""
    from matplotlib.patches import Rectangle

    left, bottom, width, height = place
    for k in range(3):
        colour = first if k % 2 == 0 else second
        axes.add_patch(Rectangle((left + k * width / 3, bottom + height / 2 - 4), width / 3, 8, facecolor=colour, linewidth=0))
