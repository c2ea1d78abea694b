# SPDX-License-Identifier: GPL-3.0-or-later
"""How a map is drawn, and what all maps of a sequence have in common: view, cut, amplification and window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.joint_damage import fallen
from masonry_cd.analysis.deformed import Pose, Solids, solids_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import nice
from masonry_cd.io.results import Results
from reports.drawing import palette
from reports.drawing.cut import FACING, CutPlane, cut_named, plane_of
from reports.drawing.figure import layout
from reports.drawing.parts import Scale, View, Window
from reports.drawing.solids import MARGIN, looking_at, structure_window, tops_of

SEEN = 0.02  # amplified displacements reach at most this share of the picture
REACH = 0.35  # the picture follows blocks by at most this share of the structure's extent
COLLAPSE = 1.0  # ... and where blocks have fallen, so that a heap of rubble is held
MOST = 1000.0  # largest amplification


@dataclass(frozen=True)
class MapStyle:
    """How crack maps are drawn."""

    view: str = "auto"  # front where all blocks are prisms across y, else isometric; or front, back, side, left, top, isometric
    scale: float | None = None  # amplification of the displacements; None picks 1, or what makes the largest one visible
    thresholds: Thresholds = field(default_factory=Thresholds)  # where an opening and a sliding begin to be drawn
    largest: float = 0.05  # where the last class of the colour scales begins [m]
    cut: str = ""  # a plane, ``y=1.5`` or ``y`` for the middle; the view is then by default the one that faces it
    thrust: bool = False  # draw the line of thrust

    def __post_init__(self) -> None:
        if self.scale is not None and not (np.isfinite(self.scale) and self.scale > 0):
            raise InputError("scale", f"must be positive, got {self.scale!r}")
        if not self.largest > max(self.thresholds.opened, self.thresholds.slid):
            raise InputError("largest", f"must lie above the thresholds, got {self.largest!r}")


@dataclass(frozen=True, eq=False)
class Framing:
    """Framing that all maps of a sequence have in common."""

    style: MapStyle
    view: View
    cut: CutPlane | None
    factor: float  # amplification of displacements
    window: Window
    alone: bool  # a single map, whose key names only what it shows

    @property
    def shown(self) -> Window:
        """The window in the shape of the picture."""
        return self.window.fitted(layout(self.window.width / self.window.height).pixels)

    @property
    def pixel(self) -> float:
        """Size of a pixel [m]."""
        return self.shown.width / layout(self.window.width / self.window.height).pixels[0]

    @property
    def scales(self) -> tuple[Scale, Scale]:
        """The colours of openings and slidings."""
        thresholds, largest = self.style.thresholds, self.style.largest
        return Scale(thresholds.opened, largest, palette.OPENING), Scale(thresholds.slid, largest, palette.SLIDING)


def view_and_cut(solids: Solids, style: MapStyle) -> tuple[View, CutPlane | None]:
    """The view that a style asks for, and its cut.

    Raises:
        InputError: no such view or plane, or one that shows nothing of the structure.
    """
    view = looking_at(solids, FACING[plane_of(style.cut)[0]] if style.cut and style.view == "auto" else style.view)
    return view, cut_named(style.cut, solids, view) if style.cut else None


def framing(results: Results, frames: Sequence[int], style: MapStyle) -> Framing:
    """Choose view, amplification and window so that they suit all frames.

    Raises:
        InputError: no such view or plane.
    """
    solids = solids_of(results.blocks)
    view, cut = view_and_cut(solids, style)
    rest = structure_window(solids, view)
    if results.fill is not None:
        rest = rest.joined(Window.around(view.plane(tops_of(results.fill)), MARGIN))
    poses = [Pose.of(results, solids, frame) for frame in frames]
    farthest = max(range(len(frames)), key=lambda k: largest_displacement(poses[k], solids))
    fell = np.any([fallen(results, style.thresholds, frames[k]) for k in {farthest, len(frames) - 1}], axis=0)
    factor = (
        style.scale
        if style.scale is not None
        else amplification(largest_displacement(poses[farthest], solids), bool(fell.any()), max(rest.width, rest.height))
    )
    free, window = ~solids.fixed[solids.vertex_block], rest
    for pose in poses:
        owner = solids.vertex_block[free]
        moved = pose.moved(solids, solids.vertices[free], owner, factor)
        window = window.joined(followed(rest, view.plane(moved), owner, COLLAPSE if fell.any() else REACH))
    return Framing(style, view, cut, factor, window, alone=len(frames) == 1)


def largest_displacement(pose: Pose, solids: Solids) -> float:
    """Largest displacement of a free block's centre relative to the base [m]."""
    return float(np.linalg.norm(pose.displacement(solids)[~solids.fixed], axis=1).max(initial=0.0))


def amplification(largest: float, fell: bool, size: float) -> float:
    """1 where a largest displacement can be seen in a picture of a size [m] or blocks ``fell``, else a round factor that shows it."""
    if fell or MOST * largest < SEEN / 10 * size:
        return 1.0  # what has fallen is seen as it is, and what no amplification shows is left alone
    return float(np.clip(nice(SEEN * size / largest), 1.0, MOST))


def followed(rest: Window, moved: np.ndarray, owner: np.ndarray, share: float = REACH) -> Window:
    """The window at rest, extended to the blocks that have moved out of it, whole, but for those flung farther than a share of its size.

    ``moved`` (N, 2) are their vertices in the plane of the picture [m], ``owner`` (N,) the block of each.
    """
    reach, pad = share * max(rest.width, rest.height), 0.03 * max(rest.width, rest.height)
    low, high = np.array([rest.left, rest.bottom]), np.array([rest.right, rest.top])
    within = ((moved > low - reach) & (moved < high + reach)).all(axis=1)
    near = moved[np.isin(owner, owner[within])]
    if not len(near):
        return rest
    (left, bottom), (right, top) = near.min(axis=0) - pad, near.max(axis=0) + pad
    return Window(min(rest.left, float(left)), max(rest.right, float(right)), min(rest.bottom, float(bottom)), max(rest.top, float(top)))
