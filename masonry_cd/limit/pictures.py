# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of ``masonry-cd limit``: mechanism and thrust of the whole, its capacity curve, the governing mechanism of each part."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.limit.found import FREE
from masonry_cd.analysis.limit.mechanism import BED, Mechanism
from masonry_cd.analysis.limit.outcome import on_the_factor
from masonry_cd.limit.checked import least_of
from masonry_cd.limit.curve import draw_curve
from masonry_cd.limit.facts import of_the_whole
from masonry_cd.limit.whole import THE_WHOLE
from masonry_cd.mechanics.model.joints import Joints
from reports.drawing.figure import Sheet
from reports.limit.picture import LimitSubject, mechanism_scene, thrust_scene

if TYPE_CHECKING:
    from masonry_cd.limit.case import LimitCase
    from masonry_cd.limit.whole import WholeAnalysis

PARTS = "parts"  # folder of the pictures of parts


def draw_whole(whole: WholeAnalysis, title: str, folder: Path, view: str = "auto") -> list[Path]:
    """Draw the mechanism of the whole, the forces of a structure that stands, and its capacity curve where one was followed, into a folder.

    Raises:
        InputError: an unknown view, no off-screen OpenGL.
    """
    fills, words = whole.structure.made.fills, _words(whole)
    what = LimitSubject(whole.collapse.mechanism, whole.assembly.blocks, whole.joints, whole.ties, fills)
    Sheet.drawn(mechanism_scene(what, f"{title}: mechanism", words, view)).save(folder / "mechanism.png")
    if not whole.analysis.stands:
        return [folder / "mechanism.png"]
    Sheet.drawn(thrust_scene(what, whole.collapse, f"{title}: forces at collapse", words, view)).save(folder / "thrust.png")
    curve = [draw_curve(whole.curve, whole.assembly.names, folder, (title, whole.loads.words), view)] if whole.curve else []
    return [folder / "mechanism.png", folder / "thrust.png", *curve]


def draw_spectra(case: LimitCase, folder: Path) -> list[Path]:
    """Draw the spectra of the check that decides, with demand and capacity, into a folder; nothing without a check.

    Raises:
        InputError: matplotlib is not installed.
    """
    check, asked, ground = case.check, case.structure.asked.check, case.ground
    if check is None or asked is None or ground is None or case.decides is None:
        return []
    from masonry_cd.analysis.code_check.spectra import spectra
    from reports.limit.spectrum_picture import draw_spectra

    row, gravity = case.decides.row, case.decides.one.oscillator.gravity
    state = f", {check.limit_state}" if check.limit_state else ""
    words = f"{row['element']}, push {row['push']}: {row['mechanism']} · {check.edition}{state}"
    made = spectra(check, asked, ground, gravity)
    return [draw_spectra(made, folder / "spectrum.png", f"{case.scene.title}: code check", words)]


def draw_parts(case: LimitCase, folder: Path, view: str = "auto") -> dict[Path, str]:
    """Draw the governing mechanism of each part that was analysed by itself into a folder, each PNG with what it shows.

    Raises:
        InputError: an unknown view, no off-screen OpenGL.
    """
    drawn: dict[Path, str] = {}
    seen: set[str] = set()
    for each in least_of(case.mechanisms) if case.parts else []:
        name, one = each.part.element.name, each.one
        if name in seen or name == THE_WHOLE or one.mechanism is None:
            continue
        seen.add(name)
        path = folder / f"{len(seen):02d}_{re.sub('[^a-z0-9]+', '_', name.lower()).strip('_')}.png"
        words = f"push {each.row['push']} · {_named(one.name)} · α0 {one.oscillator.alpha:.4g}"
        subject = _subject(case, one.mechanism, each.part.element.blocks)
        Sheet.drawn(mechanism_scene(subject, f"{case.scene.title}: {name}", words, view)).save(path)
        drawn[path] = each.words
    return drawn


def _words(whole: WholeAnalysis) -> str:
    """The line below the title of a picture."""
    return f"{whole.loads.words} · {on_the_factor(of_the_whole(whole)).result}"


def _named(mechanism: str) -> str:
    """A mechanism without the counts of its joints, of which a picture shows some only and counts those."""
    return FREE if mechanism.startswith(FREE) else mechanism


def _under(case: LimitCase, moves: Mechanism) -> np.ndarray:
    """Blocks at rest under joints at work, whose hinges and slips would not be seen without them."""
    joints = case.structure.joints
    works, up = moves.state > 0, joints.normal[:, 2]
    lower = np.where(up > BED, joints.block_a, np.where(up < -BED, joints.block_b, -1))
    upper = joints.block_a + joints.block_b - lower
    some = np.flatnonzero(works & (lower >= 0))
    return np.unique(lower[some][moves.moving[upper[some]] & ~moves.moving[lower[some]]])


def _subject(case: LimitCase, moves: Mechanism, blocks: np.ndarray) -> LimitSubject:
    """The blocks of a part, those that move with it and those on which they stand, in their mechanism; what else is held would hide them.

    Without forces.
    """
    joints = case.structure.joints
    shown = np.union1d(np.union1d(blocks, np.flatnonzero(moves.moving)), _under(case, moves))
    number = np.full(case.structure.assembly.count, -1)
    number[shown] = np.arange(len(shown))
    between = np.flatnonzero((number[joints.block_a] >= 0) & (number[joints.block_b] >= 0))
    corners = [np.arange(joints.polygon_start[j], joints.polygon_start[j + 1]) for j in between]
    some = Joints(
        number[joints.block_a[between]], number[joints.block_b[between]], joints.area[between], joints.normal[between],
        np.cumsum([0, *map(len, corners)]), joints.polygon[np.concatenate([*corners, np.zeros(0, dtype=np.int64)])],
    )  # fmt: skip
    of_joints = ("opening", "least_opening", "sliding", "rotation", "hinge", "state", "closing")
    part = replace(
        moves, velocity=moves.velocity[shown], speed=moves.speed[shown], **{name: getattr(moves, name)[between] for name in of_joints}
    )
    return LimitSubject(part, [case.structure.assembly.blocks[b] for b in shown], some)
