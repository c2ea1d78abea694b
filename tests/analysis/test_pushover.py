# SPDX-License-Identifier: GPL-3.0-or-later
"""What a push has measured: the numbers of elastic and plastic curves in closed form, and none that a rigid one has not."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_cd.analysis.pushover import PushCurve

FORCE, YIELDS, END = 1000.0, 1e-3, 1e-2  # [N], [m]


def pushed(yields: float) -> PushCurve:
    """A push at one speed, whose force grows in proportion up to a displacement and then stays."""
    u = np.linspace(0.0, END, 2001)[1:]
    force = FORCE * np.minimum(1.0, u / yields) if yields else np.full(len(u), FORCE)
    return PushCurve("wall", "push", (1.0, 0.0, 0.0), np.arange(1.0, 2001.0), u, force, np.zeros(2000), np.zeros(2000))


def test_an_elastic_and_plastic_push_has_its_stiffness_and_is_its_own_idealisation() -> None:
    found = pushed(YIELDS).numbers()
    assert found.peak_force == FORCE
    assert found.stiffness == pytest.approx(FORCE / YIELDS, rel=0.02)
    assert found.bilinear.yield_force == pytest.approx(FORCE, rel=0.01)
    assert found.bilinear.ductility == pytest.approx(END / YIELDS, rel=0.05)


def test_a_rigid_push_has_a_peak_and_neither_stiffness_nor_ductility() -> None:
    found = pushed(0.0).numbers()
    assert found.peak_force == FORCE
    assert found.stiffness is None
    assert found.bilinear is None


@pytest.mark.parametrize("left", [0.0, 3e-7, -3e-7])
def test_a_cycle_that_ends_at_zero_but_for_rounding_is_whole(left: float) -> None:
    """A friction joint of force F, pushed to u, -u and back: the loop has 4 F u, and an equivalent damping of 2 / pi."""
    u = np.concatenate([np.linspace(0.0, END, 501)[1:], np.linspace(END, -END, 1001)[1:], np.linspace(-END, left, 501)[1:]])
    force = FORCE * np.sign(np.diff(u, prepend=0.0))
    count = len(u)
    (cycle,) = PushCurve("b", "push", (1.0, 0.0, 0.0), np.arange(1.0, count + 1.0), u, force, np.zeros(count), np.zeros(count)).cycles()
    assert cycle.dissipated == pytest.approx(4.0 * FORCE * END, rel=1e-3)
    assert cycle.damping == pytest.approx(2.0 / np.pi, rel=1e-3)
