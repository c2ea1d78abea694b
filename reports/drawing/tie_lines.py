"""Ties in pictures: straight lines before everything else, each with its tension beside its middle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.analysis.ties import histories
from masonry_cd.foundation.quantities import force
from masonry_cd.io.results import Results
from reports.drawing import palette
from reports.drawing.render import Lines, View, Window

PULLING, SLACK = palette.PULLING, palette.SLACK
WIDTH = 5.0  # of a line [pixels of the sampled image]
LABELLED = 12  # ties; of more, those that pull most
LETTERS = 17  # height of a label [pixels]


@dataclass(frozen=True, eq=False)
class DrawnTies:
    """T ties as a picture shows them."""

    ends: np.ndarray  # (T, 2, 3) [m]
    texts: tuple[str, ...]  # of their labels
    tension: np.ndarray  # (T,) [N]

    def layers(self, view: View, nearest: float) -> list[Lines]:
        """The lines, before points that lie up to ``nearest`` towards the viewer [m]."""
        if not len(self.ends):
            return []
        points = self.ends.reshape(-1, 3)
        points = points + (nearest - points @ view.towards)[:, None] * view.towards
        pairs = np.arange(len(points)).reshape(-1, 2)
        pulls = self.tension > 0.0
        kinds = [(PULLING, pairs[pulls]), (SLACK, pairs[~pulls])]
        return [Lines(points, chosen, colour, WIDTH) for colour, chosen in kinds if len(chosen)]

    def labelled(self, image: np.ndarray, view: View, window: Window) -> np.ndarray:
        """An image (H, W, 3) uint8 of a window with the labels on it."""
        shown = np.argsort(-self.tension, kind="stable")[:LABELLED]
        if not len(shown):
            return image
        from PIL import Image, ImageDraw

        picture = Image.fromarray(image)
        pen = ImageDraw.Draw(picture)
        metre = image.shape[1] / window.width
        for i in shown.tolist():
            (x, y), (u, v) = view.plane(self.ends[i].mean(axis=0)[None])[0], view.plane(self.ends[i])[1] - view.plane(self.ends[i])[0]
            place = ((x - window.left) * metre, (window.top - y) * metre)
            above = (0, -0.9 * LETTERS) if abs(u) >= abs(v) else (2.2 * LETTERS, 0)
            colour = PULLING if self.tension[i] > 0.0 else "#5a5a5a"
            at = (place[0] + above[0], place[1] + above[1])
            pen.text(at, self.texts[i], fill=colour, font=_font(), anchor="mm", stroke_width=3, stroke_fill="white")
        return np.asarray(picture)


def ties_at(results: Results, solids: Solids, pose: Pose, factor: float) -> DrawnTies:
    """The ties at a frame; displacements are drawn amplified by a factor."""
    ends, texts, tension = [], [], []
    for tie in histories(results):
        blocks = np.array([bar.blocks for bar in tie.bars])
        moved = [pose.moved(solids, np.array([bar.points[k] for bar in tie.bars]), blocks[:, k], factor) for k in range(2)]
        weight = np.array([bar.section for bar in tie.bars]) / tie.area
        ends.append([weight @ points for points in moved])
        now = tie.at(pose.time)
        yielded = tie.yielding[: max(1, int(np.searchsorted(tie.time, pose.time * (1.0 + 1e-12), side="right")))].any()
        tension.append(now)
        texts.append(("slack" if now == 0.0 else force(now)) + (", has yielded" if yielded else ""))
    return DrawnTies(np.array(ends, dtype=float).reshape(-1, 2, 3), tuple(texts), np.array(tension))


def ties_as_built(ends: Sequence[np.ndarray]) -> DrawnTies:
    """Ties before any run, by their ends (2, 3) each [m]; without labels."""
    count = len(ends)
    return DrawnTies(np.array(ends, dtype=float).reshape(-1, 2, 3), ("",) * count, np.ones(count))


@cache
def _font() -> Any:
    """The letters of matplotlib's pictures."""
    from matplotlib import get_data_path
    from PIL import ImageFont

    return ImageFont.truetype(f"{get_data_path()}/fonts/ttf/DejaVuSans-Bold.ttf", LETTERS)
