# SPDX-License-Identifier: GPL-3.0-or-later
"""The sheet around a drawn model: title, facts, scale bar and keys, all outside the model's own area.

Sizes are in pixels and one figure pixel is one image pixel, so that the scale bar is exact. Wide models have their keys below,
tall ones next to them.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.figures import blank
from masonry_cd.foundation.quantities import nice
from reports.drawing import palette
from reports.drawing.parts import ColourClasses, KeyPanel, Sign, View
from reports.drawing.render import Canvas
from reports.drawing.scene import PictureScene, ties_of

WIDTH = 1800  # of the sheet
MARGIN = 40
TITLE = 118  # height of title and facts
FACTS = ((14.0, 2), (12.0, 3), (10.5, 4))  # sizes of the letters of facts [points], and the lines that fit below the title
STRIP = 220  # height of the keys below, with their margins
COLUMN = 430  # width of the keys at the side
TRIAD = 80.0  # width of the axes next to a scale bar
LABELLED = 12  # ties; of more, those that pull most
SEEN = 0.05  # share of its length that an axis must show in a picture to be drawn
INK, FAINT, COLOURS = palette.INK, palette.FAINT, palette.CURVES

PITCH, SIGN = 29.0, 46.0  # of the rows of a key, and width of a sign
LETTER = 8.6  # mean width of a letter of a note
WIDE = 0.58  # of a letter of the facts, as a share of its size

FIXED_TEXTS: dict[Any, Any] = {"svg.hashsalt": "masonry_cd", "svg.fonttype": "path", "pdf.fonttype": 42}

Box = tuple[float, float, float, float]  # left, bottom, width, height


@dataclass(frozen=True)
class SheetLayout:
    """Where the model goes: (left, bottom, width, height) of its area on a sheet of a size."""

    size: tuple[int, int]
    model: tuple[int, int, int, int]
    key_on_right: bool

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height of the model's image."""
        return self.model[2], self.model[3]

    def keys(self, wide: Sequence[int]) -> list[Box]:
        """Boxes (left, bottom, width, height) of the panels of a key, which take some places side by side, at most two above another."""
        left, bottom, width, height = self.model
        places = [min(n, 2) if self.key_on_right else n for n in wide]
        first = np.concatenate([[0], np.cumsum(places)])
        if self.key_on_right:
            each = height / first[-1]
            top = bottom + height
            return [(left + width + MARGIN, top - each * b, COLUMN - MARGIN, each * (b - a)) for a, b in pairwise(first.tolist())]
        each = (self.size[0] - 2 * MARGIN) / first[-1]
        return [(MARGIN + a * each, MARGIN / 2, (b - a) * each - MARGIN, STRIP - MARGIN) for a, b in pairwise(first.tolist())]


def layout(aspect: float) -> SheetLayout:
    """The layout for a model of a given width over height."""
    if aspect >= 1.15:
        width = WIDTH - 2 * MARGIN
        height = int(np.clip(width / aspect, 640, 900))
        return SheetLayout((WIDTH, TITLE + height + STRIP), (MARGIN, STRIP, width, height), key_on_right=False)
    width, height = WIDTH - 2 * MARGIN - COLUMN, 1180
    return SheetLayout((WIDTH, TITLE + height + MARGIN), (MARGIN, MARGIN, width, height), key_on_right=True)


def layout_of(scene: PictureScene) -> SheetLayout:
    """The layout for a scene."""
    return layout(scene.window.width / scene.window.height)


def in_metres(value: float) -> str:
    """A length as people say it: ``2 m``, ``50 cm``, ``0.4 mm``; what is too small to mean anything as ``under 1 µm``."""
    if abs(value) < 1e-6:
        return "under 1 µm"
    if value < 1e-4:
        return f"{value * 1e6:.3g} µm"
    if value >= 1.0:
        return f"{value:.3g} m"
    return f"{value * 100:.3g} cm" if value >= 0.1 else f"{value * 1000:.3g} mm"


