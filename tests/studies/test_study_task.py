# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs in one process: what they share, and what they must not."""

from __future__ import annotations

from typing import Any

import pytest

from masonry_cd.studies.study.task import Task, run_task


def tables(height: float, several: bool) -> dict[str, Any]:
    """A wall of a height, alone or beside another one, at rest for a few steps."""
    own = {"kind": "wall", "length": 1.0, "thickness": 0.5, "height": height, "course_height": 0.5, "unit_length": 0.5}
    beside = own | {"name": "low", "height": 0.5, "at": [3.0, 0.0, 0.0]}
    return {
        **({"structures": [own | {"name": "tall"}, beside]} if several else {"structure": own}),
        "material": {"density": 2000.0, "friction": 0.6},
        "run": {"dt": 1e-2, "duration": 0.05},
    }


@pytest.mark.parametrize("several", [False, True])
def test_runs_of_other_structures_share_none(several: bool) -> None:
    """Structures are kept from run to run, by all tables that they are made of."""
    heights = (1.0, 1.5, 1.0)
    outcomes = [run_task(Task(f"run{k}", tables(height, several), 60.0)) for k, height in enumerate(heights)]
    assert [outcome.row.status for outcome in outcomes] == ["done"] * 3, outcomes
    joints = [0 if outcome.joints is None else len(outcome.joints["opening"]) for outcome in outcomes]
    assert joints[0] == joints[2] < joints[1]
