# SPDX-License-Identifier: GPL-3.0-or-later
"""Contents of a picture: surfaces, lines, joints, ties and words in plain arrays, from where it is seen, and its key.

A :class:`Scene` is built once, of a structure, of a frame of a run, of a mechanism or of a mode; VTK draws it off screen
(:mod:`reports.drawing.render`), SVG and PDF hold its polygons (:mod:`reports.drawing.vector`), the page's viewer gets its arrays
(:mod:`reports.page.model`), and files for ParaView take theirs from it. Colours, what hides what, and how joints and ties look are
decided here and in what builds it, not by those who draw. A scene is projected in parallel, so that one scale bar holds everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from reports.drawing import palette
from reports.drawing.bands import Bands, DrawnJoints
from reports.drawing.cut import CutPlane, caps_of, clipped, clipped_lines, clipped_ties, outline, traces
from reports.drawing.parts import AMONG, BEFORE, BEHIND, KeyPanel, Layer, Lines, Surface, Ties, View, Window, replaced

TIE = 5.0  # width of a tie [pixels of the sampled image]
APART = 0.01  # of layers behind and before everything, as a share of the picture's height


@dataclass(frozen=True, eq=False)
class PictureScene:
    """A picture."""

    view: View
    window: Window
    layers: Sequence[Layer]
    joints: DrawnJoints | None = None
    ties: Ties = field(default_factory=Ties)
    cut: CutPlane | None = None
    title: str = ""
    facts: str = ""
    key: Sequence[KeyPanel] = ()


def cut_layers(scene: PictureScene) -> list[Layer]:
    """The layers of a scene, as far as its plane leaves them, and the caps of what it closes."""
    cut, layers = scene.cut, list(scene.layers)
    if cut is None:
        return layers
    out: list[Layer] = [clipped(layer, cut) if isinstance(layer, Surface) else clipped_lines(layer, cut) for layer in layers]
    for layer in layers:
        if isinstance(layer, Surface) and layer.inside is not None:
            caps = caps_of(layer, cut)
            edges = next((other for other in layers if isinstance(other, Lines) and other.outline), None)
            out += [caps] if edges is None else [caps, outline(caps, edges.colour, edges.width)]
    return out


def joint_layers(scene: PictureScene, hidden: np.ndarray | None = None) -> list[Surface]:
    """The bands of its joints and the plates of parted faces; with ``hidden`` (2, N) sides, those that can be seen only."""
    joints, cut = scene.joints, scene.cut
    if joints is None:
        return []

    def kept(bands: Bands) -> Bands:
        return bands if hidden is None else bands.facing(scene.view)

    out = []
    if joints.shown.any():
        out.append(joints.dashed(kept(joints.bands(hidden))))
    if joints.parted.any():
        out.append(joints.plain(kept(joints.plates(hidden))))
    if cut is None:
        return out
    out = [clipped(surface, cut) for surface in out]
    return [*out, replaced(joints.dashed(traces(joints, cut)), spared=None)] if joints.shown.any() else out


def ties_of(scene: PictureScene) -> Ties:
    """Its ties, as far as the plane leaves them."""
    return scene.ties if scene.cut is None else clipped_ties(scene.ties, scene.cut)


def tie_layers(ties: Ties) -> list[Lines]:
    """Ties as lines before everything; slack ones in grey."""
    pairs, pulls = np.arange(2 * len(ties.ends)).reshape(-1, 2), ties.tension > 0.0
    kinds = ((palette.PULLING, pairs[pulls]), (palette.SLACK, pairs[~pulls]))
    return [Lines(ties.ends.reshape(-1, 3), chosen, colour, TIE, BEFORE) for colour, chosen in kinds if len(chosen)]


def placed(layers: list[Layer], view: View, height: float) -> list[Layer]:
    """Layers lifted by their share of a picture's height [m]; those behind and before everything flat, one after the other."""
    drawn = [layer.points[layer.loops if isinstance(layer, Surface) else layer.pairs.ravel()] for layer in layers if layer.place == AMONG]
    depth = np.concatenate([*(points @ view.towards for points in drawn), np.zeros(0 if any(map(len, drawn)) else 1)])
    levels = {BEHIND: float(depth.min()), BEFORE: float(depth.max()) + 2 * APART * height}
    out = []
    for layer in layers:
        if layer.place == AMONG:
            shift = np.full((len(layer.points), 1), layer.lift * height)
        else:
            levels[layer.place] += layer.place * APART * height
            shift = (levels[layer.place] - layer.points @ view.towards)[:, None]
        out.append(replaced(layer, points=layer.points + shift * view.towards))
    return out
