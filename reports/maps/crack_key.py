"""What stands around a crack map: the classes of its colours, the signs of its key with their numbers, and the scale bar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.foundation.quantities import classes, force
from reports.drawing import palette
from reports.drawing.figure import FAINT, INK, TRIAD, Box, Paint, Sheet
from reports.drawing.render import View
from reports.drawing.structure_picture import box_swatch, no_swatch, rgb, tie_swatch
from reports.drawing.tie_lines import LABELLED
from reports.maps.thrust import COLOUR as THRUST

STONE, FALLEN, PARTED, SHADOW = palette.STONE, palette.FALLEN, palette.PARTED, palette.SHADOW
OPENING_COLOURS, SLIDING_COLOURS = ("YlGnBu", 0.4, 1.0), ("OrRd", 0.4, 1.0)  # colour map and the part of it in use


@dataclass(frozen=True, eq=False)
class Marks:
    """What is drawn of J joints at a frame."""

    opening: np.ndarray  # (J,) [m]
    sliding: np.ndarray  # (J,) [m]
    separated: np.ndarray  # (J,)
    opened: np.ndarray  # (J,) open, see masonry_cd.analysis.damage.definitions; not separated, neither of its blocks has fallen
    slid: np.ndarray  # (J,) likewise
    crushed: np.ndarray | None = None  # (J,) bool: shorter for good; None: none can be

    @property
    def some(self) -> bool:
        """Whether there are joints; a packing of spheres has none, and no word on them is needed."""
        return len(self.opening) > 0

    @classmethod
    def of(cls, snapshot: DamageSnapshot, crushed: np.ndarray | None = None) -> Marks:
        """The marks of a frame's damage; ``crushed`` (J,) by how much joints are shorter for good [m], None where none can be."""
        shorter = None if crushed is None else snapshot.live & ~snapshot.separated & (crushed > 0.0)
        return cls(snapshot.opening, snapshot.sliding, snapshot.separated, snapshot.open, snapshot.slid, shorter)


class ColourClasses:
    """Classes of a value, each with a colour and its lower bound; the last is open."""

    def __init__(self, bounds: Sequence[float], colours: tuple[str, float, float], factor: float) -> None:
        from matplotlib import colormaps

        name, low, high = colours
        self.bounds = list(bounds)
        self.factor = factor  # of the bounds, into the unit of the key
        self.colours = np.round(255 * colormaps[name](np.linspace(low, high, len(self.bounds)))[:, :3]).astype(np.uint8)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """(N, 3) uint8 colours of values (N,)."""
        return self.colours[np.clip(np.searchsorted(self.bounds, values, side="right") - 1, 0, len(self.colours) - 1)]


class Scale(ColourClasses):
    """Classes of a length [m], in the key in mm, from a threshold to a largest value in steps of 1-2-5; one more class lies beyond."""

    def __init__(self, smallest: float, largest: float, colours: tuple[str, float, float]) -> None:
        super().__init__(classes(smallest, largest), colours, 1e3)


@dataclass(frozen=True, eq=False)
class Key:
    """What the key of a map says.

    Attributes:
        marks: of the joints.
        scales: of opening and sliding.
        when: ``Residual`` or ``Present``.
        down: number of fallen blocks.
        outside: number of blocks of which nothing is in the picture.
        moved: the shape at rest can be seen behind the drawn one.
        alone: a single map, whose key names only what it shows.
        force: of the widest ribbon [N], None where the forces are not drawn.
        pixel: size of a pixel [m].
        view: from where.
        ties: number of ties.
    """

    marks: Marks
    scales: tuple[Scale, Scale]
    when: str
    down: int
    outside: int
    moved: bool
    alone: bool
    force: float | None
    pixel: float
    view: View
    ties: int = 0


def draw_scales(sheet: Sheet, key: Key) -> None:
    """What all maps of a sequence share: the two colour scales, the scale bar, and what the ribbons of forces mean."""
    boxes = sheet.plan.keys(4)
    if key.marks.some:
        for box, scale, name, dash in zip(boxes[:2], key.scales, ("opening", "sliding"), (False, True), strict=True):
            draw_scale(sheet.axes(*box), box, scale, f"{key.when} {name} [mm]", dash)
    draw_scale_bar(sheet, boxes[3], key.view, key.pixel)


