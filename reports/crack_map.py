r"""The crack map: the structure as it stands at a frame, its joints coloured by what is left open and what has slid.

An open joint is a solid band coloured by its opening, a slid one is dashed and coloured by its sliding, in another hue; where
both happened the dashes lie on the band. So the two are told apart in colour, by a colour-blind reader, and in grey print. The
classes of both scales run 1-2-5 from the threshold of damage to ``largest``: equal thresholds give equal colours, and the maps of
two runs can be laid side by side. Parted faces are dark. Where nothing would be seen at true scale, displacements relative to
the base are drawn amplified by a factor that the sheet states; the shape at rest lies behind as a pale shadow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.errors import InputError
from masonry_cd.results import Results
from reports.bands import dashed, face_plates, joint_bands
from reports.damage import Thresholds, fallen, separated_joints
from reports.deformed import Pose, Solids, frame_index, joint_frame, solids_of
from reports.picture import SUPPORT, auto_view, block_layers, box_swatch, rgb, structure_window
from reports.render import Layer, Surface, View, Window, render, view_named
from reports.sheet import FAINT, INK, Box, Paint, Sheet, in_metres, layout, nice

STONE, FALLEN, PARTED, SHADOW = "#efe8da", "#c4a491", "#2b2b2b", "#e6e9ec"
OPENING_COLOURS, SLIDING_COLOURS = ("viridis_r", 0.12, 1.0), ("OrRd", 0.38, 1.0)  # colour map and the part of it in use
BAND = 6.0  # width of a closed joint's band [pixels]
BAND_OF_BLOCK = 0.16  # ... but no more than this share of a block's smallest extent
SEEN = 0.02  # amplified displacements reach at most this share of the picture
REACH = 0.35  # the picture follows fallen blocks by at most this share of the structure's extent
MOST = 1000.0  # largest amplification


@dataclass(frozen=True, eq=False)
class Marks:
    """What is drawn of J joints at a frame."""

    opening: np.ndarray  # (J,) [m]
    sliding: np.ndarray  # (J,) [m]
    separated: np.ndarray  # (J,)
    opened: np.ndarray  # (J,) beyond the threshold and not separated
    slid: np.ndarray  # (J,) likewise

    @classmethod
    def at(cls, results: Results, frame: int, thresholds: Thresholds) -> Marks:
        """The marks at a frame."""
        opening, sliding = joint_frame(results, "opening", frame), joint_frame(results, "sliding", frame)
        separated = separated_joints(results, frame, thresholds)
        return cls(opening, sliding, separated, ~separated & (opening >= thresholds.opened), ~separated & (sliding >= thresholds.slid))


class Scale:
    """Classes of a length from a threshold to a largest value, in steps of 1-2-5, each with a colour; one more class lies beyond."""

    def __init__(self, smallest: float, largest: float, colours: tuple[str, float, float]) -> None:
        from matplotlib import colormaps

        name, low, high = colours
        self.bounds = [smallest]  # [m]
        while self.bounds[-1] < largest * (1 - 1e-9):
            self.bounds.append(next_step(self.bounds[-1]))
        self.colours = np.round(255 * colormaps[name](np.linspace(low, high, len(self.bounds)))[:, :3]).astype(np.uint8)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """(N, 3) uint8 colours of lengths (N,) [m]."""
        return self.colours[np.clip(np.searchsorted(self.bounds, values, side="right") - 1, 0, len(self.colours) - 1)]


def next_step(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten after a value."""
    base = nice(value)
    first = round(base / 10.0 ** np.floor(np.log10(base) + 1e-9))
    return base * {1: 2.0, 2: 2.5, 5: 2.0}[first]


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
    frame = frame_index(results, frame)
    solids = solids_of(results.blocks)
    looking = view_named(auto_view(solids) if view == "auto" else view)
    pose, down, marks = Pose.of(results, solids, frame), fallen(results, thresholds, frame), Marks.at(results, frame, thresholds)
    rest = structure_window(solids, looking)
    factor = scale if scale is not None else amplification(pose, solids, down, max(rest.width, rest.height))
    drawn = pose.moved(solids, solids.vertices, solids.vertex_block, factor)
    window = followed(rest, looking.plane(drawn[~solids.fixed[solids.vertex_block]]))
    plan = layout(window.width / window.height)
    window = window.fitted(plan.pixels)
    scales = Scale(thresholds.opened, largest, OPENING_COLOURS), Scale(thresholds.slid, largest, SLIDING_COLOURS)

    colours = np.where(solids.fixed[:, None], rgb(SUPPORT), np.where(down[:, None], rgb(FALLEN), rgb(STONE)))
    layers: list[Layer] = [_shadow(solids, drawn, looking, window), *block_layers(solids, drawn, colours, looking, window)]
    layers += _joint_layers(results, solids, pose, factor, marks, scales, looking, window, plan.pixels[0])
    sheet = Sheet(plan)
    sheet.model(render(layers, looking, window, plan.pixels))
    sheet.head(results.title or "Crack map", _facts(results, solids, pose, frame, looking, factor))
    outside = _outside(looking.plane(drawn), solids, window)
    _keys(sheet, marks, scales, "Residual" if frame == results.frames - 1 else "Present", int(down.sum()), outside, window)
    sheet.save(path)


