# SPDX-License-Identifier: GPL-3.0-or-later
"""The law of one contact where numbers are out of all proportion."""

from __future__ import annotations

import math

import pytest

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.friction.coulomb_law import local_impulse

ROW = (0.1, 0.0, 0.0, 50.0, 0.0, 50.0)
MU = 0.4


@entry()
def answer(
    q: tuple[float, float, float], row: tuple[float, float, float, float, float, float], mu: float, s: float
) -> tuple[float, float, float, float]:
    """The impulse of a contact, and the slip parameter that its search ended with."""
    return local_impulse(q, row, mu, s)


@pytest.mark.parametrize("closing", [1e-8, 1e-60, 1e-150, 1e-300])
@pytest.mark.parametrize("slip", [0.2, 1e-10])
@pytest.mark.parametrize("begin", [0.0, 1e30, 1e150, 1e200])
def test_a_contact_that_hardly_closes_gets_an_impulse_in_its_cone_wherever_its_search_begins(
    closing: float, slip: float, begin: float
) -> None:
    """Packed grains have contacts whose closing speed is nothing compared with their slip in one sweep, and is not in the next."""
    normal, first, second, end = answer((-closing, slip, 2.0 * slip), ROW, MU, begin)
    assert normal == pytest.approx(0.1 * closing, rel=1e-6)
    assert math.hypot(first, second) <= MU * normal * (1.0 + 1e-12)
    assert math.isfinite(end)
