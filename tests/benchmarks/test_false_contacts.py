# SPDX-License-Identifier: GPL-3.0-or-later
"""The count of gaps that change by more than their pair has moved."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.false_contacts import Count, Watch
from benchmarks.ours import stepper
from benchmarks.scenes import tower
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.model.state import rotation_matrices


@pytest.mark.parametrize(("lowered", "overlaps", "early"), [(0.0, 0, 0), (0.1, 1, 0), (-0.1, 0, 1)])
def test_a_gap_that_jumps_is_counted_once(monkeypatch: pytest.MonkeyPatch, lowered: float, overlaps: int, early: int) -> None:
    """Of the last pair of a tower at rest, in one detection: 100 mm deeper than before, or back from 100 mm above."""
    machine, detect, made, seen = stepper(tower(3, amplitude=0.0), 8), Detector.detect, Count(), []

    def shifted(self: Detector, *where: Any) -> Any:
        found = detect(self, *where)
        seen.append(len(found.gap))
        if len(seen) == 5:
            found.gap[found.pair == found.pair.max()] -= lowered
        return found

    monkeypatch.setattr(Detector, "detect", shifted)
    Watch(machine, made)
    state = machine.state
    for _ in range(8):
        machine.detector.detect(state.position, rotation_matrices(state.orientation), state.velocity, 1e-3, 1e-3, np.zeros(3))
    assert (made.overlaps, made.steps_with_overlaps, made.early, made.pairs) == (overlaps, overlaps, early, 8 * 3)
    assert made.deepest == pytest.approx(0.1 if overlaps else 0.0, abs=0.01)
