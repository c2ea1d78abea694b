# SPDX-License-Identifier: GPL-3.0-or-later
"""The check by a code of the mechanisms that a limit analysis found: ``[limit.check]``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.code_check.level import foundation_of, level_of, lowest_point
from masonry_cd.analysis.limit.analysis import Analysis
from masonry_cd.analysis.limit.candidates import Candidate, Untied, candidates
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.analysis.limit.oscillator import ANOTHER, Oscillator, oscillator
from masonry_cd.app.limit_search import Ways, doubt, search_numbers, search_words
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import at_start_only
from masonry_cd.mechanics.model.joints import Joints

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.steps import CodeCheck
    from masonry_cd.analysis.code_check.table import CheckTable
    from masonry_cd.analysis.code_check.verdicts import Looked
    from masonry_cd.app.static_loads import StaticLoads

LEVEL = 1e-9
TIES_ASK = (
    "ties make a mechanism start later and stiffer: by displacements, and under the spectrum of a floor, its shorter period may be asked "
    "for more than without them"
)


def suits(loads: StaticLoads, gravity: Sequence[float]) -> None:
    """Refuse a check of loads whose factor is not that of a horizontal push.

    Raises:
        InputError: names the key.
    """
    if loads.kind not in ("push", "tilt"):
        raise InputError("limit.check", f"needs a push or a tilt, not {loads.words}")
    if loads.kind == "tilt" and not loads.only_gravity:
        raise InputError("limit.check", "needs a push where point loads or ties act: they do not turn with a tilt")
    across = abs(float(np.sum(np.asarray(loads.direction) * np.asarray(gravity))))
    if across > LEVEL * math.hypot(*gravity):
        raise InputError("limit.check", "the push must be level, at right angles to gravity")
    heights_along_z("limit.check", gravity)


def heights_along_z(where: str, gravity: Sequence[float]) -> None:
    """Refuse gravity along which heights do not count.

    Raises:
        InputError: names the key.
    """
    if not any(gravity):
        raise InputError(where, "needs gravity, but run.gravity is zero")
    if gravity[2] > 0.0 or math.hypot(*gravity[:2]) > LEVEL * math.hypot(*gravity):
        raise InputError(where, "needs run.gravity along -z, along which heights count")


def check_mechanism(
    table: CheckTable,
    analysis: Analysis,
    untied: Untied,
    structure: tuple[Assembly, Joints],
    loads: StaticLoads,
    gravity: Sequence[float],
    folder: Path,
    how: Ways,
    known: CapacityCurve | None,
) -> CodeCheck:
    """Check the mechanism of the least ratio by accelerations of a structure that stands and bears some of the push.

    It is that of the least a0* of all that were found, but where others are held higher and asked for more.
    ``untied`` are those found without the ties. Where the check is by displacements as well, a mechanism is followed until its factor
    vanishes, unless a curve is ``known`` that does.

    Raises:
        InputError: a record that cannot be read.
    """
    from masonry_cd.analysis.code_check.check import check_at
    from masonry_cd.analysis.code_check.ground import ground_of
    from masonry_cd.analysis.code_check.verdicts import Basis

    ground, foot = ground_of(table, folder), foundation_of(table, structure[0])
    push, live = math.hypot(*gravity) * np.asarray(loads.direction), loads.live
    found = candidates(analysis, untied, *structure)
    each = [oscillator(one, *structure, push, None, live) for one in found]
    levels = [level_of(table, _line(one, structure[0]), foot) for one in found]
    first = [check_at(table, level, one, ground, Basis()).verdicts for level, one in zip(levels, each, strict=True)]
    order = sorted(range(len(found)), key=lambda k: first[k][0].ratio if first[k] else each[k].acceleration())
    least, made = found[order[0]], each[order[0]]
    elsewhere = abs(analysis.associated.factor - least.factor) > ANOTHER * abs(least.factor)
    if table.by_displacements and elsewhere and not how.curve.starts and not made.doubt:
        made = replace(made, end="a curve follows the mechanism without dilation only where limit.starts asks for it")
    elif table.by_displacements and (reason := at_start_only(structure[0].laws)):
        made = replace(made, end=reason)
    elif table.by_displacements and not made.doubt:
        curve = known
        if curve is None or not curve.falls or not least.mechanism.moving[curve.control.block]:
            control = int(np.argmax(least.mechanism.velocity[:, :3] @ push))
            curve = capacity_curve(*structure, loads.at(), CurveOptions(how.curve, control=control))
        made = oscillator(least, *structure, push, curve, live)
    looked = tuple(_looked(found[k], each[k], table.confidence_factor, levels[k].height) for k in order)
    words = "; ".join([search_words(analysis), *([untied.remark] if untied.remark else [])])
    basis = Basis(words, doubt(analysis), looked, search_numbers(analysis))
    return _with_tie_note(check_at(table, levels[order[0]], made, ground, basis), loads)


def _line(found: Candidate, assembly: Assembly) -> float:
    """The z of the lowest point of a mechanism that moves [m]."""
    return lowest_point(assembly, np.flatnonzero(found.mechanism.moving & ~assembly.fixed))


def _with_tie_note(check: CodeCheck, loads: StaticLoads) -> CodeCheck:
    """A check that says where ties may ask for more."""
    by_displacements = any(one.check == "non-linear" for one in check.verdicts)
    if not len(loads.bars.strength) or not (by_displacements or (check.level is not None and check.level.counted)):
        return check
    return replace(check, notes=(*check.notes, TIES_ASK))


def _looked(found: Candidate, made: Oscillator, confidence: float, height: float) -> Looked:
    """A mechanism and its oscillator as a check tells of them."""
    from masonry_cd.analysis.code_check.verdicts import Looked

    moving = int(found.mechanism.moving.sum())
    return Looked(found.source, moving, found.factor, made.fraction, made.acceleration() / confidence, made.doubt, height)
