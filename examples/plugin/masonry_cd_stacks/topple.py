# SPDX-License-Identifier: GPL-3.0-or-later
"""``mechanisms = ["toppling"]`` of ``[[limit.mechanism]]``: what lies above a bed turns over as one body, whichever bed that is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from masonry_cd.analysis.limit.part import Whole
from structures.macro_elements.element import MacroElement


def toppling(whole: Whole, element: MacroElement, direction: np.ndarray) -> Iterator[tuple[np.ndarray]]:
    """The body above each height at which a block of the part has its centre; the one of least factor is taken."""
    heights = whole.assembly.centre[element.blocks, 2]
    for height in np.unique(heights.round(6)):
        yield (element.blocks[heights >= height - 1e-6],)
