# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures read back, and counted in their pixels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from made_run import box

from masonry_cd.analysis.deformed import frame_index
from masonry_cd.io.results import Results
from reports.drawing.figure import Sheet, layout
from reports.drawing.palette import OPENING
from reports.drawing.parts import Scale
from reports.drawing.scene import PictureScene
from reports.maps.crack_map import crack_scene
from reports.maps.framing import MapStyle, framing

BASE = box("base", (-1.5, -0.5, -0.3), (1.5, 0.5, 0), "base", fixed=True)
COLUMN = [BASE, *(box(f"d{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1)) for k in range(3))]


def pixels(path: Path) -> np.ndarray:
    """The picture as (height, width, 3) uint8."""
    import matplotlib.image

    return (255 * matplotlib.image.imread(path)[..., :3]).round().astype(np.uint8)


def shares(image: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """Number of pixels of exactly each colour (N, 3)."""
    return np.array([(image == colour).all(axis=2).sum() for colour in colours])


def main_colours(path: Path, least: int = 20) -> set[str]:
    """The colours, as ``#rrggbb``, that at least some pixels have: those of areas, of curves and of letters, not of their soft edges."""
    found, count = np.unique(pixels(path).reshape(-1, 3), axis=0, return_counts=True)
    return {"#" + bytes(colour).hex() for colour in found[count >= least]}


def model_area(image: np.ndarray, aspect: float) -> np.ndarray:
    """The part of a sheet that shows the model."""
    left, bottom, width, height = layout(aspect).model
    top = image.shape[0] - bottom - height
    return image[top : top + height, left : left + width]


def opening_scale() -> Scale:
    return Scale(1e-4, 0.05, OPENING)


def scene_of(results: Results, frame: int = -1, style: MapStyle | None = None) -> PictureScene:
    """The crack map of a frame, in a framing of its own."""
    frame = frame_index(results, frame)
    return crack_scene(results, frame, framing(results, [frame], style or MapStyle()))


def crack_map(results: Results, path: Path, frame: int = -1, style: MapStyle | None = None) -> None:
    """Draw it into a PNG."""
    Sheet.drawn(scene_of(results, frame, style)).save(path)