def amplification(pose: Pose, solids: Solids, down: np.ndarray, size: float) -> float:
    """1 where a displacement can be seen in a picture of a size [m] or blocks have fallen, else a round factor that shows it."""
    free = ~solids.fixed
    largest = float(np.linalg.norm(pose.displacement(solids)[free], axis=1).max(initial=0.0))
    if down.any() or MOST * largest < SEEN / 10 * size:
        return 1.0  # what has fallen is seen as it is, and what no amplification shows is left alone
    return float(np.clip(nice(SEEN * size / largest), 1.0, MOST))


def followed(rest: Window, moved: np.ndarray) -> Window:
    """The window at rest, extended to points (N, 2) that have moved out of it, but not so far that the structure becomes a dot."""
    if not len(moved):
        return rest
    reach, pad = REACH * max(rest.width, rest.height), 0.03 * max(rest.width, rest.height)
    (left, bottom), (right, top) = moved.min(axis=0) - pad, moved.max(axis=0) + pad
    return Window(
        max(min(rest.left, float(left)), rest.left - reach),
        min(max(rest.right, float(right)), rest.right + reach),
        max(min(rest.bottom, float(bottom)), rest.bottom - reach),
        min(max(rest.top, float(top)), rest.top + reach),
    )


def _shadow(solids: Solids, drawn: np.ndarray, view: View, window: Window) -> Surface:
    """The free blocks at rest, pale, behind everything: seen only where the structure has moved away."""
    behind = float((solids.vertices @ view.towards).max() - (drawn @ view.towards).min()) + 0.01 * window.height
    faces = np.repeat(~solids.fixed[solids.face_block], np.diff(solids.loop_start))
    sides = np.diff(solids.loop_start)[~solids.fixed[solids.face_block]]
    colours = np.tile((255 * rgb(SHADOW)).astype(np.uint8), (len(sides), 1))
    return Surface(solids.vertices - behind * view.towards, solids.loops[faces], np.cumsum([0, *sides]), colours, lit=False)


