"""The sheet around a rendered model: title, facts, scale bar and keys, all outside the model's own area.

Sizes are in pixels and one figure pixel is one image pixel, so that the scale bar is exact. Wide models have their keys below,
tall ones beside them.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import nice
from reports.drawing import palette
from reports.drawing.render import View

WIDTH = 1800  # of the sheet
MARGIN = 40
TITLE = 118  # height of title and facts
FACTS = ((14.0, 2), (12.0, 3), (10.5, 4))  # sizes of the letters of facts [points], and the lines that have room below the title
STRIP = 220  # height of the keys below, with their margins
COLUMN = 430  # width of the keys beside
TRIAD = 80.0  # width of the axes beside a scale bar
SEEN = 0.05  # share of its length that an axis must show in a picture to be drawn
INK, FAINT, COLOURS = palette.INK, palette.FAINT, palette.CURVES

Box = tuple[float, float, float, float]  # left, bottom, width, height
Paint = Callable[[Any, Box], None]  # paints the sign of a key's row into a box of some axes


@dataclass(frozen=True)
class Layout:
    """Where the model goes: (left, bottom, width, height) of its area on a sheet of a size."""

    size: tuple[int, int]
    model: tuple[int, int, int, int]
    beside: bool

    @property
    def pixels(self) -> tuple[int, int]:
        """Width and height of the model's image."""
        return self.model[2], self.model[3]

    def keys(self, count: int) -> list[Box]:
        """Boxes (left, bottom, width, height) for the keys, in reading order."""
        left, bottom, width, height = self.model
        if self.beside:
            each = height / count
            return [(left + width + MARGIN, bottom + height - (k + 1) * each, COLUMN - MARGIN, each) for k in range(count)]
        each = (self.size[0] - 2 * MARGIN) / count
        return [(MARGIN + k * each, MARGIN / 2, each - MARGIN, STRIP - MARGIN) for k in range(count)]


def layout(aspect: float) -> Layout:
    """The layout for a model of a given width over height."""
    if aspect >= 1.15:
        width = WIDTH - 2 * MARGIN
        height = int(np.clip(width / aspect, 640, 900))
        return Layout((WIDTH, TITLE + height + STRIP), (MARGIN, STRIP, width, height), beside=False)
    width, height = WIDTH - 2 * MARGIN - COLUMN, 1180
    return Layout((WIDTH, TITLE + height + MARGIN), (MARGIN, MARGIN, width, height), beside=True)


def in_metres(value: float) -> str:
    """A length as people say it: ``2 m``, ``50 cm``, ``0.4 mm``; what is too small to mean anything as ``under 1 µm``."""
    if abs(value) < 1e-6:
        return "under 1 µm"
    if value < 1e-4:
        return f"{value * 1e6:.3g} µm"
    if value >= 1.0:
        return f"{value:.3g} m"
    return f"{value * 100:.3g} cm" if value >= 0.1 else f"{value * 1000:.3g} mm"


