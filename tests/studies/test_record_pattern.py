# SPDX-License-Identifier: GPL-3.0-or-later
"""The regular expression of a study ends, whatever it is."""

from __future__ import annotations

import pytest
from hostile import refused_at

from masonry_cd.studies.study.record_tables import RecordsTable
from masonry_cd.studies.study.records import matched

NAMES = ["AQV_x.acc", "notes.txt", "città_y.acc"]


def test_names_give_motions_and_components() -> None:
    pattern = RecordsTable.model_fields["pattern"].default
    assert matched(pattern, NAMES) == [("AQV_x.acc", "AQV", "x"), ("città_y.acc", "città", "y")]


@pytest.mark.parametrize("pattern", [r"(?P<motion>(\w+)+)!(?P<component>x)", r"(?P<motion>(.|[^_])*)!(?P<component>x)"])
def test_one_that_backtracks_for_ever_is_refused(pattern: str) -> None:
    with refused_at("records.pattern"):
        matched(pattern, [60 * "a"], longest=0.5)