def _joint_layers(
    results: Results,
    solids: Solids,
    pose: Pose,
    factor: float,
    marks: Marks,
    scales: tuple[Scale, Scale],
    view: View,
    window: Window,
    pixels: int,
) -> list[Surface]:
    """One surface for the bands of opened and slid joints, one for the faces that have parted."""
    joints, pixel = results.joints, window.width / pixels
    smallest = float(np.median(solids.sizes[~solids.fixed].min(axis=1))) if not solids.fixed.all() else np.inf
    width = max(1.5 * pixel, min(BAND * pixel, BAND_OF_BLOCK * smallest))
    lift = 1e-3 * window.height * view.towards
    layers = []
    if (marks.opened | marks.slid).any():
        white = np.full((joints.count, 3), 255, np.uint8)
        opening, sliding = scales[0](marks.opening), scales[1](marks.sliding)
        first = np.where(marks.opened[:, None], opening, sliding)
        second = np.where(~marks.slid[:, None], opening, np.where(marks.opened[:, None], sliding, white))
        bands = joint_bands(joints, marks.opened | marks.slid, solids, pose, factor, width)
        layers.append(dashed(bands, first, second, width))
    if marks.separated.any():
        dark = np.tile((255 * rgb(PARTED)).astype(np.uint8), (joints.count, 1))
        layers.append(dashed(face_plates(joints, marks.separated, solids, pose, factor, 0.6 * width), dark, dark, width))
    return [Surface(s.points + lift, s.loops, s.loop_start, s.colours, lit=False) for s in layers]


def _outside(plane: np.ndarray, solids: Solids, window: Window) -> int:
    """Number of free blocks of which nothing is in the picture."""
    inside = (plane[:, 0] > window.left) & (plane[:, 0] < window.right) & (plane[:, 1] > window.bottom) & (plane[:, 1] < window.top)
    seen = np.bincount(solids.vertex_block, inside, minlength=len(solids.centre)) > 0
    return int((~seen & ~solids.fixed).sum())


def _facts(results: Results, solids: Solids, pose: Pose, frame: int, view: View, factor: float) -> str:
    """Time, view, amplification and the largest displacement, in a line."""
    moved = float(np.linalg.norm(pose.displacement(solids)[~solids.fixed], axis=1).max(initial=0.0))
    end = " (end of the run)" if frame == results.frames - 1 else ""
    shape = "true shape" if factor == 1 else f"displacements × {factor:g}"
    return f"t = {pose.time:.4g} s{end} · {view.name} view · {shape}, relative to the base · largest displacement {in_metres(moved)}"


def _keys(sheet: Sheet, marks: Marks, scales: tuple[Scale, Scale], when: str, down: int, outside: int, window: Window) -> None:
    """The two colour scales, the signs with their numbers, and the scale bar."""
    boxes = sheet.plan.keys(4)
    for box, scale, name, dash in zip(boxes[:2], scales, ("opening", "sliding"), (False, True), strict=True):
        _scale_key(sheet.axes(*box), box, scale, f"{when} {name} [mm]", dash)
    middle = [scale.colours[len(scale.colours) // 2] / 255.0 for scale in scales]
    both = marks.opened & marks.slid
    rows: list[tuple[Paint, str]] = [
        (partial(_band_sign, first=middle[0], second=middle[0]), f"joint open ({int((marks.opened & ~both).sum())})"),
        (partial(_band_sign, first=middle[1], second=np.ones(3)), f"joint slid ({int((marks.slid & ~both).sum())})"),
        (partial(_band_sign, first=middle[0], second=middle[1]), f"open and slid ({int(both.sum())})"),
        (partial(_band_sign, first=rgb(PARTED), second=rgb(PARTED)), f"separated ({int(marks.separated.sum())})"),
    ]
    if down:
        rows.append((partial(box_swatch, colour=FALLEN), f"fallen block ({down})" + (f", {outside} not in view" if outside else "")))
    rows.append((_shadow_sign, "shape at rest"))
    sheet.swatches(sheet.axes(*boxes[2]), rows, 0, boxes[2][3] - 4, pitch=29.0)
    sheet.scale_bar(sheet.axes(*boxes[3]), window.width / sheet.plan.pixels[0], 10, boxes[3][3] - 44, boxes[3][2] - 60)


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


def _shadow_sign(axes: Any, place: Box) -> None:
    """The pale box of the shape at rest."""
    box_swatch(axes, place, SHADOW)
