"""The check by a code of the mechanism that a limit analysis found: ``[limit.check]``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.errors import InputError
from masonry_cd.limit.analysis import Analysis, Options
from masonry_cd.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.limit.oscillator import oscillator
from masonry_cd.model.blocks import Assembly
from masonry_cd.model.joints import Joints

if TYPE_CHECKING:
    from loads.code_check.steps import CodeCheck
    from loads.code_check.table import CheckTable
    from loads.statics import StaticLoads

LEVEL = 1e-9


def suits(loads: StaticLoads, gravity: Sequence[float]) -> None:
    """Refuse a check of loads whose factor is not that of a horizontal push.

    Raises:
        InputError: names the key.
    """
    if loads.kind not in ("push", "tilt"):
        raise InputError(f"limit.check: needs a push or a tilt, not {loads.words}")
    if loads.kind == "tilt" and not loads.only_gravity:
        raise InputError("limit.check: needs a push where point loads or ties act: they do not turn with a tilt")
    across = abs(float(np.sum(np.asarray(loads.direction) * np.asarray(gravity))))
    if across > LEVEL * math.hypot(*gravity):
        raise InputError("limit.check: the push must be level, at right angles to gravity")


def check_mechanism(
    table: CheckTable,
    analysis: Analysis,
    structure: tuple[Assembly, Joints],
    loads: StaticLoads,
    gravity: Sequence[float],
    folder: Path,
    options: Options,
    known: CapacityCurve | None,
) -> CodeCheck:
    """Check the mechanism of the least factor, or of the associated one, of a structure that stands and bears some of the push.

    Where the check is by displacements as well, the mechanism is followed until its factor vanishes, as ``options`` say, unless a curve is
    ``known`` that does.

    Raises:
        InputError: a record that cannot be read.
    """
    from loads.code_check.check import code_check

    push = math.hypot(*gravity) * np.asarray(loads.direction)
    moves = analysis.governing.mechanism
    curve = known if known is not None and known.falls and moves.moving[known.control.block] else None
    if table.by_displacements and curve is None:
        curve = capacity_curve(*structure, loads.at(), CurveOptions(options, control=int(np.argmax(moves.velocity[:, :3] @ push))))
    return code_check(table, oscillator(analysis, *structure, push, curve), folder)
