r"""The stress map: the structure with its blocks coloured by their largest compression, a principal stress of the mean over each block.

Without a time it shows the largest of the whole run, block by block, on the shape at the end; with a frame, the stress there. The mean
hides bending: joints whose edge is compressed above the given strength are drawn dark, or, where no strength is given, those where the
force came to an edge; of both only those that were open then: in a closed joint, rigid blocks do not fix the place of the force. Classes
have equal widths up to the largest compression of the run; blocks that have fallen keep their colour. Meshed blocks are drawn by their
elements, at the surface, with the stress of each.
View, cut, amplification and window are those of the crack map (:mod:`reports.maps.crack_map`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from masonry_cd.analysis.deformed import frame_index
from masonry_cd.analysis.stress.elements import ElementPeaks, element_peaks
from masonry_cd.analysis.stress.peaks import StressPeaks, above_limit, principal, stress_peaks
from masonry_cd.foundation.quantities import length, pressure
from masonry_cd.io.layout import EDGE_STRESS
from masonry_cd.io.results import Results
from reports.drawing.figure import Paint, Sheet, in_metres
from reports.drawing.render import SAMPLES, Canvas
from reports.drawing.structure_picture import SUPPORT, box_swatch, no_swatch, rgb, tie_swatch, within_sight
from reports.drawing.tie_lines import LABELLED, DrawnTies
from reports.maps.crack_key import SHADOW, STONE, ColourClasses, Marks, band_sign, draw_scale, draw_scale_bar
from reports.maps.crack_map import subject_of, ties_of
from reports.maps.framing import Framing, MapStyle, framing
from reports.maps.layers import STRONG, Subject, block_layers_of, joint_layers, shadow
from reports.maps.meshed_solids import Facetted
from reports.settings import report_of

FILE = "stress_map.png"
VECTOR = ("stress_map.svg", "stress_map.pdf")
COLOURS = ("YlOrRd", 0.0, 0.9)  # of the compression: pale to dark, distinguishable in grey print
MOST = 9  # classes


class StressScale(ColourClasses):
    """Classes of a compression from zero to a largest one [Pa], in the key in kPa or MPa."""

    def __init__(self, largest: float) -> None:
        largest = max(largest, 1.0)
        power = 10.0 ** math.floor(math.log10(largest / MOST))
        step = next(share * power for share in (1.0, 2.0, 2.5, 5.0, 10.0) if largest <= MOST * share * power * (1 + 1e-9))
        self.unit, factor = ("MPa", 1e-6) if largest >= 1e6 else ("kPa", 1e-3)
        super().__init__([k * step for k in range(math.ceil(largest / step))], COLOURS, factor)


@dataclass(frozen=True, eq=False)
class Pressed:
    """What a stress map shows of B blocks and J joints."""

    compression: np.ndarray  # (B,) largest, positive; NaN of supports [Pa]
    open_above: np.ndarray  # (J,) joints above their strength, or with a force at an edge where none is given, while open
    closed_above: np.ndarray  # (J,) and while closed only
    of_run: bool  # over the whole run, not at one frame
    peaks: StressPeaks
    of_elements: np.ndarray | None  # (E,) those of the elements of meshed blocks; None: there are none [Pa]
    element_peaks: ElementPeaks | None

    @classmethod
    def of(cls, results: Results, frame: int | None) -> Pressed:
        """That of a frame, or of the whole run for None.

        Raises:
            InputError: the run kept no stress.
        """
        peaks, elements = stress_peaks(results, report_of(results.scene).opened), element_peaks(results)
        if frame is None:
            of_elements = None if elements is None else elements.compression
            return cls(peaks.compression, peaks.open_above, peaks.closed_above, True, peaks, of_elements, elements)
        above = above_limit(np.asarray(results.joints_at(EDGE_STRESS, frame), dtype=float), peaks.joint_strength)
        gaping = results.joints_at("opening", frame) >= report_of(results.scene).opened
        compression = -principal(np.asarray(results.stress[frame], dtype=float))[:, 2]
        of_elements = None if elements is None else -principal(np.asarray(results.element_stress[frame], dtype=float))[:, 2]
        return cls(compression, above & gaping, above & ~gaping, False, peaks, of_elements, elements)

    @property
    def scale(self) -> StressScale:
        """Classes up to the largest compression of the run, so that the maps of its frames can be compared."""
        elements = np.zeros(0) if self.element_peaks is None else self.element_peaks.compression
        return StressScale(max(float(np.nan_to_num(values).max(initial=0.0)) for values in (self.peaks.compression, elements)))

    def largest(self, results: Results) -> tuple[float, str]:
        """The largest compression that is drawn [Pa], and in what, in words; NaN before the first step."""
        drawn, names = self.compression.copy(), [block.name for block in results.blocks]
        if self.of_elements is not None and self.element_peaks is not None:
            drawn[self.element_peaks.block] = -np.inf
            if not np.nan_to_num(drawn).max(initial=0.0) > np.nan_to_num(self.of_elements).max(initial=0.0):
                if not np.isfinite(self.of_elements).any():
                    return np.nan, ""
                worst = int(np.nanargmax(self.of_elements))
                return float(self.of_elements[worst]), f"an element of {names[self.element_peaks.block[worst]]}"
        if not np.isfinite(drawn).any():
            return np.nan, ""
        block = int(np.nanargmax(drawn))
        return float(drawn[block]), names[block]


def stress_sheet(results: Results, frame: int | None, style: MapStyle, samples: int = SAMPLES) -> Sheet:
    """The sheet of a frame, or of the whole run for None, drawn with shades.

    Raises:
        InputError: the run kept no stress; no such view or plane, or no off-screen OpenGL.
    """
    _, framed, pressed, subject = _prepared(results, frame, style)
    with Canvas(framed.view, framed.plan.pixels, samples) as canvas:
        layers = [shadow(subject), *block_layers_of(subject), *joint_layers(subject, framed.scales)]
        ties = ties_of(results, subject)
        layers += ties.layers(framed.view, float((subject.drawn @ framed.view.towards).max()) + 0.02 * framed.window.height)
        sheet = Sheet(framed.plan)
        sheet.model(ties.labelled(canvas.draw(layers, framed.window), framed.view, framed.window))
    _draw_around(sheet, results, subject, pressed, ties)
    return sheet


def vector_stress_maps(results: Results, folder: Path, frame: int | None, style: MapStyle) -> list[Path]:
    """Draw the same as polygons into stress_map.svg and stress_map.pdf; return the files.

    Raises:
        InputError: as :func:`stress_sheet`, or a folder that cannot be written into.
    """
    from reports.maps.vector_map import draw_polygons, save_vector

    shape, framed, pressed, subject = _prepared(results, frame, style)
    sheet = Sheet(framed.plan)
    ties = ties_of(results, subject)
    draw_polygons(sheet, results, shape, subject, ties)
    _draw_around(sheet, results, subject, pressed, ties)
    return save_vector(sheet, [folder / name for name in VECTOR], _title(results))


def _prepared(results: Results, frame: int | None, style: MapStyle) -> tuple[int, Framing, Pressed, Subject]:
    """The frame whose shape is drawn, its framing, the stresses, and what the sheet shows."""
    shape = frame_index(results, -1 if frame is None else frame)
    pressed = Pressed.of(results, None if frame is None else shape)
    framed = framing(results, [shape], replace(style, thrust=False))
    subject = subject_of(results, shape, framed)
    known = np.isfinite(pressed.compression)
    tint = np.where(known[:, None], pressed.scale(np.nan_to_num(pressed.compression)) / 255.0, rgb(STONE))
    none, no = np.zeros(subject.joints.count), np.zeros(subject.joints.count, dtype=bool)
    subject = replace(subject, tint=tint, strong=pressed.open_above, marks=Marks(none, none, no, no, no))
    return shape, framed, pressed, _with_elements(results, subject, shape, pressed)


def _with_elements(results: Results, subject: Subject, frame: int, pressed: Pressed) -> Subject:
    """What the sheet shows, with meshed blocks by their facets, each in the colour of its element."""
    if results.meshes is None or pressed.of_elements is None:
        return subject
    facetted = Facetted.of(subject.solids, results.meshes)
    colours = np.where(np.isfinite(pressed.of_elements)[:, None], pressed.scale(np.nan_to_num(pressed.of_elements)) / 255.0, rgb(STONE))
    tint = np.where((facetted.element >= 0)[:, None], colours[facetted.element], np.nan)
    moved = facetted.moved(results, subject.pose, frame, subject.framed.factor)
    return replace(subject, solids=facetted.solids, drawn=within_sight(facetted.solids, moved), face_tint=tint)


def _title(results: Results) -> str:
    return f"Stress: {results.title}" if results.title else "Stress"


def _draw_around(sheet: Sheet, results: Results, subject: Subject, pressed: Pressed, ties: DrawnTies) -> None:
    """The head, the scale of colours, the signs and the scale bar."""
    framed, boxes, peaks = subject.framed, sheet.plan.keys(4), pressed.peaks
    sheet.head(_title(results), _facts(results, subject, pressed))
    scale = pressed.scale
    draw_scale(sheet.axes(*boxes[0]), boxes[0], scale, f"{'Mean c' if pressed.of_elements is None else 'C'}ompression [{scale.unit}]")
    what = "edge above strength" if peaks.compared else "force at an edge"
    dark = rgb(STRONG)
    rows: list[tuple[Paint, str]] = [(partial(band_sign, first=dark, second=dark), f"open joint, {what} ({int(pressed.open_above.sum())})")]
    if pressed.closed_above.any():
        rows.append((no_swatch, f"closed ones likewise, not drawn ({int(pressed.closed_above.sum())})"))
    if peaks.compared:
        above = pressed.compression > peaks.block_strength
        rows.append((no_swatch, f"blocks above strength: {int(above.sum()) or 'none'}"))
        if pressed.of_elements is not None and pressed.element_peaks is not None:
            over = pressed.of_elements > pressed.element_peaks.strength
            rows.append((no_swatch, f"elements above strength: {int(over.sum()) or 'none'} of {len(over)}"))
    sheet.swatches(sheet.axes(*boxes[1]), rows, 0, boxes[1][3] - 4, pitch=29.0)
    others: list[tuple[Paint, str]] = [(partial(box_swatch, colour=SUPPORT), "support")]
    if framed.factor * subject.largest > 2 * framed.pixel:
        others.append((partial(box_swatch, colour=SHADOW), "shape at rest"))
    if len(ties.ends):
        others.append((tie_swatch, "tie, with its tension" if len(ties.ends) <= LABELLED else "tie"))
    sheet.swatches(sheet.axes(*boxes[2]), others, 0, boxes[2][3] - 4, pitch=29.0)
    draw_scale_bar(sheet, boxes[3], framed.view, framed.pixel)


def _facts(results: Results, subject: Subject, pressed: Pressed) -> str:
    """Which stress is shown, its largest value, view and amplification."""
    framed, time = subject.framed, subject.pose.time
    shape = "true shape" if framed.factor == 1 else f"displacements × {framed.factor:g}"
    cut = f", cut at {framed.cut.text}" if framed.cut else ""
    by = "block" if pressed.of_elements is None else "element"
    over = f"means over the {length(pressed.peaks.interval, 's')} between frames"
    which = f"largest of the run, {by} by {by}, {over}; shape at {time:.4g} s" if pressed.of_run else f"t = {time:.4g} s, {over}"
    value, place = pressed.largest(results)
    largest = f" · largest {pressure(value)} in {place}" if place else ""
    return f"{which}{largest}\n{framed.view.name} view{cut} · {shape}, largest displacement {in_metres(subject.largest)}"
