# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of a limit analysis: mechanisms.csv, blocks.csv, joints.csv, ties.csv, and check.csv, the code check step by step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.limit.analysis import Collapse
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.analysis.limit.ties import COLUMNS as TIES
from masonry_cd.analysis.limit.ties import CSV as TIES_CSV
from masonry_cd.analysis.limit.ties import LimitTie
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

BLOCKS = ("block", "group", "moves", "speed", "vx", "vy", "vz", "wx_per_m", "wy_per_m", "wz_per_m")
JOINTS = (
    "joint", "block_a", "block_b", "area_m2", "state", "opening", "least_opening", "sliding", "rotation_per_m",
    "hinge_x_m", "hinge_y_m", "hinge_z_m", "normal_force_n", "shear_force_n", "force_x_m", "force_y_m", "force_z_m",
    "closing", "stress_block_share",
)  # fmt: skip

MECHANISMS = {  # column of mechanisms.csv by the name of the value in limit.json
    "element": "element", "kind": "kind", "push": "push", "mechanism": "mechanism", "found": "found", "height": "height_m",
    "moving_blocks": "moving_blocks", "alpha0": "alpha0", "fraction": "e_star", "acceleration": "a0_m_s2", "demand": "demand_m_s2",
    "ratio": "ratio", "state": "verdict", "doubt": "e_star_is_one", "undecided": "why", "check": "check", "last": "d0_m",
    "last_by": "d0_by", "displacement": "displacement_m", "displacement_demand": "displacement_demand_m",
    "displacement_ratio": "displacement_ratio", "no_displacement": "no_check_by_displacements",
}  # fmt: skip


def write_mechanisms(rows: Sequence[Mapping[str, Any]], folder: Path) -> list[Path]:
    """Write mechanisms.csv; nothing without mechanisms."""
    if not rows:
        return []
    write_csv(folder / "mechanisms.csv", tuple(MECHANISMS.values()), ([row[name] for name in MECHANISMS] for row in rows), digits=6)
    return [folder / "mechanisms.csv"]


def write_tables(collapse: Collapse, assembly: Assembly, joints: Joints, folder: Path) -> list[Path]:
    """Write both tables; velocities are over the largest one of any corner."""
    blocks, table = folder / "blocks.csv", folder / "joints.csv"
    moving = ([str(cell) if isinstance(cell, bool) else cell for cell in row] for row in block_rows(collapse, assembly))
    write_csv(blocks, BLOCKS, moving, digits=6)
    write_csv(table, JOINTS, joint_rows(collapse, assembly, joints), digits=6)
    return [blocks, table]


def block_rows(collapse: Collapse, assembly: Assembly) -> list[list[Any]]:
    """The cells of ``BLOCKS`` for every block."""
    moves = collapse.mechanism
    groups = [assembly.groups[group] for group in assembly.group_of]
    return [
        [name, groups[b], bool(moves.moving[b]), float(moves.speed[b]), *moves.velocity[b].tolist()]
        for b, name in enumerate(assembly.names)
    ]


def joint_rows(collapse: Collapse, assembly: Assembly, joints: Joints) -> list[list[Any]]:
    """The cells of ``JOINTS`` for every joint; what is not a number is nan."""
    moves, rows = collapse.mechanism, []
    for j in range(joints.count):
        names = [assembly.names[joints.block_a[j]], assembly.names[joints.block_b[j]]]
        rates = [moves.opening[j], moves.least_opening[j], moves.sliding[j], moves.rotation[j], *moves.hinge[j]]
        forces = [collapse.normal_force[j], collapse.shear_force[j], *collapse.force_point[j], moves.closing[j]]
        share = np.nan if collapse.block_share is None else collapse.block_share[j]
        rows.append([j, *names, float(joints.area[j]), STATES[moves.state[j]], *map(float, rates), *map(float, [*forces, share])])
    return rows


def write_limit_ties(ties: Sequence[LimitTie], folder: Path) -> list[Path]:
    """Write ties.csv; nothing without ties."""
    if not ties:
        return []
    rows = ((tie.row() | {"yields": str(tie.yields)}).values() for tie in ties)
    write_csv(folder / TIES_CSV, TIES, rows, digits=6)
    return [folder / TIES_CSV]


STEPS = ("symbol", "value", "unit", "clause", "meaning", "line")


def write_check(check: Mapping[str, Any], path: Path) -> None:
    """Write the ``steps`` of a check, below them its ``verdicts``."""
    rows = [[f"{step[key]:.6g}" if key == "value" else step[key] for key in STEPS] for step in check["steps"]]
    for one in check["verdicts"]:
        rows.append([f"{one['check']} check", one["state"], "", one["clause"], one["words"], ""])
    write_csv(path, STEPS, rows)
