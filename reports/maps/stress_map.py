# SPDX-License-Identifier: GPL-3.0-or-later
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

import numpy as np

from masonry_cd.analysis.deformed import frame_index
from masonry_cd.analysis.stress.elements import ElementPeaks, element_peaks
from masonry_cd.analysis.stress.peaks import StressPeaks, above_limit, principal, stress_peaks
from masonry_cd.foundation.quantities import length, pressure
from masonry_cd.io.layout import EDGE_STRESS
from masonry_cd.io.results import Results
from reports.drawing import palette
from reports.drawing.figure import in_metres
from reports.drawing.parts import RULER, ColourClasses, KeyPanel, Sign, painted, rgb
from reports.drawing.scene import PictureScene
from reports.drawing.solids import within_sight
from reports.maps.crack_map import MapSubject, fill_signs, other_signs, shape_in_words
from reports.maps.framing import MapStyle, framing
from reports.maps.meshed_solids import Facetted
from reports.settings import report_of

MOST = 9  # classes


class StressScale(ColourClasses):
    """Classes of a compression from zero to a largest one [Pa], in the key in kPa or MPa."""

    def __init__(self, largest: float) -> None:
        largest = max(largest, 1.0)
        power = 10.0 ** math.floor(math.log10(largest / MOST))
        step = next(share * power for share in (1.0, 2.0, 2.5, 5.0, 10.0) if largest <= MOST * share * power * (1 + 1e-9))
        self.unit, factor = ("MPa", 1e-6) if largest >= 1e6 else ("kPa", 1e-3)
        super().__init__([k * step for k in range(math.ceil(largest / step))], palette.PRESSED, factor)


@dataclass(frozen=True, eq=False)
class Pressed:
    """Stresses of B blocks and J joints in a map."""

    compression: np.ndarray  # (B,) largest, positive; NaN of supports [Pa]
    open_above: np.ndarray  # (J,) joints above their strength, or with a force at an edge where none is given, while open
    closed_above: np.ndarray  # (J,) and while closed only
    of_run: bool  # over the whole run, not at one frame
    peaks: StressPeaks
    of_elements: np.ndarray | None  # (E,) those of the elements of meshed blocks; None: there are none [Pa]
    element_peaks: ElementPeaks | None

    @classmethod
    def of(cls, results: Results, frame: int | None) -> Pressed:
        """That of a frame, or of the whole run for None."""
        peaks, elements = stress_peaks(results, report_of(results.tables).opened), element_peaks(results)
        if frame is None:
            of_elements = None if elements is None else elements.compression
            return cls(peaks.compression, peaks.open_above, peaks.closed_above, True, peaks, of_elements, elements)
        above = above_limit(np.asarray(results.joints_at(EDGE_STRESS, frame), dtype=float), peaks.joint_strength)
        gaping = results.joints_at("opening", frame) >= report_of(results.tables).opened
        compression = -principal(np.asarray(results.stress[frame], dtype=float))[:, 2]
        of_elements = None if elements is None else -principal(np.asarray(results.element_stress[frame], dtype=float))[:, 2]
        return cls(compression, above & gaping, above & ~gaping, False, peaks, of_elements, elements)

    @property
    def scale(self) -> StressScale:
        """Classes up to the largest compression of the run, so that the maps of its frames can be compared."""
        elements = np.zeros(0) if self.element_peaks is None else self.element_peaks.compression
        return StressScale(max(float(np.nan_to_num(values).max(initial=0.0)) for values in (self.peaks.compression, elements)))

    def largest(self, results: Results) -> tuple[float, str]:
        """The largest compression that is drawn [Pa], and in what, as text; NaN before the first step."""
        values, places = self.compression, [block.name for block in results.blocks]
        if self.of_elements is not None and self.element_peaks is not None:
            owner = self.element_peaks.block
            values = np.concatenate([np.where(np.isin(np.arange(len(places)), owner), np.nan, values), self.of_elements])
            places += [f"an element of {places[block]}" for block in owner]
        worst = int(np.argmax(np.nan_to_num(values, nan=-np.inf)))
        return float(values[worst]), places[worst] if np.isfinite(values[worst]) else ""


