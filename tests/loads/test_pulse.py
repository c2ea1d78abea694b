# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.kinds.pulse and plausible records: a body force that ends has its impulse exactly, and pulses in files raise no alarm."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import refused_at
from models import box

import loads
from masonry_cd.mechanics.model.blocks import Assembly

GRAVITY = (0.0, 0.0, -9.81)
SHAKES = "begins while the ground shakes"  # said of a record that is cut, and not of a pulse
PULSE: dict[str, Any] = {"kind": "pulse", "direction": "x", "acceleration": 1.5, "duration": 0.25, "start": 0.1}


@pytest.mark.parametrize(("shape", "impulse"), [("half-sine", 2.0 / np.pi), ("rectangle", 1.0), ("sine", 0.0)])
@pytest.mark.parametrize("dt", [5e-3, 7e-3])  # of which the pulse is no multiple
def test_a_pulse_puts_in_its_impulse_and_ends(shape: str, impulse: float, dt: float) -> None:
    found = loads.build([PULSE | {"shape": shape}], dt, 100, GRAVITY, Path())
    x = found.acceleration[:, 0]
    assert dt * x.sum() == pytest.approx(1.5 * 0.25 * impulse, abs=1e-12)
    assert not x[dt * np.arange(101) > 0.35 + dt].any()
    assert (found.acceleration[:, 2] == -9.81).all()


@pytest.mark.parametrize("values", [np.sin(np.pi * np.linspace(0.0, 1.0, 30)), np.r_[np.ones(30), np.zeros(5)]])
def test_a_pulse_in_a_file_does_not_begin_while_the_ground_shakes(values: np.ndarray, tmp_path: Path) -> None:
    table = "time,acceleration\n" + "\n".join(f"{0.01 * k:g},{value:.6g}" for k, value in enumerate(values))
    (tmp_path / "pulse.csv").write_text(table + "\n")
    record = {"kind": "record", "path": "pulse.csv", "direction": "x", "units": "m/s2", "correction": "none"}
    found = loads.build([record], 1e-3, 100, GRAVITY, tmp_path)
    assert not any(SHAKES in line for line in found.warnings)


def test_a_record_that_is_cut_is_still_warned_of_in_plain_numbers(tmp_path: Path) -> None:
    values = np.sin(np.linspace(0.5, 60.0, 600)) * np.r_[np.ones(500), np.linspace(1.0, 0.0, 100)]
    table = "time,acceleration\n" + "\n".join(f"{0.01 * k:g},{value:.6g}" for k, value in enumerate(values))
    (tmp_path / "cut.csv").write_text(table + "\n")
    record = {"kind": "record", "path": "cut.csv", "direction": "x", "units": "m/s2", "correction": "none"}
    found = loads.build([record], 1e-3, 100, GRAVITY, tmp_path)
    (line,) = [line for line in found.warnings if SHAKES in line]
    assert "e+" not in line


def test_a_run_without_a_duration_lasts_as_long_as_its_loads() -> None:
    ground = box("ground", (-2.0, -2.0, -0.5), (3.0, 3.0, 0.0), fixed=True)
    assembly = Assembly.from_blocks([ground, box("b", (0.0, 0.0, 0.0), (0.5, 1.0, 2.0))], 0.5)

    def end(*tables: dict[str, Any]) -> tuple[float, float]:
        return loads.end_of(tables, 1e-3, GRAVITY, Path(), assembly)

    sine = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.1, "frequency": 2.0, "cycles": 3, "start": 0.5}
    assert end(sine, PULSE) == pytest.approx((2.0, 1.0))
    push = {"kind": "push", "control": "displacement", "direction": "x", "blocks": "b", "targets": [0.01, 0.0], "speed": 0.01, "hold": 0.2}
    assert end(push) == pytest.approx((2 * 1.875 + 0.4, 0.0))
    assert end({"kind": "tilt", "direction": "x", "rate": 2.0, "angle": 10.0}) == pytest.approx((5.0, 1.0))
    with refused_at("run.duration"):
        end({"kind": "push", "direction": "x", "rate": 0.1})
    with refused_at("run.duration"):
        end()
