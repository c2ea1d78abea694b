# SPDX-License-Identifier: GPL-3.0-or-later
r"""The largest horizontal force of the supports, as a share of the weight.

    V = | sum_i m_i a_i | / (g sum_i m_i),      a_i = (v_i(t_k+1) - v_i(t_k)) / (t_k+1 - t_k)

over the free blocks i, horizontal: by the momentum that the supports give them, the mean between two frames. Where a push, a tilt or a
point load acts on the blocks as well the momentum does not say what the supports bear; such runs have no such number.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from masonry_cd.analysis.outputs import COMPARE, LAST, PAGE, STUDY, SUMMARY, Number

if TYPE_CHECKING:
    from masonry_cd.analysis.outputs.measured import Measured

G = 9.80665  # [m/s2]
ON_BLOCKS = ("push", "tilt", "point")  # kinds of loads that act on the blocks themselves


def base_shear_max(run: Measured) -> float | None:
    """V; None of a run with loads on its blocks, without a free block, or with one frame."""
    import numpy as np

    results, free = run.results, ~run.solids.fixed
    kinds = {load.get("kind") for load in results.tables.get("loads", [])}
    if kinds & set(ON_BLOCKS) or not free.any() or results.frames < 2:
        return None
    mass = np.array([block.density * block.mass_properties.volume for block in results.blocks])[free]
    momentum = np.empty((results.frames, 2))
    for some in results.in_chunks(6 * len(free)):
        momentum[some] = np.einsum("fbi,b->fi", np.asarray(results.velocity[some], dtype=float)[:, free, :2], mass)
    force = np.diff(momentum, axis=0) / np.diff(np.asarray(results.time, dtype=float))[:, None]
    return float(np.hypot(*force.T).max() / (G * mass.sum()))


NUMBERS = {
    "base_shear_max": Number(
        "largest base shear over weight",
        "horizontal force of the supports over the weight, averaged between two frames; empty where a load acts on the blocks directly",
        base_shear_max,
        {SUMMARY: LAST, STUDY: LAST, COMPARE: LAST, PAGE: LAST},
    ),
}
