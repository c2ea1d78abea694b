# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the page: the packed content of a result, with the texts and the scripts, in one file.

The file stays below ``LIMIT``: where all frames would not fit, fewer of them are sent, evenly spread, and the page says how many.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.joint_damage import JointDamage, joint_damage
from masonry_cd.analysis.damage.part_damage import PartDamage
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.dynamics.energy_terms import ENERGIES
from reports.drawing import palette
from reports.drawing.parts import Scale, hexed
from reports.drawing.solids import within_sight
from reports.maps.crack_map import at_rest
from reports.maps.framing import MapStyle, amplification
from reports.page import model, motion, sections, series, stress, words
from reports.page.document import Head, running, script_of, title_block, write_document
from reports.page.pack import packed, packed_length
from reports.page.section import KNOWN
from reports.ties import tie_lines, tie_tensions

LIMIT = 13_500_000  # of the packed data [bytes]: with names and scripts the page stays below 15 MB
FRAMES = 600  # sent at most
PLOTTED = 6  # motions of supports that are plotted, those that go farthest; the page has a table of all
LARGEST = 0.05  # where the last class of the colour scales begins, as in the crack map [m]
SCRIPTS = ("unpack.js", "motion.js", "camera.js", "shaders.js", "viewer.js", "plots.js", "charts.js", "table.js", "main.js")


