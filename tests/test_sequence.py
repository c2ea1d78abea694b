"""loads.sequence: shocks one after the other, at rest between them, and pauses that a run loop may end early without a trace."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import loads
from masonry_cd.errors import InputError

G = (0.0, 0.0, -9.81)
DT = 2e-3
TIME = 0.01 * np.arange(401)
A, B = (np.sin(np.pi * TIME / 4.0) ** 2 * np.sin(2 * np.pi * f * TIME) for f in (2.0, 3.0))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    both, one = zip(TIME, A, B, strict=True), zip(TIME[:301], B[:301], strict=True)
    (tmp_path / "one.txt").write_text("t ns_m_s2 up_m_s2\n" + "".join(f"{t:.2f} {a:.9g} {b:.9g}\n" for t, a, b in both))
    (tmp_path / "two.txt").write_text("t ns_m_s2\n" + "".join(f"{t:.2f} {b:.9g}\n" for t, b in one))
    return tmp_path


ONE = {
    "name": "first",
    "components": [{"path": "one.txt", "column": "ns", "direction": "x"}, {"path": "one.txt", "column": "up", "direction": "z"}],
}
TWO = {"components": [{"path": "two.txt", "direction": "x"}]}


def build(folder: Path, *others: dict, steps: int = 10000, shocks: list | None = None, **keys: object) -> loads.Loading:
    table = {"kind": "sequence", "shocks": [ONE, TWO] if shocks is None else shocks, **keys}
    return loads.build([table, *others], DT, steps, G, folder)


def alone(folder: Path, start: float, **keys: object) -> np.ndarray:
    return loads.build([{"kind": "record", "start": start, **keys}], DT, 10000, G, folder).support_velocity[:, 0]


def test_shocks_follow_each_other_after_a_fixed_rest(folder: Path) -> None:
    loading = build(folder, rest=1.5, start=0.5)
    wanted = alone(folder, 0.5, **ONE["components"][0]) + alone(folder, 0.5, **ONE["components"][1])
    wanted += alone(folder, 0.5 + 4.0 + 1.5, **TWO["components"][0])
    assert loading.support_velocity[:, 0] == pytest.approx(wanted, abs=1e-12)
    assert [(s.name, s.first, s.last) for s in loading.shocks] == [("first", 250, 2250), ("shock 2", 3000, 4500)]
    assert not loading.pauses
    assert not loading.support_velocity[2250:3001].any()
    assert json.loads(json.dumps(loading.summary)) == loading.summary


def test_a_rest_until_still_is_laid_out_in_full_and_may_be_jumped(folder: Path) -> None:
    loading = build(folder, longest_rest=2.0, hold=0.3, still=5e-3)
    first, last = loading.pauses
    assert (first.first, first.last, first.hold, first.speed, first.after) == (2000, 3000, 150, 5e-3, "first")
    assert (last.first, last.last, last.after) == (4500, 5500, "shock 2")
    assert loading.after_rest(2100, quiet=149) == 2100
    assert loading.after_rest(2100, quiet=150) == 3000
    assert loading.after_rest(1999, quiet=900) == 1999
    assert loading.after_rest(3000, quiet=900) == 3000
    kept = [k for k in range(10001) if not 2100 <= k < first.last]  # as a loop that finds the structure still after 0.2 s goes on
    fixed = build(folder, rest=0.2)
    assert loading.support_velocity[kept][:4700] == pytest.approx(fixed.support_velocity[:4700], abs=1e-12)


def test_one_factor_for_all_components_and_one_rotation(folder: Path) -> None:
    plain, scaled = build(folder, shocks=[ONE]), build(folder, shocks=[{**ONE, "target_pga": 3.0}])
    factor = scaled.summary["tables"][0]["shocks"][0]["factor"]
    assert scaled.support_velocity == pytest.approx(factor * plain.support_velocity)
    peaks = [c["after"]["pga"] for c in scaled.summary["tables"][0]["shocks"][0]["components"]]
    assert max(peaks) == pytest.approx(3.0)
    turned = build(folder, shocks=[{**ONE, "rotate": 90.0}]).support_velocity[:, 0]
    assert turned[:, 1] == pytest.approx(plain.support_velocity[:, 0, 0], abs=1e-12)
    assert turned[:, 2] == pytest.approx(plain.support_velocity[:, 0, 2], abs=1e-12)


def test_a_pause_in_which_another_load_acts_is_kept_in_full(folder: Path) -> None:
    late = {"kind": "sinusoidal", "direction": "y", "amplitude": 0.1, "frequency": 2.0, "cycles": 1, "start": 4.5}
    loading = build(folder, late, longest_rest=2.0)
    assert [pause.after for pause in loading.pauses] == ["shock 2"]
    assert any('rest after "first": not ended early' in line for line in loading.lines)
    assert not build(folder, {"kind": "push", "direction": "x", "rate": 0.01}).pauses


def test_a_run_too_short_says_how_long_it_should_be(folder: Path) -> None:
    loading = build(folder, rest=1.0, steps=2500)
    assert any("run.duration = 9 would hold all shocks and rests" in line for line in loading.lines)
    assert [shock.name for shock in loading.shocks] == ["first"]
    assert build(folder, longest_rest=2.0, steps=2500).pauses[0].last == 2500


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"shocks": []}, "loads[0].shocks: "),
        ({"shocks": [{"components": []}]}, "loads[0].shocks.0.components: "),
        ({"shocks": [{"components": [{"path": "two.txt"}]}]}, "loads[0].shocks.0.components.0.direction: missing"),
        ({"shocks": [{**TWO, "scale": 1.0, "target_pga": 1.0}]}, "loads[0].shocks.0: give scale or target_pga, not both"),
        (
            {"shocks": [TWO, {"components": [{"path": "three.txt", "direction": "x"}]}]},
            "loads[0].shocks[1].components[0].path: three.txt: no such file",
        ),
        ({"rest": "soon"}, 'loads[0].rest: must be a time in seconds, or "still"'),
        ({"rest": -1.0}, 'loads[0].rest: must be a time in seconds, or "still"'),
        ({"still": 0.0}, "loads[0].still: "),
    ],
)
def test_bad_keys_are_named(folder: Path, keys: dict, message: str) -> None:
    with pytest.raises(InputError) as failure:
        build(folder, **keys)
    assert str(failure.value).startswith(message)
    assert "\n" not in str(failure.value)