def format_axes(axes: Any, words: str = "", across: str = "", grid: str = "both") -> None:
    """Titles at the axes, ticks, a faint grid behind, no frame."""
    axes.set_ylabel(words, fontsize=11, color=INK)
    axes.set_xlabel(across, fontsize=11, color=INK)
    axes.tick_params(labelsize=10, colors=FAINT, which="both")
    axes.grid(axis=grid, color="#e8eaed", linewidth=0.8)
    axes.set_axisbelow(True)
    for side, spine in axes.spines.items():
        spine.set_visible(side in ("left", "bottom"))
        spine.set_color(FAINT)


def draw_zero_line(axes: Any) -> None:
    """A line at zero, from edge to edge."""
    axes.margins(x=0.0)
    axes.axhline(0.0, color=FAINT, linewidth=0.6)


def save(figure: Any, path: Path, title: str = "") -> Path:
    """Write a figure of matplotlib as PNG, SVG or PDF by its ending, with nothing in it that depends on the day; return the path."""
    import matplotlib

    form = path.suffix[1:]
    undated: dict[str, Any] = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(form, {})
    try:
        with matplotlib.rc_context(FIXED_TEXTS), replacing(path) as part:
            figure.savefig(part, format=form, metadata=undated | ({"Title": title} if title else {}))
    except OSError as error:
        raise InputError(path, f"cannot be written: {error.strerror}") from None
    return path


def save_polygons(scene: PictureScene, folder: Path, name: str) -> list[Path]:
    """Write a scene as polygons into an SVG and a PDF of a name; return them."""
    figure = Sheet.as_polygons(scene).figure
    return [save(figure, folder / f"{name}.{form}", scene.title) for form in ("svg", "pdf")]


