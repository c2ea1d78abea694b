# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kind of load, ours by its starter: it is built, acts, rests and is multiplied as it says, and its words are named by its place."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bridge_scenes import bridge, grid

import loads
import structures
from loads.motion import LoadKind, RunGrid
from loads.static import static_tables
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly

DT, STEPS = 2e-3, 5000
ARCH = Assembly.from_blocks(
    structures.build({"kind": "arch", "span": 4.0, "thickness": 0.4, "width": 1.0, "voussoirs": 27}, 2200.0, Path()), 0.6
)


@pytest.fixture(params=sorted(loads.KINDS))
def first(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[LoadKind, dict[str, Any], RunGrid]:
    """A kind, a first load of it, and a run of 10 s."""
    rows = "".join(f"{0.01 * k:g},{np.sin(np.pi * k / 200) ** 2 * np.sin(0.7 * k):.6g}\n" for k in range(201))
    (tmp_path / "quake.csv").write_text(f"time_s,acc\n{rows}")
    kind = loads.KINDS[request.param]
    of_run = RunGrid(DT, STEPS, np.array([0.0, 0.0, -9.81]), tmp_path, ARCH)
    if request.param == "vehicle":
        of_run = replace(grid(*bridge(width=3.0), steps=STEPS, dt=DT), folder=tmp_path)
    return kind, {"kind": request.param, **kind.starter}, of_run


def test_a_run_takes_it_and_ends_with_it(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    kind, keys, run = first
    table = loads.parse_load(keys, "loads[0]")
    part = kind.part(table, run, "loads[0]")
    assert part.summary["kind"] == keys["kind"] and json.loads(json.dumps(part.summary))
    assert all("loads[0]" in line or "shock" in line for line in (*part.lines, *part.warnings))
    if part.motion is not None:
        velocity = part.motion(run.times)
        assert velocity.shape == (STEPS + 1, 3) and not velocity[[0, -1]].any() and velocity.any()
    if part.acceleration is not None:
        assert part.acceleration.shape == (STEPS + 1, 3)
    assert kind.end is None or 0.0 <= kind.end(table, run, "loads[0]") <= run.end
    if part.acted is not None:
        shares = [part.acted.row(time)["share"] for time in np.linspace(0.0, run.end, 50)]
        assert (np.diff(shares) >= 0.0).all() and shares[-1] == 1.0 and part.acted.end <= run.end


def test_limit_analysis_takes_it_as_the_pattern_that_it_names(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    kind, keys, run = first
    (found,) = static_tables([keys], run)
    assert found.left_out == (kind.static is None)
    given = {"push": found.does.direction, "tilt": found.does.direction, "settlement": found.does.velocity, "live": found.does.points}
    assert not found.pattern or (given[found.pattern] is not None and len(found.does.words) > 8)
    assert all(np.isfinite(force.force).all() and not run.blocks("").fixed[force.block] for force in found.does.points)


def test_one_that_may_grow_grows_by_the_factor(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    kind, keys, run = first
    if kind.grown is None:
        return
    motions = [kind.part(loads.parse_load(one, "loads[0]"), run, "loads[0]").motion for one in (keys, kind.grown(keys, 2.0))]
    once, twice = (motion(run.times) for motion in motions if motion is not None)
    assert twice == pytest.approx(2.0 * once, abs=1e-12)


def test_motions_from_files_have_the_numbers_of_their_components(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    kind, keys, run = first
    if kind.recorded is None:
        return
    made = kind.part(loads.parse_load(keys, "loads[0]"), run, "loads[0]").summary
    (motion,) = kind.recorded(keys, made, "loads[0]")
    assert motion.end - motion.begin == pytest.approx(2.0, abs=DT)
    assert [made["after"]["pga"] > 0.0 for _, _, made in motion.components] == [True]


def test_an_unknown_key_has_those_that_exist_beside_it(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    with pytest.raises(InputError) as refused:
        loads.parse_load({"kind": first[1]["kind"], "zzqq": 1}, "loads[0]")
    assert refused.value.place == "loads[0].zzqq" and all(key in refused.value.faults[0].text for key in first[0].table.model_fields)
