# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages to the user: one line that a terminal can show."""

from __future__ import annotations

import pytest

from masonry_cd.foundation.errors import LINE, one_line


@pytest.mark.parametrize("value", ["a" * 10_000, 'a": {"' * 2_000, "a b " * 3_000, "\x1b[31m" * 2_000])
def test_long_values_are_cut_and_what_is_said_about_them_stays(value):
    shown = one_line(f'modes.csv: unknown column "{value}"; known: mode, frequency_hz')
    assert len(shown) <= LINE + 5
    assert shown.startswith("modes.csv: unknown column ") and shown.endswith("known: mode, frequency_hz")
    assert shown.isprintable()
