# SPDX-License-Identifier: GPL-3.0-or-later
"""limit.assumed: the factor without bond, crushing and fill, by closed forms, in terminal, limit.json and verdict."""

from __future__ import annotations

from pathlib import Path

import pytest
from limit_scenes import pillar, said, scene
from models import GRAVITY

from masonry_cd.analysis.limit.outcome import on_the_whole
from masonry_cd.limit.case import limit_case
from masonry_cd.limit.facts import facts

WIDE, HIGH, DEEP = 0.5, 1.5, 0.4  # of the pillar [m]
WEIGHT = 2000.0 * GRAVITY * WIDE * HIGH * DEEP
PUSH = "[limit]\npush = 'x'\n"


def test_a_pillar_that_is_glued_down_bears_b_over_h_without_its_bond(tmp_path: Path) -> None:
    case = limit_case(scene(tmp_path, pillar(), PUSH, joints=", joints = {cohesion = 1e4}"))
    (one,) = case.without
    assert (one.assumed, one.factor) == ("bond", pytest.approx(WIDE / HIGH, rel=1e-6))
    assert case.whole is not None and case.whole.analysis.associated.factor > 1.1 * WIDE / HIGH
    verdict = on_the_whole(facts(case))
    assert verdict is not None and one.line in verdict.because and one.line in said(case)


def test_a_pillar_whose_joint_crushes_bears_b_over_h_where_it_would_not(tmp_path: Path) -> None:
    strength = 3.0 * WEIGHT / (WIDE * DEEP)
    case = limit_case(scene(tmp_path, pillar(), PUSH, joints=f", joints = {{compressive_strength = {strength}}}"))
    (one,) = case.without
    assert (one.assumed, one.factor) == ("crushing", pytest.approx(WIDE / HIGH, rel=1e-6))
    assert case.whole is not None and case.whole.analysis.associated.factor == pytest.approx(WIDE / HIGH * (1.0 - 1.0 / 3.0), rel=1e-3)


def test_a_check_names_the_factor_without_bond_and_dry_joints_assume_nothing(tmp_path: Path) -> None:
    check = f'{PUSH}[limit.check]\nspectrum = "EC8"\nag = 1.0\ndisplacements = false\n'
    bonded = limit_case(scene(tmp_path, pillar(), check, joints=", joints = {cohesion = 1e4}"))
    assert bonded.verdict is not None and bonded.without[0].line in bonded.verdict.reason
    assert limit_case(scene(tmp_path, pillar(), check)).without == ()
