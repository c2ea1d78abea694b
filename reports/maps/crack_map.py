r"""The crack map: the structure as it stands at a frame, its joints coloured by what is left open and what has slid.

An open joint is a solid band coloured by its opening, a slid one is dashed and coloured by its sliding, in another hue; where
both happened the dashes lie on the band, and the dashes of a joint that was crushed are magenta. So a colour-blind reader can
distinguish them, and so can one of a grey print. The classes of both scales run 1-2-5 from the threshold of damage to ``largest``:
equal thresholds give equal colours, and the maps of two runs can be laid side by side. Faces of standing blocks that have parted
are dark. Where nothing would be seen at true scale,
displacements relative to the base are drawn amplified by a factor that the sheet states; the shape at rest lies behind as a pale
shadow. A cut takes away what lies before a plane (:mod:`reports.maps.cut`); the forces are drawn on request (:mod:`reports.maps.thrust`).

The maps of one :class:`Framing` share view, amplification, window and colours: what changes between them is damage.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.joint_damage import displacement_max, in_words, joint_damage
from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.deformed import frame_index, solids_of
from masonry_cd.io.layout import CRUSHED
from masonry_cd.io.results import Results
from reports.drawing.figure import Sheet, in_metres
from reports.drawing.render import SAMPLES, Canvas, Surface
from reports.drawing.structure_picture import within_sight
from reports.drawing.tie_lines import DrawnTies, ties_at
from reports.maps.crack_key import Key, Marks, draw_scales, draw_signs
from reports.maps.cut import clipped, clipped_ties
from reports.maps.framing import Framing, MapStyle, framing
from reports.maps.layers import Subject, block_layers_of, joint_layers, shadow
from reports.maps.thrust import WIDEST, ribbons


def crack_map(results: Results, path: Path, *, frame: int = -1, style: MapStyle | None = None) -> None:
    """Draw the crack map of a frame into a PNG.

    Args:
        results: of a run.
        path: of the PNG.
        frame: which; negative ones count from the end.
        style: view, amplification, thresholds and so on.

    Raises:
        InputError: no such frame, view or plane, no off-screen OpenGL, or a path that cannot be written.
    """
    style = style or MapStyle()
    frame = frame_index(results, frame)
    sheet_of(results, frame, framing(results, [frame], style)).save(path)


def sheet_of(results: Results, frame: int, framed: Framing, samples: int = SAMPLES) -> Sheet:
    """The sheet of a frame; ``samples`` as in :func:`reports.drawing.render.render`."""
    with Canvas(framed.view, framed.plan.pixels, samples) as canvas:
        sheet, key = sheet_and_key(results, frame, framed, canvas)
    draw_scales(sheet, key)
    return sheet


def sheet_and_key(results: Results, frame: int, framed: Framing, canvas: Canvas) -> tuple[Sheet, Key]:
    """The sheet of a frame without the scales of its key, which a sequence draws once, and what the key says."""
    subject = subject_of(results, frame, framed)
    layers = [shadow(subject), *block_layers_of(subject), *joint_layers(subject, framed.scales)]
    force = None
    if framed.style.thrust:
        thrust, force = thrust_layer(results, frame, subject)
        layers.append(thrust)
    ties = ties_of(results, subject)
    layers += ties.layers(framed.view, float((subject.drawn @ framed.view.towards).max()) + 0.02 * framed.window.height)
    sheet = Sheet(framed.plan)
    sheet.model(ties.labelled(canvas.draw(layers, framed.window), framed.view, framed.window))
    return sheet, draw_around(sheet, subject, results.title, force, len(ties.ends))


def draw_around(sheet: Sheet, subject: Subject, title: str, force: float | None, ties: int = 0) -> Key:
    """Draw the head and the signs of a sheet; return what its key says. ``force`` is that of the widest ribbon [N]."""
    framed = subject.framed
    sheet.head(title or "Crack map", _facts(subject))
    key = Key(
        marks=subject.marks,
        scales=framed.scales,
        when="Present" if not (subject.last and framed.alone) else "Provisional" if subject.provisional else "Residual",
        down=int(subject.down.sum()),
        outside=_outside(subject),
        moved=framed.factor * subject.largest > 2 * framed.pixel,
        alone=framed.alone,
        force=force,
        pixel=framed.pixel,
        view=framed.view,
        ties=ties,
    )
    draw_signs(sheet, key)
    return key


def ties_of(results: Results, subject: Subject) -> DrawnTies:
    """The ties of a frame, as far as the cut leaves them."""
    ties, cut = ties_at(results, subject.solids, subject.pose, subject.framed.factor), subject.framed.cut
    return ties if cut is None else clipped_ties(ties, cut)


def subject_of(results: Results, frame: int, framed: Framing) -> Subject:
    """Collect what a frame shows."""
    solids, thresholds = solids_of(results.blocks), framed.style.thresholds
    snapshot, last = DamageSnapshot.at(results, frame, thresholds), frame == results.frames - 1
    return Subject(
        framed=framed,
        joints=results.joints,
        solids=solids,
        snapshot=snapshot,
        last=last,
        marks=Marks.of(snapshot, results.joints_at(CRUSHED, frame) if results.has_joint_history(CRUSHED) else None),
        drawn=within_sight(solids, snapshot.pose.moved(solids, solids.vertices, solids.vertex_block, framed.factor)),
        provisional=end_state(results, thresholds).provisional if last else "",
        suffered=_suffered(results, thresholds) if last and framed.alone else "",
    )


def _suffered(results: Results, thresholds: Thresholds) -> str:
    """The largest displacement and the damage of joints, if there are any, over all time steps, in words."""
    joints = f", {in_words(joint_damage(results, thresholds))}" if results.joints.count else ""
    return f"largest displacement {in_metres(displacement_max(results))}{joints}"


def thrust_layer(results: Results, frame: int, subject: Subject) -> tuple[Surface, float]:
    """The line of thrust, before everything else, and the force of the widest ribbon [N]."""
    framed, towards = subject.framed, subject.framed.view.towards
    surface, largest = ribbons(results, subject.solids, subject.pose, subject.snapshot, frame, framed.factor, framed.view, framed.pixel)
    if framed.cut is not None:
        towards_viewer = -float(framed.cut.normal @ np.ones(3))  # of a plane across an axis
        nearer = replace(framed.cut, value=framed.cut.value + towards_viewer * WIDEST * framed.pixel)
        surface = clipped(surface, nearer)  # what runs in the plane itself, as in the middle of an arch, stays whole
    if not len(surface.points):
        return surface, largest
    before = float((subject.drawn @ towards).max() - (surface.points @ towards).min()) + 0.01 * framed.window.height
    return Surface(surface.points + before * towards, surface.loops, surface.loop_start, surface.colours, lit=False), largest


def _facts(subject: Subject) -> str:
    """Time, view, amplification, how far blocks are displaced at this time, and what they suffered, in two lines."""
    framed = subject.framed
    shape = "true shape" if framed.factor == 1 else f"displacements × {framed.factor:g}"
    cut = f", cut at {framed.cut.text}" if framed.cut else ""
    return (
        f"t = {subject.pose.time:.4g} s{' (last frame)' if subject.last else ''} · {framed.view.name} view{cut} · {shape}, relative to the "
        f"base, at this time at most {in_metres(subject.largest)}"
        + (f"\nover all time steps: {subject.suffered}" if subject.suffered else "")
        + (f" · {subject.provisional}" if subject.provisional else "")
    )


def _outside(subject: Subject) -> int:
    """Number of free blocks of which nothing is in the picture."""
    solids, window = subject.solids, subject.framed.window
    x, y = subject.framed.view.plane(subject.drawn).T
    inside = (x > window.left) & (x < window.right) & (y > window.bottom) & (y < window.top)
    seen = np.bincount(solids.vertex_block, inside, minlength=len(solids.centre)) > 0
    return int((~seen & ~solids.fixed).sum())
