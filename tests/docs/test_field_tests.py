# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of bridges loaded to collapse has the figures that its generator makes."""

from __future__ import annotations

import runpy

from places import ROOT

from masonry_cd.studies.laboratory.field_tests import PRESTWOOD, WITHIN, collapse

WRITER = ROOT / "docs" / "write_field_tests.py"


def test_the_page_is_what_its_generator_makes() -> None:
    made = runpy.run_path(str(WRITER))
    text = (ROOT / "docs" / "field_tests.md").read_text(encoding="utf-8")
    assert text == made["page"]()


def test_four_hinges_within_a_fifth_of_the_test_at_full_passive_pressure_and_below_it_by_default() -> None:
    full, hinges = collapse(PRESTWOOD, "structure.fill.passive=1.0")
    default, _ = collapse(PRESTWOOD)
    assert hinges == 4
    assert abs(full / PRESTWOOD.measured - 1.0) < WITHIN
    assert 0.6 < default / PRESTWOOD.measured < 0.8
