# SPDX-License-Identifier: GPL-3.0-or-later
"""A line on what rigid joints leave out of a run, from its summary with the findings of :mod:`masonry_cd.analysis.modal.elastic_period`."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.quantities import pressure
from masonry_cd.io.summary import Summary


def left_out_lines(summary: Summary) -> list[str]:
    """Return a line on what rigid joints leave out of a run; none where its summary says nothing of it."""
    basis, period, factor = summary.elastic_basis, summary.elastic_period, summary.amplification
    if basis is None:
        return []
    whose = f"masonry of E = {pressure(basis.young)}" + ("" if basis.named else " (assumed: the scene names none)")
    key = 'material.masonry.stiffness = "mean"' if basis.named else 'material.masonry = "..."'
    way = _in_words(np.array(basis.direction))
    return [
        f"left out by rigid joints: {whose} sways with a first elastic period of about {period:.2g} s along {way}, at which "
        f"the motion of the base is amplified {factor:.2g} times (S_a at 5 % over PGA); {key} includes it"
    ]


def _in_words(direction: np.ndarray) -> str:
    """An axis by its name, another direction by its components."""
    axis = int(np.abs(direction).argmax())
    return "xyz"[axis] if abs(direction[axis]) > 0.999 else "(" + ", ".join(f"{value + 0.0:.2g}" for value in direction.round(3)) + ")"
