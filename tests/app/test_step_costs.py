# SPDX-License-Identifier: GPL-3.0-or-later
"""The classes of motion by which the cost of steps is foretold."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import maximum_filter1d

from masonry_cd.app.step_costs import largest_before


@pytest.mark.parametrize(("count", "width"), [(1, 1), (7, 1), (7, 3), (7, 7), (60, 13), (64, 16)])
def test_the_largest_of_a_window_that_ends_at_each_step(count: int, width: int) -> None:
    values = np.random.default_rng(count).random(count)
    expected = maximum_filter1d(values, width, origin=(width - 1) // 2, mode="constant")
    assert largest_before(values, width).tolist() == expected.tolist()
