# SPDX-License-Identifier: GPL-3.0-or-later
"""The texts that commands print and pages show are the approved ones, see tests/approvals.py."""

from __future__ import annotations

from pathlib import Path

import pytest
from approvals import APPROVED, TEXTS, text_of

AGAIN = "where this is intended: python tests/approvals.py, and read what it changes"


@pytest.mark.parametrize("name", TEXTS)
def test_the_text_is_the_approved_one(name: str, tmp_path: Path) -> None:
    assert text_of(name, tmp_path) == (APPROVED / f"{name}.txt").read_text(encoding="utf-8"), AGAIN


def test_no_text_is_left_over() -> None:
    assert {path.stem for path in APPROVED.iterdir()} == set(TEXTS)
