"""The stability sheet: what stands passes, what falls or is penetrated does not, and the table says which."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.scenes import tower
from benchmarks.stability import DRIFT, StabilityCase, cases, main, row, run, sheet
from benchmarks.stability_picture import draw


@pytest.fixture(scope="module")
def standing():
    return run(StabilityCase("time step", "tower of 3", replace(tower(3, amplitude=0.0), dt=5e-2), 20))


def test_a_tower_at_rest_passes(standing):
    assert standing.failures == []
    assert (standing.blocks, standing.steps, standing.stopped) == (3, 20, "")
    assert set(standing.limits) == {"drift", "penetration", "balance", "dissipation"}
    assert row(standing).endswith("| pass |")


def test_a_tower_that_overhangs_fails_by_its_drift():
    """Each block stands out by 0.4 of its side: the lowest joint is overturned by the two blocks above it."""
    made = tower(3, amplitude=0.0)
    leaning = tuple(replace(block, vertices=block.vertices + [0.2 * k, 0.0, 0.0]) for k, block in enumerate(made.blocks))
    fallen = run(StabilityCase("time step", "leaning", replace(made, blocks=leaning), 100))
    assert "drift" in fallen.failures
    assert fallen.drift > 100.0 * DRIFT
    assert "**FAIL**: drift" in row(fallen)


@pytest.mark.parametrize(
    ("change", "failure"),
    [
        ({"drift": 1e-5}, "drift"),
        ({"penetration": 1e-4}, "penetration"),
        ({"balance": 1e-3}, "balance"),
        ({"gained": 1e-2}, "dissipation"),
        ({"balance": np.nan}, "balance"),
        ({"stopped": "step 3: not finite"}, "finite"),
    ],
)
def test_every_measure_can_fail(standing, change, failure):
    assert replace(standing, **change).failures == [failure]


def test_what_is_shaken_may_drift(standing):
    shaken = replace(standing, at_rest=False, drift=0.3)
    assert shaken.failures == []
    assert "(3.0e-01)" in row(shaken)


def test_the_cases_span_what_the_head_says():
    found = list(cases())
    assert {case.scene.dt for case in found} >= {1e-4, 5e-2}
    accelerations = [2 * np.pi * case.scene.frequency * case.scene.amplitude / 9.81 for case in found]
    assert max(accelerations) == pytest.approx(5.0)
    assert max(case.scene.frequency for case in found) == 50.0
    assert max(case.scene.stiffness for case in found) == 1e13
    assert {case.scene.friction for case in found} >= {0.0, 10.0}
    assert len({case.name for case in found}) == len(found)


def test_page_and_picture(standing, tmp_path):
    failed = replace(standing, name="another", group="size", penetration=1e9)
    text = sheet([standing, failed])
    assert "1 of 2 cases pass" in text
    assert text.count("\n| ") == 3  # heading and two cases
    draw([standing, failed], tmp_path / "s.png")
    assert (tmp_path / "s.png").stat().st_size > 10_000


def test_an_unknown_case_is_refused(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--only", "no such case"])
    assert ended.value.code == 2
    assert 'no case "no such case"' in capsys.readouterr().err
