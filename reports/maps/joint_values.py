# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps whose joints are coloured by a value of each, at rest: how often a joint opened over many runs, or by how much in the median.

They have the look of a crack map, in its framing but without displacements: what many runs did has no shape of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from masonry_cd.io.results import Results
from reports.drawing.figure import Sheet, layout_of
from reports.drawing.parts import RULER, ColourClasses, Panel, Sign
from reports.drawing.render import Canvas
from reports.maps.crack_map import at_rest
from reports.maps.framing import MapStyle


@dataclass(frozen=True, eq=False)
class JointValues:
    """What a map shows.

    Attributes:
        path: of the PNG.
        title: of the sheet.
        facts: the line below the title.
        values: (J,) one per joint.
        scale: their classes; joints whose value lies below its first bound are not drawn.
        name: what the scale says, with the unit.
        rows: lines of the key.
    """

    path: Path
    title: str
    facts: str
    values: np.ndarray
    scale: ColourClasses
    name: str
    rows: tuple[str, ...] = ()

    @property
    def drawn(self) -> np.ndarray:
        """(J,) bool."""
        return self.values >= self.scale.bounds[0]

    @property
    def key(self) -> list[Panel]:
        """The scale, the lines of the key, and the scale bar."""
        coloured = Sign("band", f"joints coloured: {int(self.drawn.sum())} of {len(self.values)}", (self.scale.middle,))
        return [Panel(scale=(self.name, self.scale), wide=2), Panel([coloured, *(Sign("", row) for row in self.rows)]), RULER]


def draw_joint_values(results: Results, maps: Iterable[JointValues], style: MapStyle) -> list[Path]:
    """Draw maps on the structure at rest, all in one framing and on one canvas.

    Raises:
        InputError: no such view or plane, no off-screen OpenGL, or a path that cannot be written.
    """
    scene, written = at_rest(results, style), []
    assert scene.joints is not None
    with Canvas(scene.view, layout_of(scene).pixels) as canvas:
        for one in maps:
            hues = one.scale(one.values)
            joints = replace(scene.joints, shown=one.drawn, colours=(hues, hues))
            drawn = replace(scene, joints=joints, title=one.title, facts=one.facts, key=one.key)
            Sheet.drawn_on(canvas, drawn).save(one.path)
            written.append(one.path)
    return written
