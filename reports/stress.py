# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of a run in files, stress.csv of blocks, joint_stress.csv of joints and element_stress.csv of elements of meshed blocks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.stress.elements import element_columns, element_peaks
from masonry_cd.analysis.stress.peaks import StressPeaks
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.io.layout import EDGE_STRESS
from masonry_cd.io.results import Results

BLOCKS, JOINTS, ELEMENTS = "stress.csv", "joint_stress.csv", "element_stress.csv"
BLOCK_COLUMNS = (
    "block", "group", "max_compression", "max_compression_time", "max_tension", "max_tension_time", "xx", "yy", "zz", "xy", "yz", "xz",
    "strength", "ratio",
)  # fmt: skip
JOINT_COLUMNS = (
    "joint", "block_a", "block_b", "area", "max_edge_stress", "max_edge_stress_time", "max_finite_edge_stress", "end_edge_stress",
    "max_normal_force", "max_normal_force_time", "strength", "ratio", "crushed_share",
)  # fmt: skip


def block_columns(results: Results, peaks: StressPeaks) -> dict[str, Any]:
    """The columns of stress.csv, (B,) each; xx to xz are those of the last frame."""
    end = np.asarray(results.stress[results.frames - 1], dtype=float)
    values = (
        [block.name for block in results.blocks], [block.group for block in results.blocks], peaks.compression, peaks.compression_time,
        peaks.tension, peaks.tension_time, *end.T, peaks.block_strength, peaks.block_ratio,
    )  # fmt: skip
    return dict(zip(BLOCK_COLUMNS, values, strict=True))


def joint_columns(results: Results, peaks: StressPeaks) -> dict[str, Any]:
    """The columns of joint_stress.csv, (J,) each."""
    joints, names = results.joints, [block.name for block in results.blocks]
    values = (
        np.arange(joints.count), [names[a] for a in joints.block_a], [names[b] for b in joints.block_b], joints.area, peaks.edge,
        peaks.edge_time, peaks.finite_edge, results.joints_at(EDGE_STRESS, -1), peaks.force, peaks.force_time, peaks.joint_strength,
        peaks.joint_ratio, peaks.crushed_share,
    )  # fmt: skip
    return dict(zip(JOINT_COLUMNS, values, strict=True))


def write_stress(results: Results, peaks: StressPeaks, folder: Path) -> list[Path]:
    """Write the tables, supports left out; return the files."""
    paths = [folder / BLOCKS, folder / JOINTS]
    free = [not block.fixed for block in results.blocks]
    for path, columns, kept in ((paths[0], block_columns(results, peaks), free), (paths[1], joint_columns(results, peaks), None)):
        rows = zip(*columns.values(), strict=True)
        write_csv(path, columns, (row for k, row in enumerate(rows) if kept is None or kept[k]), digits=10)
    of_elements = element_peaks(results)
    if of_elements is None:
        return paths
    columns = element_columns(results, of_elements)
    write_csv(folder / ELEMENTS, columns, zip(*columns.values(), strict=True), digits=7)  # as they are kept
    return [*paths, folder / ELEMENTS]