def draw_scale_bar(sheet: Sheet, box: Box, view: View, pixel: float) -> None:
    """The scale bar, for a size of a pixel [m]; beside it the directions of the axes, where the view is oblique."""
    axes, (width, height) = sheet.axes(*box), box[2:]
    room = TRIAD if view.is_oblique else 0.0
    sheet.scale_bar(axes, pixel, 10, height - 44, width - 60 - room)
    if view.is_oblique:
        sheet.triad(axes, view, (width - 0.5 * TRIAD, height - 58))


def draw_signs(sheet: Sheet, key: Key) -> None:
    """The signs with their numbers, and the force of the widest ribbon."""
    marks, scales, boxes = key.marks, key.scales, sheet.plan.keys(4)
    middle = [scale.colours[len(scale.colours) // 2] / 255.0 for scale in scales]
    both = marks.opened & marks.slid
    rows: list[tuple[Paint, str]] = [
        (partial(band_sign, first=middle[0], second=middle[0]), f"joint open ({int((marks.opened & ~both).sum())})"),
        (partial(band_sign, first=middle[1], second=np.ones(3)), f"joint slid ({int((marks.slid & ~both).sum())})"),
        (partial(band_sign, first=middle[0], second=middle[1]), f"open and slid ({int(both.sum())})"),
        (partial(band_sign, first=rgb(PARTED), second=rgb(PARTED)), f"separated ({int(marks.separated.sum())})"),
    ]
    if marks.crushed is not None and marks.crushed.any():
        rows.append((partial(band_sign, first=np.ones(3), second=rgb(palette.CRUSHED)), f"crushed ({int(marks.crushed.sum())})"))
    rows = rows if marks.some else []
    if key.down or not key.alone:
        hidden = f", {key.outside} not in view" if key.outside else ""
        rows.append((partial(box_swatch, colour=FALLEN), f"fallen block ({key.down}){hidden}"))
    if key.moved or not key.alone:
        rows.append((partial(box_swatch, colour=SHADOW), "shape at rest"))
    if key.ties:
        rows.append((tie_swatch, "tie, with its tension" if key.ties <= LABELLED else "tie"))
    sheet.swatches(sheet.axes(*boxes[2]), rows, 0, boxes[2][3] - 4, pitch=29.0)
    if key.force is not None:
        bar = sheet.axes(*boxes[3])
        thrust = np.array(THRUST) / 255.0
        width = f"normal force, widest {force(key.force)}"
        rows = [(partial(band_sign, first=thrust, second=thrust), width), (no_swatch, THRUST_NOTE)]
        sheet.swatches(bar, rows, 10, boxes[3][3] - 84, pitch=29.0)


THRUST_NOTE = "through where it acts in each joint"


def draw_scale(axes: Any, box: Box, scale: ColourClasses, name: str, dash: bool = False) -> None:
    """A row of boxes with their bounds below; dashed ones leave a gap, as the dashes of the map do."""
    from matplotlib.patches import Rectangle

    top, start, width = box[3] - 66, 10, (box[2] - 40) / len(scale.bounds)
    axes.text(0, box[3] - 24, name, fontsize=14, weight="bold", color=INK, va="center")
    for k, (bound, colour) in enumerate(zip(scale.bounds, scale.colours, strict=True)):
        left = start + k * width
        axes.add_patch(Rectangle((left, top), width * (0.66 if dash else 1.0), 26, facecolor=colour / 255.0, linewidth=0))
        axes.plot([left, left], [top - 6, top], color=FAINT, linewidth=1.0)
        axes.text(left, top - 18, f"{bound * scale.factor:.3g}", fontsize=11, color=INK, ha="center", va="center")
    axes.text(start + len(scale.bounds) * width + 6, top + 13, "+", fontsize=14, color=INK, va="center")


def band_sign(axes: Any, place: Box, first: np.ndarray, second: np.ndarray) -> None:
    """A piece of a band, its dashes alternating."""
    from matplotlib.patches import Rectangle

    left, bottom, width, height = place
    for k in range(3):
        colour = first if k % 2 == 0 else second
        axes.add_patch(Rectangle((left + k * width / 3, bottom + height / 2 - 4), width / 3, 8, facecolor=colour, linewidth=0))
