# SPDX-License-Identifier: GPL-3.0-or-later
"""The capacity curve of a limit analysis: what ``[limit.curve]`` and ``masonry-cd limit --curve`` add."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.analysis import LimitOptions
from masonry_cd.analysis.limit.capacity import CapacityCurve, CurveOptions, capacity_curve
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import in_words, length
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

if TYPE_CHECKING:
    from masonry_cd.app.limit_table import CurveTable
    from masonry_cd.app.static_loads import StaticLoads

CURVE_OUTPUTS = ("capacity.csv", "capacity.json", "capacity.png")
COLUMNS = ("point", "displacement_m", "factor", "associated_factor", "moving_blocks", "hinges", "slides", "changed")


def follow(table: CurveTable, assembly: Assembly, joints: Joints, loads: StaticLoads, options: LimitOptions) -> CapacityCurve:
    """The capacity curve that a table asks for.

    Raises:
        InputError: an unknown control block, loads that the curve cannot follow, or as of :func:`capacity_curve`.
    """
    if table.control is not None and table.control not in assembly.names:
        raise InputError("limit.curve.control", f'there is no block "{table.control}"')
    if loads.kind == "tilt" and (not loads.has_only_gravity or assembly.laws.apex.any()):
        raise InputError("limit.curve", "with point loads, ties or bond a tilt is not a push, and only a push is followed; give limit.push")
    control = None if table.control is None else assembly.names.index(table.control)
    limit = np.inf if table.displacement is None else table.displacement
    return capacity_curve(assembly, joints, loads.at(), CurveOptions(options, table.steps, control, limit))


def curve_lines(curve: CapacityCurve, names: tuple[str, ...]) -> list[str]:
    """The lines on the curve."""
    last, peak = float(curve.displacement[-1]), curve.peak
    line = f'capacity curve: {len(curve.factor)} points, control block "{names[curve.control.block]}"; '
    line += (
        f"factor {curve.factor[0]:.4g} at the start, {curve.shown_factor(-1):.3g} at {length(last)}: {curve.end}; {in_words(curve.seconds)}"
    )
    out = [line]
    if curve.factor[peak] > 1.0001 * curve.factor[0]:
        out.append(f"capacity curve: it rises to {curve.factor[peak]:.4g} at {length(float(curve.displacement[peak]))}")
    if curve.changes:
        out.append(f"capacity curve: other joints are active from {_places(curve, curve.changes)} on")
    if curve.jumps:
        before = f"capacity curve: no factor is borne just before {_places(curve, curve.jumps)}"
        out.append(f"{before}: there the blocks move on without load until the forces balance again")
    return [*out, *(f"capacity curve: {remark}" for remark in curve.remarks)]


def _places(curve: CapacityCurve, points: tuple[int, ...]) -> str:
    """Displacements at the first few of some points."""
    return ", ".join(length(float(curve.displacement[k])) for k in points[:6]) + (" ..." if len(points) > 6 else "")


def numbers(curve: CapacityCurve, names: tuple[str, ...]) -> dict[str, Any]:
    """The contents of capacity.json."""
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


def write_curve(curve: CapacityCurve, names: tuple[str, ...], folder: Path) -> list[Path]:
    """Write capacity.csv and capacity.json."""
    from masonry_cd.foundation.csv_files import write_csv
    from masonry_cd.foundation.json_files import write_json

    table, file = (folder / name for name in CURVE_OUTPUTS[:2])
    rows = [[f"{cell:.9g}" if isinstance(cell, float) else cell for cell in row.values()] for row in curve_rows(curve)]
    write_csv(table, COLUMNS, rows)
    write_json(file, numbers(curve, names))
    return [table, file]


def draw_curve(curve: CapacityCurve, names: tuple[str, ...], folder: Path, about: tuple[str, str], view: str) -> Path:
    """Draw capacity.png; ``about`` are the title of the scene and its load.

    Raises:
        InputError: an unknown view, no off-screen OpenGL.
    """
    from reports.limit.curve_picture import draw_curve

    path, (title, words) = folder / CURVE_OUTPUTS[2], about
    facts = f'{words} · centre of block "{names[curve.control.block]}" · at the end: {curve.end}'
    draw_curve(curve, path, f"{title}: capacity curve", facts, view)
    return path