class Sheet:
    """A figure whose coordinates are pixels from the lower left corner."""

    def __init__(self, plan: SheetLayout) -> None:
        self.plan = plan
        self.figure = blank((plan.size[0] / 100, plan.size[1] / 100))

    def axes(self, left: float, bottom: float, width: float, height: float) -> Any:
        """Axes in a box of pixels, whose own coordinates are pixels from the box's lower left corner."""
        total = self.plan.size
        axes = self.figure.add_axes((left / total[0], bottom / total[1], width / total[0], height / total[1]))
        axes.set_xlim(0, width)
        axes.set_ylim(0, height)
        axes.set_axis_off()
        return axes

    @classmethod
    def drawn(cls, scene: PictureScene, samples: int | None = None) -> Sheet:
        """The sheet of a scene, drawn off screen; each pixel is the mean of samples x samples rendered ones.

        Raises:
            InputError: no off-screen OpenGL.
        """
        with Canvas(scene.view, layout_of(scene).pixels, samples) as canvas:
            return cls.drawn_on(canvas, scene)

    @classmethod
    def drawn_on(cls, canvas: Canvas, scene: PictureScene, panels: Sequence[KeyPanel] | None = None) -> Sheet:
        """The sheet of a scene, drawn on a canvas of its size, with all of its key or some ``panels``."""

        def draw(axes: Any, fitted: PictureScene) -> None:
            axes.imshow(canvas.draw(fitted), extent=(*axes.get_xlim(), *axes.get_ylim()), interpolation="none", aspect="auto")

        return cls._with_model(scene, draw, panels)

    @classmethod
    def as_polygons(cls, scene: PictureScene) -> Sheet:
        """The sheet of a scene whose model is polygons, for SVG and PDF."""
        from reports.drawing.vector import draw_polygons

        return cls._with_model(scene, draw_polygons)

    @classmethod
    def _with_model(cls, scene: PictureScene, draw: Callable[[Any, PictureScene], None], panels: Sequence[KeyPanel] | None = None) -> Sheet:
        """The sheet of a scene; ``draw`` puts the model into axes in metres of the plane of the picture."""
        sheet = cls.around(scene, panels)
        window = scene.window.fitted(sheet.plan.pixels)
        axes = sheet.axes(*sheet.plan.model)
        axes.set_xlim(window.left, window.right)
        axes.set_ylim(window.bottom, window.top)
        draw(axes, replace(scene, window=window))
        label_ties(axes, scene)
        return sheet

    @classmethod
    def around(cls, scene: PictureScene, panels: Sequence[KeyPanel] | None = None) -> Sheet:
        """Return the sheet around the model of a scene: title, facts and key, or of the key some ``panels`` alone."""
        sheet = cls(layout_of(scene))
        sheet.draw_head(scene.title, scene.facts)
        boxes = sheet.plan.keys([panel.wide for panel in scene.key]) if scene.key else []
        pixel = scene.window.fitted(sheet.plan.pixels).width / sheet.plan.pixels[0]
        for panel, box in zip(scene.key, boxes, strict=True):
            if panels is None or panel in panels:
                sheet.draw_panel(panel, box, scene.view, pixel)
        return sheet

    def draw_head(self, title: str, facts: str) -> None:
        """Title and facts at the top; lines of facts that are wider than the sheet are broken between words."""
        axes = self.axes(MARGIN, self.plan.size[1] - TITLE, self.plan.size[0] - 2 * MARGIN, TITLE)
        for size, most in FACTS:
            letters = int(72 * (self.plan.size[0] - 2 * MARGIN) / (100 * WIDE * size))
            lines = [part for line in facts.split("\n") for part in textwrap.wrap(line, letters)]
            if len(lines) <= most:
                break
        high, low = (92, 36) if len(lines) > 2 else (72, 30)
        look = {"va": "center"}
        axes.text(0, high, textwrap.shorten(title, 95, placeholder=" …"), fontsize=23, weight="bold", color=INK, **look)
        axes.text(0, low, "\n".join(lines), fontsize=size, color=FAINT, **look)

    def draw_scale_bar(self, axes: Any, metres_per_pixel: float, left: float, bottom: float, longest: float = 300.0) -> None:
        """A bar of a round length, in two halves."""
        from matplotlib.patches import Rectangle

        length = nice(longest * metres_per_pixel)
        width = length / metres_per_pixel
        for k, colour in enumerate((INK, "white")):
            axes.add_patch(Rectangle((left + k * width / 2, bottom), width / 2, 9, facecolor=colour, edgecolor=INK, linewidth=1.0))
        axes.text(left, bottom + 16, "0", fontsize=12, color=INK, ha="center")
        axes.text(left + width, bottom + 16, in_metres(length), fontsize=12, color=INK, ha="center")
        axes.text(left, bottom - 22, "in the plane of the picture", fontsize=11, color=FAINT)

    def draw_panel(self, panel: KeyPanel, box: Box, view: View, pixel: float) -> None:
        """A part of the key, from the top of its box; a pixel of the model is so large [m]."""
        axes, (width, top) = self.axes(*box), box[2:]
        if panel.scale is not None:
            _draw_scale(axes, width, top, *panel.scale, panel.dashed)
            top -= 84
        if panel.ruler:
            self.draw_scale_bar(axes, pixel, 10, top - 44, width - 60 - TRIAD)
            draw_triad(axes, view, (width - 0.5 * TRIAD, top - 58))
            top -= 80
        per_column = max(1, int((top - 4) // PITCH))
        rows, most = list(panel.signs), per_column * (1 if self.plan.key_on_right else panel.wide)
        if len(rows) > most:
            rows = [*rows[: most - 1], Sign("", f"and {len(rows) - most + 1} more")]
        for k, sign in enumerate(rows):
            left = k // per_column * (width + MARGIN) / panel.wide
            bottom = top - 4 - (k % per_column + 1) * PITCH
            _draw_sign(axes, sign, left, bottom)
        for k, line in enumerate(textwrap.wrap(panel.note, max(20, int(width / LETTER)))):
            axes.text(0, top - 10 - PITCH * len(rows) - 24 * k, line, fontsize=12, color=INK, va="center")

    def pixels(self, under: np.ndarray | None = None) -> np.ndarray:
        """The sheet as an image (height, width, 3) uint8, over another of its size whose signs lie next to its own."""
        self.figure.canvas.draw()
        out = np.asarray(self.figure.canvas.buffer_rgba())[..., :3].copy()
        if under is not None:
            np.minimum(out, under, out=out)
        return out

    def save(self, path: Path) -> None:
        """Write the PNG."""
        save(self.figure, path)


def draw_triad(axes: Any, view: View, place: tuple[float, float], size: float = 26.0) -> None:
    """The axes x, y, z as a view shows them, from a place in pixels."""
    for name, colour, right, up in zip("xyz", palette.AXES.values(), view.right, view.up, strict=True):
        x, y = size * float(right), size * float(up)
        if math.hypot(x, y) < SEEN * size:  # it points at the reader
            continue
        axes.plot([place[0], place[0] + x], [place[1], place[1] + y], color=colour, linewidth=2.0)
        axes.text(place[0] + 1.45 * x, place[1] + 1.45 * y, name, fontsize=12, color=colour, ha="center", va="center")


def label_ties(axes: Any, scene: PictureScene) -> None:
    """The labels of its ties, of many those that pull most, next to their middles."""
    ties = ties_of(scene)
    for i in [i for i in np.argsort(-ties.tension, kind="stable")[:LABELLED].tolist() if ties.texts[i]]:
        flat, colour = scene.view.plane(ties.ends[i]), palette.PULLING if ties.tension[i] > 0.0 else FAINT
        along = np.abs(np.ptp(flat, axis=0))
        shift = (0, 12) if along[0] >= along[1] else (30, 0)
        look = {
            "fontsize": 12,
            "weight": "bold",
            "color": colour,
            "ha": "center",
            "va": "center",
            "path_effects": halo(),
        }
        axes.annotate(ties.texts[i], flat.mean(axis=0), shift, textcoords="offset points", annotation_clip=True, **look)


def halo() -> list[Any]:
    """White around a text, so that it can be read over lines."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=3.0, foreground="white")]


def _draw_sign(axes: Any, sign: Sign, left: float, bottom: float) -> None:
    """A row of a key."""
    from matplotlib.patches import Rectangle

    middle = bottom + 13
    if sign.kind == "box":
        axes.add_patch(Rectangle((left, bottom + 5), SIGN, 16, facecolor=sign.colours[0], edgecolor=palette.EDGE, linewidth=1.0))
    elif sign.kind == "band":  # a piece of a band, its dashes alternating
        for k in range(3):
            colour = sign.colours[k % len(sign.colours)]
            axes.add_patch(Rectangle((left + k * SIGN / 3, middle - 4), SIGN / 3, 8, facecolor=colour, linewidth=0))
    elif sign.kind == "line":
        axes.plot([left, left + SIGN], [middle] * 2, color=sign.colours[0], linewidth=3.0)
    elif sign.kind == "dot":
        axes.plot([left + SIGN / 2], [middle], "o", color=sign.colours[0], markersize=7.0)
    axes.text(left + SIGN + 14, middle, sign.text, fontsize=13, color=INK, va="center")


def _draw_scale(axes: Any, width: float, top: float, name: str, scale: ColourClasses, dashed: bool) -> None:
    """A row of boxes with their bounds below; dashed ones leave a gap, as the dashes of a map do."""
    from matplotlib.patches import Rectangle

    bottom, start, each = top - 66, 10, (width - 40) / len(scale.bounds)
    axes.text(0, top - 24, name, fontsize=14, weight="bold", color=INK, va="center")
    for k, (bound, colour) in enumerate(zip(scale.bounds, scale.colours, strict=True)):
        left = start + k * each
        axes.add_patch(Rectangle((left, bottom), each * (0.66 if dashed else 1.0), 26, facecolor=colour / 255.0, linewidth=0))
        axes.plot([left, left], [bottom - 6, bottom], color=FAINT, linewidth=1.0)
        axes.text(left, bottom - 18, f"{bound * scale.factor:.3g}", fontsize=11, color=INK, ha="center", va="center")
    axes.text(start + len(scale.bounds) * each + 6, bottom + 13, "+", fontsize=14, color=INK, va="center")
