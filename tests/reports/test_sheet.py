# SPDX-License-Identifier: GPL-3.0-or-later
"""reports.drawing.figure: the head of a sheet."""

from __future__ import annotations

import numpy as np
import pytest

from reports.drawing.figure import MARGIN, TITLE, Sheet, layout

LINE = "over all time steps: largest displacement 0.896 m, 4 joints opened, 120 slid, 7 opened and slid, 15 separated"
LONG = f'{LINE} · provisional: the run ended at 12.34 s, the base still moving at 123 mm/s, still moving at 456 mm/s ("facade.12.34")'


def ink(facts: str) -> np.ndarray:
    """Whether a pixel of the head of a sheet with such facts is drawn on."""
    sheet = Sheet(layout(1.4))
    sheet.head("A church of which a long title tells", facts)
    return np.asarray((sheet.pixels()[:TITLE] < 200).any(axis=2))


@pytest.mark.parametrize("facts", [LINE, LONG, f"{LINE}\n{LONG}", f"{LONG}\n{LONG}"])
def test_facts_stay_between_the_margins_and_clear_of_the_title(facts: str) -> None:
    drawn = ink(facts)
    assert not drawn[:, :MARGIN].any() and not drawn[:, -MARGIN:].any()
    rows = drawn.any(axis=1)
    assert not rows[0] and not rows[-1]
    starts = np.flatnonzero(np.diff(rows.astype(int)) == 1)
    assert len(starts) >= 2  # the title, and lines below it with white between
