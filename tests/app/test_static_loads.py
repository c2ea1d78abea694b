# SPDX-License-Identifier: GPL-3.0-or-later
"""masonry_cd.app.static_loads: masses of point loads that a push moves, by hand in factor, e*, d0*, curve, check and macro-elements."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from limit_scenes import pillar, said, scene
from models import GRAVITY, box, ground

from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import LimitCase, Wanted, limit_case

WIDE, HIGH = 0.5, 1.5  # of the pillar, 0.4 m thick
WEIGHT, LOAD = 2000.0 * GRAVITY * WIDE * 0.4 * HIGH, 4000.0
TOP = f'[[loads]]\nkind = "point"\nblock = "a"\nforce = [0, 0, {-LOAD}]\npoint = [0.25, 0, {HIGH}]\n'
CHECK = '[limit.check]\nspectrum = "EC8"\nag = 2.0\n'
MIDDLE = (WEIGHT * 0.5 * HIGH + LOAD * HIGH) / (WEIGHT + LOAD)  # height of the centre of both


def steps(case: LimitCase) -> dict[str, float]:
    assert case.check is not None
    return {step.symbol: step.value for step in case.check.steps}


def test_a_mass_on_a_pillar_is_pushed_with_it_and_is_part_of_its_oscillator(tmp_path: Path) -> None:
    """One body: alpha0 = b/2 over the height of the common centre, e* = 1, and the common centre goes b/2 to where the factor vanishes."""
    case = limit_case(scene(tmp_path, pillar(), f"{TOP}[limit]\npush = 'x'\nmasses = [0]\n{CHECK}"))
    made = steps(case)
    assert made["alpha0"] == pytest.approx(0.5 * WIDE / MIDDLE, rel=1e-9)
    assert made["sum P"] == pytest.approx(WEIGHT + LOAD, rel=1e-9) and made["e*"] == pytest.approx(1.0, rel=1e-9)
    theta = math.atan(0.5 * WIDE / MIDDLE)  # both are over the toe
    control = 0.5 * WIDE * (1.0 - math.cos(theta)) + 0.5 * HIGH * math.sin(theta)
    assert made["d0*"] == pytest.approx(control * MIDDLE / (0.5 * HIGH), rel=1e-4)
    assert not any("without mass" in line for line in said(case))


def test_a_force_without_mass_is_said_beside_a_check(tmp_path: Path) -> None:
    """The push does not move it: it steadies the pillar, and e* is of the block alone."""
    case = limit_case(scene(tmp_path, pillar(), f"{TOP}[limit]\npush = 'x'\n{CHECK}displacements = false\n"))
    made = steps(case)
    assert made["alpha0"] == pytest.approx((WEIGHT + LOAD) * 0.5 * WIDE / (WEIGHT * 0.5 * HIGH), rel=1e-9)
    assert made["sum P"] == pytest.approx(WEIGHT, rel=1e-9)
    assert any("loads[0] (point) acts as a force without mass" in line and "limit.masses = [0]" in line for line in said(case))


def test_gravity_on_masses_is_tilted_with_that_of_the_blocks(tmp_path: Path) -> None:
    pushed, tilted = (
        limit_case(scene(tmp_path, pillar(), f"{TOP}[limit]\n{way} = 'x'\nmasses = [0]\n")).whole.analysis.associated.factor
        for way in ("push", "tilt")
    )
    assert tilted == pytest.approx(pushed, rel=1e-12)


def test_the_curves_of_masses_and_of_live_loads_are_those_of_the_moved_blocks(tmp_path: Path) -> None:
    """Balance of moments about the toe at every point: a mass goes with its block, as the point of attack of a live load does."""
    side = f'[[loads]]\nkind = "point"\nblock = "a"\nforce = [1000.0, 0, 0]\npoint = [0.25, 0, {HIGH}]\n'
    for tables in (f"{TOP}[limit]\npush = 'x'\nmasses = [0]\n", f"{TOP}{side}[limit]\nlive = [1]\n"):
        case = limit_case(scene(tmp_path, pillar(), tables), wanted=Wanted(curve=True))
        assert case.whole.curve is not None and case.whole.curve.falls
        for k in range(0, len(case.whole.curve.factor), 7):
            stage = case.whole.curve.stages[k]
            top = stage.assembly.blocks[1].vertices
            x, z = top[np.argsort(top[:, 2])[-2:]].mean(axis=0)[[0, 2]] if k == 0 else _top(top)
            centre = stage.assembly.centre[1]
            borne = WEIGHT * (WIDE - centre[0]) + LOAD * (WIDE - x)
            turns = 1000.0 * z if "live" in tables else WEIGHT * centre[2] + LOAD * z
            assert stage.factor == pytest.approx(borne / turns, abs=1e-6)


def _top(corners: np.ndarray) -> tuple[float, float]:
    """Where the middle of the top of the pillar is, x and z: its two pairs of corners farthest from the toe but for the heel."""
    away = np.hypot(corners[:, 0] - WIDE, corners[:, 2])
    order = np.argsort(away)
    some = corners[np.concatenate([order[-2:], order[-4:-2]])]
    return float(some[:, 0].mean()), float(some[:, 2].mean())


def test_masses_count_in_macro_elements(tmp_path: Path) -> None:
    part = '[[limit.mechanism]]\nblocks = ["a"]\ndirection = "x"\nmechanisms = ["overturning"]\n[limit]\nmasses = [0]\n'
    part += f"{CHECK}displacements = false\n"
    case = limit_case(scene(tmp_path, pillar(), TOP + part), wanted=Wanted(jobs=1))
    first = case.mechanisms[0].row
    assert first["alpha0"] == pytest.approx(0.5 * WIDE / MIDDLE, rel=1e-6) and first["fraction"] == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (f"{TOP}[limit]\nlive = [0]\nmasses = [0]\n", "limit.masses: a push or a tilt moves masses"),
        (f"{TOP}[limit]\npush = 'x'\nmasses = [1]\n", r"limit.masses: loads\[1\]: no load of this scene"),
        (f"{TOP.replace('[0, 0,', '[0, 9,')}[limit]\npush = 'x'\nmasses = [0]\n", r"limit.masses: loads\[0\] is no weight"),
    ],
)
def test_what_is_no_weight_is_refused(tables: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        limit_case(scene(tmp_path, [*pillar(), box("b", (5.0, -0.2, 0.0), (5.5, 0.2, 0.5), fixed=True), ground(2.0)][:2], tables))
