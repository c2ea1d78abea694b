# SPDX-License-Identifier: GPL-3.0-or-later
"""A verdict knows how much of the loads has acted, and is never better than the warnings of its run, whichever door it came through."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import masonry_cd as mc

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")

LATE = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.05, "frequency": 5.0, "cycles": 1, "start": 0.1}


def checked(run: mc.Run) -> dict[str, str]:
    """The verdict of each check by its name."""
    return {row["check"]: row["verdict"] for row in run.summary["verdict"]["checks"]}


@pytest.mark.parametrize(("duration", "share", "wanted"), [(0.05, 0.0, "look"), (0.2, 0.5, "look"), (0.3, 1.0, "good")])
def test_a_run_that_ends_before_its_load_is_to_be_looked_at(tables: dict[str, Any], duration: float, share: float, wanted: str) -> None:
    run = mc.run(
        mc.scene(tables | {"loads": [LATE]}, f"run.duration={duration}", "run.until_still=true" if share == 1.0 else "run.seed=0"),
        progress=False,
    )
    assert run.summary["loads"]["acted"] == [{"load": "loads[0]", "measure": "cycles", "share": pytest.approx(share, abs=0.02)}]
    assert checked(run)["Loads"] == wanted
    assert any("loads[0]" in line and "%" in line for line in run.lines)
    assert any("loads[0]" in line for line in run.warnings) == (wanted == "look")


def test_motions_and_forces_of_python_count_as_well(tables: dict[str, Any]) -> None:
    still = mc.scene({key: value for key, value in tables.items() if key != "loads"}, "run.duration=0.05")
    push = (np.array([0.0, 0.1]), np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    run = mc.Simulation(still, forces={"b2": push}).record(progress=False)
    (row,) = run.summary["loads"]["acted"]
    assert "b2" in row["load"] and row["share"] == pytest.approx(0.5, abs=0.02) and checked(run)["Loads"] == "look"


def test_a_block_that_falls_beside_its_warning_is_not_good() -> None:
    blocks = [mc.box((-1, -1, -0.5), (1, 1, 0)), mc.box((-0.5, -0.5, 0.1), (0.5, 0.5, 1.1))]
    scene = {
        "structure": {"blocks": blocks, "fixed": "b0"},
        "material": {"density": 2000.0, "friction": 0.5},
        "run": {"dt": 2e-3, "duration": 0.02},
    }
    run = mc.run(mc.scene(scene), progress=False)
    assert any("b1" in line for line in run.warnings)
    assert checked(run)["Model"] == "look" and "b1" in run.summary["verdict"]["why"]
