# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of scenes in two trees, by turns."""

from __future__ import annotations

import io
import json

import pytest

from benchmarks.served import machine_of
from benchmarks.turns import SHARES, Tree, row
from masonry_cd.foundation.errors import InputError


class Counted:
    """A tree whose steps take so many seconds each, and of which one misses its tolerance in each share."""

    def __init__(self, seconds: float, missed: int) -> None:
        self.seconds, self.missed, self.asked = seconds, missed, list[object]()

    def ask(self, what: int | list[object]) -> dict[str, object]:
        self.asked.append(what)
        if isinstance(what, list):
            return {"steps": 200, "tolerance": 1e-8}
        errors = [1e-7] * self.missed + [1e-9] * (what - self.missed)
        return {"seconds": what * self.seconds, "errors": errors, "contacts": [4] * what}


def test_a_line_has_the_ratio_of_the_seconds_and_the_steps_missed_in_both_trees():
    beside, here = Counted(2e-3, 2), Counted(1e-3, 0)
    line = row((beside, here), "tower50", ([], []), 2)
    assert line == f"| tower50 | 4 | 200 | 2 | 1 | 0.50 | {2 * SHARES} | 0 | 1.0e-07 | 1.0e-09 |"
    assert sum(what for what in here.asked if isinstance(what, int)) == 400


def test_scenes_go_by_names():
    machine, steps = machine_of("tower3", ())
    assert (machine.assembly.count, steps) == (4, 200)
    with pytest.raises(ValueError, match='no scene "strong99"'):
        machine_of("strong99", ())


def test_what_a_tree_cannot_do_is_one_line(tmp_path):
    for answer, said in ((json.dumps({"wrong": "no scene"}) + "\n", "no scene"), ("", "has ended")):
        with pytest.raises(InputError, match=said):
            Tree(tmp_path, io.StringIO(), io.StringIO(answer)).ask(["tower50", []])
