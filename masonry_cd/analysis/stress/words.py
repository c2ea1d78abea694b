# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of a run in words, from its share of the summary."""

from __future__ import annotations

from masonry_cd.analysis.stress.summary import NAMED
from masonry_cd.foundation.quantities import length, pressure
from masonry_cd.io.summary_tables import ElementStress, RunStress, Strength, StressPeak


def stress_lines(found: RunStress) -> list[str]:
    """The stress of a run in words, from its share of the summary."""
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


def _element_line(found: ElementStress) -> str:
    """The largest stresses of elements, in words."""
    above = ""
    if found.compared is not None:
        where = f", in {', '.join(found.blocks_above_names)}{' and others' if found.blocks_above > NAMED else ''}"
        above = f"; {found.above or 'none'} of {found.compared} come above their strength{where if found.above else ''}"
    return (
        f"elements of meshed blocks: largest compression {pressure(found.compression_max)} in {found.compression_max_block} at "
        f"{found.compression_max_time:.4g} s{_pulled(found)}{above}"
    )


def _strength_line(found: Strength) -> str:
    """What lies above its strength, in words."""
    blocks = f"{found.blocks_above or 'none'} of {found.blocks_compared} blocks"
    joints = f"{found.joints_above or 'none'} of {found.joints_compared} joints"
    joints += f" ({found.joints_above_open or 'none'} of them while open)" if found.joints_above else ""
    share = found.crushed_share_max
    took = "" if share is None else f"; spread at that strength, the largest force takes {share_in_words(share)} of its joint"
    return f"strength: {blocks} by their mean and {joints} by their edge come above it{took}"


def share_in_words(share: float) -> str:
    """A share as a percentage."""
    return f"{100 * share:.2g} %"
