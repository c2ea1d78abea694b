"""Maps whose joints are coloured by a value of each, at rest: how often a joint opened over many runs, or by how much in the median.

They have the look of a crack map, in its framing but without displacements: what many runs did has no shape of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.deformed import solids_of
from masonry_cd.io.results import Results
from reports.drawing.figure import Sheet, layout
from reports.drawing.render import Canvas
from reports.drawing.structure_picture import no_swatch, structure_window, within_sight
from reports.maps.crack_key import ColourClasses, Marks, band_sign, draw_scale, draw_scale_bar
from reports.maps.framing import Framing, MapStyle, view_and_cut
from reports.maps.layers import Subject, block_layers_of, coloured_bands


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


def draw_joint_values(results: Results, maps: Iterable[JointValues], style: MapStyle) -> list[Path]:
    """Draw maps on the structure at rest, all in one framing and on one canvas.

    Raises:
        InputError: no such view or plane, no off-screen OpenGL, or a path that cannot be written.
    """
    subject = at_rest(results, style)
    framed, written = subject.framed, []
    with Canvas(framed.view, framed.plan.pixels) as canvas:
        for one in maps:
            hues = one.scale(one.values)
            layers = [*block_layers_of(subject), *coloured_bands(subject, one.drawn, hues, hues)]
            sheet = Sheet(framed.plan)
            sheet.model(canvas.draw(layers, framed.window))
            sheet.head(one.title, one.facts)
            _keys(sheet, one, framed)
            sheet.save(one.path)
            written.append(one.path)
    return written


def at_rest(results: Results, style: MapStyle) -> Subject:
    """The structure as it was built, all blocks standing.

    Raises:
        InputError: no such view or plane.
    """
    solids = solids_of(results.blocks)
    view, cut = view_and_cut(solids, style)
    rest = structure_window(solids, view)
    plan = layout(rest.width / rest.height)
    framed = Framing(style, view, cut, 0.0, rest.fitted(plan.pixels), plan, alone=True)
    start = DamageSnapshot.at(results, 0, style.thresholds)
    snapshot = replace(start, down=np.zeros_like(start.down))
    return Subject(framed, results.joints, solids, snapshot, False, Marks.of(snapshot), within_sight(solids, solids.vertices), "", "")


def _keys(sheet: Sheet, one: JointValues, framed: Framing) -> None:
    """The scale, the lines of the key, and the scale bar."""
    boxes = sheet.plan.keys(4)
    if sheet.plan.beside:
        draw_scale(sheet.axes(*boxes[0]), boxes[0], one.scale, one.name)
    else:  # two places side by side for one scale
        wide = (boxes[0][0], boxes[0][1], boxes[1][0] + boxes[1][2] - boxes[0][0], boxes[0][3])
        draw_scale(sheet.axes(*wide), wide, one.scale, one.name)
    middle = one.scale.colours[len(one.scale.colours) // 2] / 255.0
    signs = [(partial(band_sign, first=middle, second=middle), f"joints coloured: {int(one.drawn.sum())} of {len(one.values)}")]
    sheet.swatches(sheet.axes(*boxes[2]), [*signs, *((no_swatch, row) for row in one.rows)], 0, boxes[2][3] - 4, pitch=29.0)
    draw_scale_bar(sheet, boxes[3], framed.view, framed.pixel)
