# SPDX-License-Identifier: GPL-3.0-or-later
"""The capacity curve of a limit analysis: what ``[limit.curve]`` and ``masonry-cd limit --curve`` add."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.analysis import Options
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import in_words, length
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.materials import joint_table

if TYPE_CHECKING:
    from masonry_cd.app.limit_dynamics import Bracket
    from masonry_cd.app.static_loads import CurveTable, StaticLoads

CURVE_OUTPUTS = ("capacity.csv", "capacity.json", "capacity.png")
COLUMNS = ("point", "displacement_m", "factor", "associated_factor", "moving_blocks", "hinges", "slides", "changed")


@dataclass(frozen=True, eq=False)
class FollowedCurve:
    """A capacity curve, and what the dynamics says of some of its points."""

    curve: CapacityCurve
    brackets: tuple[Bracket, ...]


def follow(
    table: CurveTable, assembly: Assembly, joints: Joints, loads: StaticLoads, options: Options, gravity: Sequence[float]
) -> FollowedCurve:
    """The capacity curve that a table asks for.

    Raises:
        InputError: an unknown control block, loads that the curve cannot follow, or as of :func:`capacity_curve`.
    """
    if table.control is not None and table.control not in assembly.names:
        raise InputError("limit.curve.control", f'there is no block "{table.control}"')
    bonded = bool(assembly.laws.apex.any())
    if loads.kind == "tilt" and (not loads.only_gravity or bonded):
        raise InputError("limit.curve", "beside point loads, ties or bond a tilt is no push, and only a push is followed; give limit.push")
    if table.dynamics and (bonded or len(loads.bars.strength) or loads.constant.any() or len(loads.masses.mass) or loads.direction is None):
        raise InputError("limit.curve.dynamics", "compares dry joints under gravity and a push; there are ties, bond or point loads")
    control = None if table.control is None else assembly.names.index(table.control)
    limit = np.inf if table.displacement is None else table.displacement
    curve = capacity_curve(assembly, joints, loads.at(), CurveOptions(options, table.steps, control, limit))
    if not table.dynamics:
        return FollowedCurve(curve, ())
    from masonry_cd.app.limit_dynamics import brackets

    assert loads.direction is not None
    rigid = joint_table({}, assembly.groups, assembly.friction)  # as the curve has them: elastic ones would first sink until they bear
    return FollowedCurve(curve, brackets(curve, rigid, np.array(loads.direction), np.array(gravity)))


def curve_lines(found: FollowedCurve, names: tuple[str, ...]) -> list[str]:
    """The curve in words."""
    curve = found.curve
    last, peak = float(curve.displacement[-1]), curve.peak
    line = f'capacity curve: {len(curve.factor)} points, control block "{names[curve.control.block]}"; '
    line += (
        f"factor {curve.factor[0]:.4g} at the start, {curve.shown_factor(-1):.3g} at {length(last)}: {curve.end}; {in_words(curve.seconds)}"
    )
    out = [line]
    if curve.factor[peak] > 1.0001 * curve.factor[0]:
        out.append(f"capacity curve: it rises to {curve.factor[peak]:.4g} at {length(float(curve.displacement[peak]))}")
    if curve.changes:
        out.append(f"capacity curve: other joints are at work from {_places(curve, curve.changes)} on")
    if curve.jumps:
        before = f"capacity curve: no factor is borne just before {_places(curve, curve.jumps)}"
        out.append(f"{before}: there the blocks go on by themselves until forces balance again")
    for bracket in found.brackets:
        out.append(_bracket_in_words(bracket))
    return [*out, *(f"capacity curve: {remark}" for remark in curve.remarks)]


def _places(curve: CapacityCurve, points: tuple[int, ...]) -> str:
    """Displacements at the first few of some points."""
    return ", ".join(length(float(curve.displacement[k])) for k in points[:6]) + (" ..." if len(points) > 6 else "")


def _bracket_in_words(bracket: Bracket) -> str:
    """What the dynamics says of a point."""
    low, high = ("at none of those tried" if math.isnan(each) else f"at {each:.4g}" for each in (bracket.low, bracket.high))
    missed = f"; {bracket.missed} steps missed their tolerance" if bracket.missed else ""
    place = length(bracket.displacement)
    return f"dynamics at {place}: falls back {low}, goes on {high}; the curve has {bracket.factor:.4g}{missed}"


def numbers(found: FollowedCurve, names: tuple[str, ...]) -> dict[str, Any]:
    """What capacity.json holds."""
    curve = found.curve
    return {
        "control": {
            "block": names[curve.control.block], "point": curve.control.point.tolist(), "direction": curve.control.direction.tolist(),
        },
        "displacement": curve.displacement.tolist(),
        "factor": curve.factor.tolist(),
        "associated": [stage.associated for stage in curve.stages],
        "peak": {"displacement": float(curve.displacement[curve.peak]), "factor": float(curve.factor[curve.peak])},
        "ultimate": curve.ultimate,
        "end": curve.end,
        "changes": list(curve.changes),
        "jumps": list(curve.jumps),
        "marks": [_mark(curve, k, names) for k in curve.marks],
        "dynamics": [
            {"displacement": b.displacement, "falls_back": b.low, "goes_on": b.high, "factor": b.factor, "steps_missed": b.missed}
            for b in found.brackets
        ],
        "remarks": list(curve.remarks),
        "seconds": curve.seconds,
    }  # fmt: skip


def _mark(curve: CapacityCurve, k: int, names: tuple[str, ...]) -> dict[str, Any]:
    """A marked point: what moves there, which joints are at work, and where the blocks are."""
    stage = curve.stages[k]
    work = [{"block_a": names[a], "block_b": names[b], "state": state} for a, b, state in sorted(stage.at_work())]
    return {
        "point": k,
        "displacement": float(curve.displacement[k]),
        "factor": float(curve.factor[k]),
        "moving_blocks": [names[b] for b in np.flatnonzero(stage.mechanism.moving)],
        "joints_at_work": work,
        "centres": stage.assembly.centre.tolist(),
    }


def curve_rows(curve: CapacityCurve) -> list[dict[str, Any]]:
    """The points of a curve, by the names of COLUMNS."""
    rows = []
    for k, stage in enumerate(curve.stages):
        moves = stage.mechanism
        both = moves.count("hinge and slide")
        cells = (k, float(curve.displacement[k]), float(curve.factor[k]), float(stage.associated), int(moves.moving.sum()))
        rows.append(dict(zip(COLUMNS, (*cells, moves.count("hinge") + both, moves.count("slide") + both, k in curve.changes), strict=True)))
    return rows


def write_curve(found: FollowedCurve, names: tuple[str, ...], folder: Path) -> list[Path]:
    """Write capacity.csv and capacity.json."""
    from masonry_cd.app.summary import write_json
    from masonry_cd.foundation.csv_files import write_csv

    table, file = (folder / name for name in CURVE_OUTPUTS[:2])
    rows = [[f"{cell:.9g}" if isinstance(cell, float) else cell for cell in row.values()] for row in curve_rows(found.curve)]
    write_csv(table, COLUMNS, rows)
    write_json(numbers(found, names), file)
    return [table, file]


def draw_curve(found: FollowedCurve, names: tuple[str, ...], folder: Path, about: tuple[str, str], view: str) -> Path:
    """Draw capacity.png; ``about`` are the title of the scene and its load in words.

    Raises:
        InputError: an unknown view, no off-screen OpenGL.
    """
    from reports.limit.curve_picture import curve_picture

    curve, path, (title, words) = found.curve, folder / CURVE_OUTPUTS[2], about
    facts = f'{words} · centre of block "{names[curve.control.block]}" · at the end: {curve.end}'
    points = np.array([(b.displacement, b.low, b.high) for b in found.brackets]).reshape(-1, 3)
    curve_picture(curve, points, path, f"{title}: capacity curve", facts, view)
    return path
