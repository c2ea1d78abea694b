# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of a run in numbers: its share of summary.json."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_cd.analysis.stress.elements import element_peaks, element_summary
from masonry_cd.analysis.stress.peaks import StressPeaks
from masonry_cd.io.results import Results
from masonry_cd.io.summary_tables import RunStress, Strength

NAMED = 5  # blocks and joints that the summary names at most


def stress_summary(results: Results, peaks: StressPeaks) -> RunStress | None:
    """The share of stress in summary.json; None for a run without a step."""
    if not np.isfinite(peaks.compression).any():
        return None
    names = [block.name for block in results.blocks]
    block, pulled = int(np.nanargmax(peaks.compression)), int(np.nanargmax(peaks.tension))
    more: dict[str, Any] = {}
    if np.isfinite(peaks.finite_edge).any():
        joint = int(np.nanargmax(peaks.finite_edge))
        more = {"edge_max": float(peaks.finite_edge[joint]), "edge_max_joint": joint, "edge_max_blocks": _pair(results, joint)}
    if peaks.compared:
        more["strength"] = _against_strength(results, peaks)
    if elements := element_summary(results, element_peaks(results)):
        more["elements"] = elements
    return RunStress(
        interval=peaks.interval,
        compression_max=float(peaks.compression[block]),
        compression_max_block=names[block],
        compression_max_time=float(peaks.compression_time[block]),
        tension_max=float(peaks.tension[pulled]) if peaks.pulled[pulled] else 0.0,
        tension_max_block=names[pulled],
        tension_max_time=float(peaks.tension_time[pulled]),
        joints_at_edge=int(np.isinf(peaks.edge).sum()),
        joints_at_edge_open=int(peaks.open_at_edge.sum()),
        **more,
    )


def _against_strength(results: Results, peaks: StressPeaks) -> Strength:
    """What lies above its strength, the gravest first."""
    names = [block.name for block in results.blocks]
    above, cut = np.flatnonzero(peaks.block_ratio > 1.0), np.flatnonzero(peaks.joint_ratio > 1.0)
    above, cut = above[np.argsort(-peaks.block_ratio[above], kind="stable")], cut[np.argsort(-peaks.crushed_share[cut], kind="stable")]
    return Strength(
        least=float(np.nanmin(peaks.block_strength)),
        blocks_compared=int((np.isfinite(peaks.block_ratio)).sum()),
        joints_compared=int(np.isfinite(peaks.joint_strength).sum()),
        ratio_max=float(np.nanmax(peaks.block_ratio)) if np.isfinite(peaks.block_ratio).any() else None,
        blocks_above=len(above),
        blocks_above_names=tuple(names[b] for b in above[:NAMED]),
        joints_above=len(cut),
        joints_above_open=int(peaks.open_above.sum()),
        joints_above_numbers=tuple(cut[:NAMED].tolist()),
        crushed_share_max=float(np.nanmax(peaks.crushed_share)) if np.isfinite(peaks.crushed_share).any() else None,
    )


def _pair(results: Results, joint: int) -> tuple[str, str]:
    """The names of the blocks of a joint."""
    joints = results.joints
    return results.blocks[int(joints.block_a[joint])].name, results.blocks[int(joints.block_b[joint])].name
