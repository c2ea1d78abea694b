"""blocks.csv and joints.csv of a limit analysis."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from masonry_cd.csv_files import write_csv
from masonry_cd.limit.analysis import Collapse
from masonry_cd.limit.mechanism import STATES
from masonry_cd.model.blocks import Assembly
from masonry_cd.model.joints import Joints

BLOCKS = ("block", "group", "moves", "speed", "vx", "vy", "vz", "wx_per_m", "wy_per_m", "wz_per_m")
JOINTS = (
    "joint", "block_a", "block_b", "area_m2", "state", "opening", "least_opening", "sliding", "rotation_per_m",
    "hinge_x_m", "hinge_y_m", "hinge_z_m", "normal_force_n", "shear_force_n", "force_x_m", "force_y_m", "force_z_m",
)  # fmt: skip


def write_tables(collapse: Collapse, assembly: Assembly, joints: Joints, folder: Path) -> list[Path]:
    """Write both tables; velocities are over the largest one of any corner."""
    moves = collapse.mechanism
    blocks, table = folder / "blocks.csv", folder / "joints.csv"
    rows = []
    for b, name in enumerate(assembly.names):
        numbers = [moves.speed[b], *moves.velocity[b]]
        rows.append([name, assembly.groups[assembly.group_of[b]], bool(moves.moving[b]), *map(_short, numbers)])
    write_csv(blocks, BLOCKS, rows)
    lines = []
    for j in range(joints.count):
        names = [assembly.names[joints.block_a[j]], assembly.names[joints.block_b[j]]]
        rates = [moves.opening[j], moves.least_opening[j], moves.sliding[j], moves.rotation[j], *moves.hinge[j]]
        forces = [collapse.normal_force[j], collapse.shear_force[j], *collapse.force_point[j]]
        lines.append([j, *names, _short(joints.area[j]), STATES[moves.state[j]], *map(_short, rates), *map(_short, forces)])
    write_csv(table, JOINTS, lines)
    return [blocks, table]


def _short(value: float) -> str:
    """Six digits; what is no number stays empty."""
    return f"{value:.6g}" if np.isfinite(value) else ""