def plain_axes(axes: Any, words: str) -> None:
    """A faint grid, a title at the axis, no frame."""
    axes.set_ylabel(words, fontsize=11, color=INK)
    axes.tick_params(labelsize=10.5, colors=FAINT)
    axes.grid(color="#e8eaed", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.margins(x=0.0)
    axes.axhline(0.0, color=FAINT, linewidth=0.6)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def save(figure: Any, path: Path) -> None:
    """Write a figure of matplotlib as a PNG.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        with replacing(path) as part:
            figure.savefig(part)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None


class Sheet:
    """A figure whose coordinates are pixels from the lower left corner."""

    def __init__(self, plan: Layout) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.plan = plan
        self._image: np.ndarray | None = None  # of the model
        self.figure: Any = Figure(figsize=(plan.size[0] / 100, plan.size[1] / 100), dpi=100, facecolor="white")
        FigureCanvasAgg(self.figure)

    def axes(self, left: float, bottom: float, width: float, height: float) -> Any:
        """Axes in a box of pixels, whose own coordinates are pixels from the box's lower left corner."""
        total = self.plan.size
        axes = self.figure.add_axes((left / total[0], bottom / total[1], width / total[0], height / total[1]))
        axes.set_xlim(0, width)
        axes.set_ylim(0, height)
        axes.set_axis_off()
        return axes

    def model(self, image: np.ndarray) -> None:
        """Place the image of the model, (height, width, 3) uint8, pixel by pixel."""
        self._image = image

    def head(self, title: str, facts: str) -> None:
        """Title and facts at the top; lines of facts that are wider than the sheet are broken between words."""
        axes = self.axes(MARGIN, self.plan.size[1] - TITLE, self.plan.size[0] - 2 * MARGIN, TITLE)
        for size, most in FACTS:
            lines = self._broken(facts, size)
            if len(lines) <= most:
                break
        crowded = len(lines) > 2
        axes.text(
            0, 92 if crowded else 72, textwrap.shorten(title, 95, placeholder=" …"), fontsize=23, weight="bold", color=INK, va="center",
            parse_math=False,
        )  # fmt: skip
        axes.text(0, 36 if crowded else 30, "\n".join(lines), fontsize=size, color=FAINT, va="center", parse_math=False)

    def _broken(self, text: str, size: float) -> list[str]:
        """The lines of a text in letters of a size [points], broken where they would not fit between the margins."""
        lines = []
        for line in text.split("\n"):
            words = line.split(" ")
            while words:
                count = len(words)
                while count > 1 and self._wide(" ".join(words[:count]), size) > self.plan.size[0] - 2 * MARGIN:
                    count -= 1
                lines.append(" ".join(words[:count]))
                words = words[count:]
        return lines

    def _wide(self, text: str, size: float) -> float:
        """Width of a text [pixels]."""
        from matplotlib.font_manager import FontProperties

        renderer = self.figure.canvas.get_renderer()
        return float(renderer.get_text_width_height_descent(text, FontProperties(size=size), ismath=False)[0])

    def scale_bar(self, axes: Any, metres_per_pixel: float, left: float, bottom: float, longest: float = 300.0) -> None:
        """A bar of a round length, in two halves."""
        from matplotlib.patches import Rectangle

        length = nice(longest * metres_per_pixel)
        width = length / metres_per_pixel
        for k, colour in enumerate((INK, "white")):
            axes.add_patch(Rectangle((left + k * width / 2, bottom), width / 2, 9, facecolor=colour, edgecolor=INK, linewidth=1.0))
        axes.text(left, bottom + 16, "0", fontsize=12, color=INK, ha="center")
        axes.text(left + width, bottom + 16, in_metres(length), fontsize=12, color=INK, ha="center")
        axes.text(left, bottom - 22, "in the plane of the picture", fontsize=11, color=FAINT)

    def triad(self, axes: Any, view: View, place: tuple[float, float], size: float = 26.0) -> None:
        """The axes x, y, z as a view shows them, from a place in pixels."""
        for name, colour, right, up in zip("xyz", palette.AXES.values(), view.right, view.up, strict=True):
            x, y = size * float(right), size * float(up)
            if math.hypot(x, y) < SEEN * size:  # it points at the reader
                continue
            axes.plot([place[0], place[0] + x], [place[1], place[1] + y], color=colour, linewidth=2.0)
            axes.text(place[0] + 1.45 * x, place[1] + 1.45 * y, name, fontsize=12, color=colour, ha="center", va="center")

    def swatches(self, axes: Any, rows: Sequence[tuple[Paint, str]], left: float, top: float, pitch: float = 32.0) -> None:
        """A key: per row a function that paints into a box (left, bottom, width, height), and a text."""
        for k, (paint, text) in enumerate(rows):
            bottom = top - (k + 1) * pitch
            paint(axes, (left, bottom + 6, 46.0, 16.0))
            axes.text(left + 60, bottom + 13, text, fontsize=13, color=INK, va="center", parse_math=False)

    def pixels(self, under: np.ndarray | None = None) -> np.ndarray:
        """The sheet as an image (height, width, 3) uint8, over another of its size whose signs lie beside its own."""
        self.figure.canvas.draw()
        out = np.asarray(self.figure.canvas.buffer_rgba())[..., :3].copy()
        if under is not None:
            np.minimum(out, under, out=out)
        if self._image is not None:
            left, bottom, width, height = self.plan.model
            top = len(out) - bottom - height
            out[top : top + height, left : left + width] = self._image
        return out

    def save(self, path: Path) -> None:
        """Write the PNG.

        Raises:
            InputError: the file cannot be written.
        """
        from PIL import Image

        try:
            with replacing(path) as part:
                Image.fromarray(self.pixels()).save(part, format="png", dpi=(100, 100))
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from None
