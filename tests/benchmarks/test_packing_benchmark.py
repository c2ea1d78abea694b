# SPDX-License-Identifier: GPL-3.0-or-later
"""Pouring as a benchmark: spheres settle, and the slope of a cone is found."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.packing import arguments, energy_over_weight, inside, pour, row, slope


def test_poured_spheres_settle_as_accurately_as_asked() -> None:
    """Their energy has gone when the run ends, all are in the box, and steps were solved, or left at what is accepted."""
    asked = arguments().parse_args(["120", "--width", "0.5", "--friction", "0.3", "--longest", "3"])
    done = pour(asked, 0.3)
    assert done.settled
    assert energy_over_weight(done.machine, done.rim) < asked.still
    assert len(inside(done.machine, done.rim)) == 120
    assert np.mean(done.errors <= 1e-4) > 0.95
    assert done.errors.max() <= 1e-3
    assert len(done.errors) == len(done.iterations) == done.machine.steps


def test_a_run_ends_unsettled_after_its_longest_time() -> None:
    cells = row(arguments().parse_args(["80", "--heap", "--longest", "0.06"]), 0.5).split(" | ")
    assert cells[4] == "0.06 (still moves)"
    assert float(cells[5]) > 1e-3


@pytest.mark.parametrize("degrees", [0.0, 20.0, 35.0])
def test_the_slope_of_a_cone(degrees: float) -> None:
    """Small spheres in rows on a cone: the angle of the line through their tops."""
    x, y = (axis.ravel() for axis in np.meshgrid(*2 * [np.linspace(-1.0, 1.0, 101)]))
    p = np.stack([x, y, 1.0 - np.tan(np.radians(degrees)) * np.hypot(x, y)], axis=1)
    assert slope(p, np.full(len(p), 0.02), 1.0) == pytest.approx(degrees, abs=1.0)
