# SPDX-License-Identifier: GPL-3.0-or-later
"""The profile of scenes: what it counts adds up, and nothing stays watched."""

from __future__ import annotations

from pathlib import Path

import pytest
from places import EXAMPLES

from benchmarks import profile as module
from benchmarks.profile import PHASES, SHAKEN, STEPS, line_of_steps, profile, records_in, tables
from masonry_cd.app.case import structure_of
from masonry_cd.app.scene import read_scene
from masonry_cd.mechanics.dynamics import moreau_jean
from masonry_cd.mechanics.solvers import admm, interior, newton, nlgs


def test_steps_phases_and_methods_are_counted() -> None:
    """Each step once; the phases are no longer than the steps, and the methods no longer than the phase that solves."""
    places = [(moreau_jean, name) for name in PHASES]
    places += [(admm, "run_by_team"), (newton, "over_bodies"), (interior, "over_bodies"), (nlgs, "run_by_team")]
    before = [getattr(owner, name) for owner, name in places]
    found = profile(EXAMPLES / "arch.toml", ["run.duration=0.05"])
    assert [getattr(owner, name) for owner, name in places] == before
    assert len(found.seconds) == len(found.errors) == len(found.contacts) > 0
    assert set(found.phases) == set(PHASES)
    assert sum(each.iterations for each in found.methods.values()) > 0
    assert sum(each.seconds for each in found.methods.values()) <= found.phases["solve"] <= sum(found.seconds)
    assert all(each.moved > 0.0 for each in found.methods.values() if each.iterations)
    assert sum(line.startswith(("| predict", "| solve")) for line in tables(found)) == 2
    assert line_of_steps(found) in tables(found)


def test_one_table_has_a_line_for_each_scene(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Scenes that need records are left out by name where no folder of them is given."""
    monkeypatch.setattr(module, "SHAKEN", (EXAMPLES / "arch.toml", SHAKEN[1]))
    monkeypatch.setattr("sys.argv", ["profile", "--steps-only", "--set", "run.duration=0.05"])
    assert module.main() == 0
    out, errors = capsys.readouterr()
    *_, head, rule, line = out.splitlines()
    assert f"{head}\n{rule}" == STEPS
    assert line.startswith("| arch.toml |")
    assert line.count("|") == head.count("|") == rule.count("|")
    assert errors == f"{SHAKEN[1].name} is left out: --records FOLDER names the folder of its records\n"


def test_the_scenes_shaken_hard_are_there_and_find_their_records() -> None:
    folder = Path("/somewhere")
    assert [len(records_in(folder, scene)) for scene in SHAKEN] == [0, 2, 0]
    assert records_in(folder, SHAKEN[1])[1] == "loads[1].path=/somewhere/laquila_2009_AQV.csv"
    church = read_scene(SHAKEN[1])
    assert f"Church of {structure_of(church).assembly.count} blocks" in church.title
