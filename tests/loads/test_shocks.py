# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.kinds.sequence: shocks and their rests, components recorded or artificial; bad keys are named by their full path."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import loads

G = (0.0, 0.0, -9.81)
DT = 5e-3
DRAWN = {"direction": "y", "spectrum": "EC8", "ag": 1.0, "duration": 8.0, "level": 4.0, "tolerance": 0.3, "seed": 3}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A record of 2 s: two periods of a sine of 1 Hz and 2 m/s2."""
    path = tmp_path_factory.mktemp("records")
    times = 0.01 * np.arange(201)
    rows = (f"{t:.2f},{2.0 * np.sin(2 * np.pi * t):.8f}" for t in times)
    (path / "sine.csv").write_text("\n".join(["time_s,a_m_s2", *rows]) + "\n")
    return path


SINE = {"direction": "x", "path": "sine.csv"}


def build(folder: Path, *shocks: dict, seconds: float = 60.0, **keys: object) -> loads.Loading:
    table = {"kind": "sequence", "shocks": list(shocks), **keys}
    return loads.build([table], DT, round(seconds / DT), G, folder)


def test_shocks_follow_one_another_after_their_rests(folder: Path) -> None:
    one = {"components": [SINE]}
    loading = build(folder, one, {"name": "main", "components": [SINE], "scale": 2.0}, rest=3.0, start=1.0)
    assert [(s.name, s.first, s.last) for s in loading.shocks] == [("shock 1", 200, 600), ("main", 1200, 1600)]
    assert loading.pauses == ()  # rests of a given length are not ended early
    v = loading.support_velocity[:, 0, 0]
    assert v[1200:1601] == pytest.approx(2.0 * v[200:601])
    assert not v[:200].any() and not v[600:1200].any() and not v[1600:].any()
    still = build(folder, one, one, longest_rest=4.0, hold=0.1, still=2e-3)
    assert [(p.first, p.last, p.speed, p.hold) for p in still.pauses] == [(400, 1200, 2e-3, 20), (1600, 2400, 2e-3, 20)]
    assert any(
        "the run ends at 5 s: run.duration = 12 would hold all" in line
        for line in build(folder, one, one, longest_rest=4.0, seconds=5.0).lines
    )


def test_a_pause_in_which_another_load_acts_is_not_ended_early(folder: Path) -> None:
    pushed = {"kind": "push", "direction": "x", "rate": 0.01, "start": 7.0}
    shocks = {"kind": "sequence", "shocks": [{"components": [SINE]}] * 2, "longest_rest": 4.0}
    loading = loads.build([shocks, pushed], DT, round(12.0 / DT), G, folder)
    assert [pause.after for pause in loading.pauses] == ["shock 1"]
    assert any('rest after "shock 2": not ended early' in line for line in loading.lines)


def test_components_share_one_factor_and_may_be_artificial(folder: Path) -> None:
    loading = build(folder, {"components": [SINE, {**DRAWN, "direction": "x"}], "target_pga": 3.0}, rest=0.0)
    again = build(folder, {"components": [SINE, {**DRAWN, "direction": "x"}], "target_pga": 3.0}, rest=0.0)
    assert (loading.support_velocity == again.support_velocity).all()
    (shock,) = loading.summary["tables"][0]["shocks"]
    peaks = [component["after"]["pga"] for component in shock["components"]]
    assert max(peaks) == pytest.approx(3.0)
    alone = loads.build([{"kind": "artificial", **DRAWN}], DT, round(8.0 / DT), G, folder)
    own = build(folder, {"components": [DRAWN]}, rest=0.0)
    assert own.support_velocity[: round(7.5 / DT)] == pytest.approx(alone.support_velocity[: round(7.5 / DT)])
    assert any("artificial, EC8 spectrum, ground A, seed 3 along y" in line for line in own.lines)