def write_page(
    results: Results,
    path: Path,
    summary: Summary | None = None,
    thresholds: Thresholds | None = None,
    scale: float | None = None,
    largest: float = LARGEST,
    parts: PartDamage | None = None,
    limit: int = LIMIT,
) -> None:
    """Write a run as one HTML file that needs nothing else.

    What ``summary`` lacks of summary.json is left out. Displacements are amplified by ``scale`` at first; None picks 1, or what makes the
    largest one visible. The last class of the colours begins at ``largest`` [m]. The packed data keep a ``limit`` [bytes] by leaving out
    frames.

    Raises:
        InputError: a scale that is not positive, or a path that cannot be written.
    """
    thresholds, summary = thresholds or Thresholds(), summary or Summary()
    if scale is not None and not (np.isfinite(scale) and scale > 0):
        raise InputError("scale", f"must be positive, got {scale!r}")
    tolerance = _tolerance(results, summary)
    missed, steps, missed_times = series.steps_missed(results, tolerance)
    carried = sections.carried_tables(results, joint_damage(results, thresholds), parts)
    context = words.PageContext(results, thresholds, end_state(results, thresholds), missed, steps, tolerance, summary, parts, carried)
    facts, text = _data(context, largest, {**carried, "missed": missed_times}, limit)
    asked = context.report.get("view", "auto")
    facts |= {"view": asked} if asked != "auto" else {}
    facts |= {"tolerance": tolerance, "missed": missed, "steps": steps, "planar": summary.planar}
    run = context.measured
    free = run.solids.vertices[~run.solids.fixed[run.solids.vertex_block]]
    size = float(np.ptp(free, axis=0).max()) if len(free) else 1.0
    facts["factor"] = scale if scale is not None else amplification(run.displacement_max, bool(run.fallen), size)  # as in the crack map
    title, lines = results.title or "Report of a run", [words.lead(context), *words.outcome(context)]
    write_document(
        path,
        "run.html",
        title=title,
        running=running(context),
        page=Head(title, lines, words.notices(context), words.tiles(context), title_block(context), context.verdict, "trust"),
        above=_sections(context, above=True),
        below=_sections(context, above=False),
        settings=words.settings(context),
        scene=results.scene or "The result keeps no scene.",
        facts=json.dumps(facts, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c").replace("/", "\\/"),
        data=text,
        script=script_of("reports.page", *SCRIPTS),
    )


def _tolerance(results: Results, summary: Summary) -> float:
    """The tolerance of the run: from its summary, else from its scene, else the default."""
    from masonry_cd.mechanics.dynamics.settings import Run

    if summary.solver.has("tolerance"):
        return summary.solver.tolerance
    return float(results.tables.get("run", {}).get("tolerance", Run.model_fields["tolerance"].default))


def _data(context: words.PageContext, largest: float, more: Mapping[str, np.ndarray], limit: int) -> tuple[dict[str, Any], str]:
    """The numbers: what fits into JSON, and the arrays, with some more by name, as one packed text."""
    results, solids, table, classes = context.results, context.solids, context.table, (context.thresholds, largest)
    moving = [motion for motion in context.motions if motion.moves][:PLOTTED]
    facts = model.names_and_words(results, solids, classes[0]) | {"energies": ENERGIES}
    arrays = model.blocks_and_damage(results, solids, at_rest(results, MapStyle()), table) | tie_lines(results, model.origin_of(solids))
    arrays["vertices"] = solids.vertices.astype(np.float32)
    facts["motions"] = ["" if len(context.motions) == 1 else motion.called for motion in moving]
    facts["motions_at_rest"] = len(moving) > 0 and not all(motion.moves for motion in context.motions)
    facts["motions_left_out"] = sum(motion.moves for motion in context.motions) - len(moving)
    curves = series.base_motion(results, moving) | series.step_curves(results)
    for name, curve in curves.items():
        arrays |= {f"{name}/time": curve.time, f"{name}/value": curve.value}
    arrays |= more
    moved = motion.read_motion(results, solids, motion.frames_shown(results.frames, FRAMES))
    count = len(moved.frames)
    while True:
        histories, units, scales = _histories(moved, table, *classes)
        length = packed_length(arrays, histories)
        if length <= limit or count <= 2:
            break
        count = max(2, min(count - 1, int(0.97 * count * limit / length)))
        moved = moved.only(motion.frames_shown(len(moved.frames), count))
    seen = model.camera(solids, moved)
    origin, box = model.origin_of(solids), np.array([seen["low"], seen["high"]])  # a wide ground is sent as near as it is seen
    arrays["vertices"] = (within_sight(solids, solids.vertices, box + origin) - origin).astype(np.float32)
    down, apart = motion.read_losses(results, solids, moved, classes[0])
    flags = {"fallen": motion.bits(down), "separated": motion.bits(apart)}
    gone = np.array([~results.present(frame) for frame in moved.frames.tolist()])
    flags |= {"absent": motion.bits(gone)} if gone.any() else {}
    classes_of_stress, pressed = stress.colours(results, moved.frames)
    contents, text = packed(arrays | units | flags | pressed | tie_tensions(results, moved.time), histories)
    facts |= {"contents": contents, "frames": len(moved.frames), "frames_written": results.frames, "scales": scales}
    return facts | seen | classes_of_stress, text


def _histories(
    moved: motion.PageMotion, table: JointDamage, thresholds: Thresholds, largest: float
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], dict[str, Any]]:
    """The histories in whole numbers, their times and units, and the classes of the two colour scales."""
    displacement, metre = motion.whole(moved.displacement)
    rotation, radian = motion.whole(moved.rotation)
    units = {"time": moved.time.astype(np.float32), "displacement_unit": metre, "rotation_unit": radian}
    histories, scales = {"displacement": displacement, "rotation": rotation}, {}
    measures = (
        ("opening", thresholds.opened, palette.OPENING, table.max_opening),
        ("sliding", thresholds.slid, palette.SLIDING, table.max_sliding),
    )
    for name, threshold, colours, peak in measures:  # peaks are over the steps, of which the frames show a few
        codes, lowest, per_e = motion.logarithms(np.concatenate([getattr(moved, name), peak[None]]), threshold)
        histories[name], units[f"{name}_peak"] = np.ascontiguousarray(codes[:, :-1]), np.ascontiguousarray(codes[:, -1])
        scale = Scale(threshold, max(largest, 2.0 * threshold), colours)
        bounds = [1 + int(np.floor(np.log(bound / lowest) * per_e + 1e-9)) for bound in scale.bounds]
        hues = [hexed(colour) for colour in scale.colours]
        scales[name] = {"lowest": lowest, "per_e": per_e, "bounds": scale.bounds, "codes": bounds, "colours": hues}
    return histories, units, scales


def _sections(context: words.PageContext, above: bool) -> list[tuple[str, str, str]]:
    """The sections above the model or below it that the page has, in their order: name, title and HTML."""
    own = sorted((item for item in KNOWN.items() if (item[1].place < 0) == above), key=lambda item: item[1].place)
    return [(name, section.title, section.html(name, data)) for name, section in own if (data := section.data(context))]