def stress_scene(results: Results, frame: int | None, style: MapStyle) -> PictureScene:
    """The stress map of a frame, or of the whole run for None.

    Raises:
        InputError: the run kept no stress; no such view or plane.
    """
    shape = frame_index(results, -1 if frame is None else frame)
    pressed = Pressed.of(results, None if frame is None else shape)
    framed = framing(results, [shape], style)
    subject, faces = _with_elements(results, MapSubject.of(results, shape, framed), shape, pressed)
    colours = np.where(subject.solids.fixed[:, None], rgb(palette.SUPPORT), _colours(pressed, pressed.compression))
    dark = painted(palette.STRONG, subject.joints.count)
    joints = replace(subject.drawn_joints(), shown=pressed.open_above, colours=(dark, dark))
    scene = subject.scene(joints, colours, faces)
    return replace(
        scene, title=f"Stress: {results.title}".removesuffix(": "), facts=_facts(results, subject, pressed), key=_key(subject, pressed)
    )


def _colours(pressed: Pressed, compression: np.ndarray) -> np.ndarray:
    """(N, 3) 0..1 of compressions (N,) [Pa]; unknown ones have the colour of stone."""
    known = np.isfinite(compression)[:, None]
    return np.asarray(np.where(known, pressed.scale(np.nan_to_num(compression)) / 255.0, rgb(palette.STONE)))


def _with_elements(results: Results, subject: MapSubject, frame: int, pressed: Pressed) -> tuple[MapSubject, np.ndarray | None]:
    """Return the subject of the sheet, with meshed blocks by their facets, each in the colour (F, 3) of its element."""
    if results.meshes is None or pressed.of_elements is None:
        return subject, None
    facetted = Facetted.of(subject.solids, results.meshes)
    faces = np.where((facetted.element >= 0)[:, None], _colours(pressed, pressed.of_elements)[facetted.element], np.nan)
    moved = facetted.moved(results, subject.pose, frame, subject.framed.factor)
    return replace(subject, solids=facetted.solids, drawn=within_sight(facetted.solids, moved)), faces


def _key(subject: MapSubject, pressed: Pressed) -> list[KeyPanel]:
    """The scale of colours, the signs and the scale bar."""
    peaks, scale = pressed.peaks, pressed.scale
    what = "edge above strength" if peaks.compared else "force at an edge"
    rows = [Sign("band", f"open joint, {what} ({int(pressed.open_above.sum())})", (palette.STRONG,))]
    if pressed.closed_above.any():
        rows.append(Sign("", f"closed ones likewise, not drawn ({int(pressed.closed_above.sum())})"))
    if peaks.compared:
        above = pressed.compression > peaks.block_strength
        rows.append(Sign("", f"blocks above strength: {int(above.sum()) or 'none'}"))
        if pressed.of_elements is not None and pressed.element_peaks is not None:
            over = pressed.of_elements > pressed.element_peaks.strength
            rows.append(Sign("", f"elements above strength: {int(over.sum()) or 'none'} of {len(over)}"))
    others = [Sign("box", "support", (palette.SUPPORT,)), *fill_signs(subject), *other_signs(subject)]
    name = f"{'Mean c' if pressed.of_elements is None else 'C'}ompression [{scale.unit}]"
    return [KeyPanel(scale=(name, scale)), KeyPanel(rows), KeyPanel(others), RULER]


def _facts(results: Results, subject: MapSubject, pressed: Pressed) -> str:
    """Which stress is shown, its largest value, view and amplification."""
    time = subject.pose.time
    by = "block" if pressed.of_elements is None else "element"
    over = f"means over the {length(pressed.peaks.interval, 's')} between frames"
    which = f"largest of the run, {by} by {by}, {over}; shape at {time:.4g} s" if pressed.of_run else f"t = {time:.4g} s, {over}"
    value, place = pressed.largest(results)
    largest = f" · largest {pressure(value)} in {place}" if place else ""
    return f"{which}{largest}\n{shape_in_words(subject)}, largest displacement {in_metres(subject.largest)}"
