# SPDX-License-Identifier: GPL-3.0-or-later
"""mc.macro_elements: the parts of a structure as DataFrames, and the verdict, as the command finds them."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from two_blocks import two_blocks

import masonry_cd as mc

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
CHECK = {"spectrum": "EC8", "ag": 2.0}


def test_tables_and_verdict_are_those_of_the_command(tmp_path: Path) -> None:
    found = mc.macro_elements(mc.scene(two_blocks(), limit={"check": CHECK}), tmp_path / "out", jobs=1)
    made = json.loads((tmp_path / "out" / "limit.json").read_text())
    with (tmp_path / "out" / "mechanisms.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(found.mechanisms.columns) == list(rows[0]) and len(found.mechanisms) == len(rows)
    assert found.parts["ratio"].is_monotonic_increasing and len(found.parts) == len(found.parts[["element", "push"]].drop_duplicates())
    assert found.verdict is not None and found.verdict["words"] == made["verdict"]["words"] and found.verdict["reason"] in str(found)
    assert found.verdict["state"] in repr(found)
    with pytest.raises(mc.InputError, match="force"):
        found.write(tmp_path / "out")


def test_without_a_check_there_is_no_verdict() -> None:
    found = mc.macro_elements(mc.scene(two_blocks()), jobs=1)
    assert found.verdict is None and found.parts["ratio"].isna().all() and found.parts["a0_m_s2"].is_monotonic_increasing
