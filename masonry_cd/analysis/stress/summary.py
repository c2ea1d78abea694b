# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of a run for its summary: the numbers of the table ``stress`` of summary.json, and the lines that report them."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_cd.analysis.stress.elements import element_peaks, element_summary
from masonry_cd.analysis.stress.peaks import StressPeaks
from masonry_cd.foundation.quantities import length, pressure
from masonry_cd.io.results import Results
from masonry_cd.io.summary_tables import ElementStressSummary, Strength, StressPeak, StressSummary

NAMED = 5  # blocks and joints that the summary names at most


def stress_summary(results: Results, peaks: StressPeaks) -> StressSummary | None:
    """The share of stress in summary.json; None for a run without a step."""
    if not np.isfinite(peaks.compression).any():
        return None
    names = [block.name for block in results.blocks]
    block, pulled = int(np.nanargmax(peaks.compression)), int(np.nanargmax(peaks.tension))
    more: dict[str, Any] = {}
    if np.isfinite(peaks.finite_edge).any():
        joint = int(np.nanargmax(peaks.finite_edge))
        pair = tuple(results.blocks[int(side[joint])].name for side in (results.joints.block_a, results.joints.block_b))
        more = {"edge_max": float(peaks.finite_edge[joint]), "edge_max_joint": joint, "edge_max_blocks": pair}
    if peaks.compared:
        more["strength"] = _against_strength(results, peaks)
    if elements := element_summary(results, element_peaks(results)):
        more["elements"] = elements
    return StressSummary(
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
    """Return the stresses above their strengths, the governing one first."""
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


def stress_lines(found: StressSummary) -> list[str]:
    """Lines that report the stress of a run, made from the table ``stress`` of its summary."""
    lines = [
        f"stress, means over the {length(found.interval, 's')} between frames: largest compression of a block "
        f"{pressure(found.compression_max)} in {found.compression_max_block} at {found.compression_max_time:.3g} s{_pulled(found)}"
    ]
    parts = []
    if found.edge_max is not None and not found.joints_at_edge:
        parts.append(f"largest compression at the edge of a joint {pressure(found.edge_max)}, {' - '.join(found.edge_max_blocks)}")
    if found.joints_at_edge:
        many, open_ones = found.joints_at_edge, found.joints_at_edge_open
        parts.append(
            f"in {many} joint{'s' if many > 1 else ''} the force came to an edge, where rigid joints leave no finite stress; "
            f"{open_ones or 'none'} of them {'was' if open_ones == 1 else 'were'} open then"
        )
    if parts:
        lines.append("; ".join(parts))
    lines += [] if found.elements is None else [_element_line(found.elements)]
    return lines + ([] if found.strength is None else [_strength_line(found.strength)])


def _pulled(found: StressPeak) -> str:
    """The largest tension, where there is one."""
    return f", largest tension {pressure(found.tension_max)} in {found.tension_max_block}" if found.tension_max > 0.0 else ""


def _element_line(found: ElementStressSummary) -> str:
    """A line that reports the largest stresses of the elements of meshed blocks, and how many lie above their strength."""
    above = ""
    if found.compared is not None:
        where = f", in {', '.join(found.blocks_above_names)}{' and others' if found.blocks_above > NAMED else ''}"
        above = f"; {found.above or 'none'} of {found.compared} come above their strength{where if found.above else ''}"
    return (
        f"elements of meshed blocks: largest compression {pressure(found.compression_max)} in {found.compression_max_block} at "
        f"{found.compression_max_time:.4g} s{_pulled(found)}{above}"
    )


def _strength_line(found: Strength) -> str:
    """A line that reports how many blocks and joints come above their compressive strength."""
    blocks = f"{found.blocks_above or 'none'} of {found.blocks_compared} blocks"
    joints = f"{found.joints_above or 'none'} of {found.joints_compared} joints"
    joints += f" ({found.joints_above_open or 'none'} of them while open)" if found.joints_above else ""
    share = found.crushed_share_max
    took = "" if share is None else f"; spread at that strength, the largest force takes {share_in_words(share)} of its joint"
    return f"strength: {blocks} by their mean and {joints} by their edge come above it{took}"


def share_in_words(share: float) -> str:
    """A share as a percentage."""
    return f"{100 * share:.2g} %"
