# SPDX-License-Identifier: GPL-3.0-or-later
"""Traces pass the checks of files: what is a velocity, what are counts, and what the channels are."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import masonry_cd as mc
from masonry_cd.app.case import prepare

STEP = 0.005
TIME = STEP * np.arange(801)
WAVE = np.sin(np.pi * TIME / 4.0) ** 2 * np.sin(12.0 * TIME)


def trace(channel: str = "HNE", data: Any = WAVE, **stats: Any) -> SimpleNamespace:
    """What has the attributes of a trace of obspy."""
    about = SimpleNamespace(delta=STEP, channel=channel, **({"starttime": 0.0} | stats))
    return SimpleNamespace(data=np.asanyarray(data), stats=about, id=f"XX.SITE..{channel}")


COUNTS = np.round(1e4 * WAVE).astype(np.int32)


@pytest.mark.parametrize(
    ("traces", "keys", "message"),
    [
        (trace("HHE"), {}, r"\.quantity: missing, .*HHE is a record of velocity"),
        (trace("BHZ"), {}, r"\.quantity: missing, .*BHZ is a record of velocity"),
        (trace("HLE"), {}, r"\.quantity: missing, .*low-gain sensor"),
        ([trace("HHE"), trace("HHN")], {}, r"\.quantity: missing"),
        (trace(data=COUNTS), {}, r"\.calibration: missing, .*HNE holds whole numbers"),
        ([trace(), trace("HNN", COUNTS)], {}, r"\.calibration: missing, .*HNN holds"),
        (trace(processing=["remove_response(output='VEL')"]), {}, r"\.quantity: missing, .* of velocity"),
        (trace(processing=["ObsPy 1.4: integrate(method='cumtrapz')"]), {}, r"\.quantity: missing, .* of velocity"),
        (trace("HHE"), {"quantity": "velocity", "units": "m/s2"}, r'\.units: "m/s2" is a unit of acceleration'),
        (trace(), {"units": "furlong"}, r"\.units: unknown unit"),
        (trace(), {"quantity": "jerk"}, r'quantity: "jerk" is none'),
        (trace(data=np.where(TIME == 1.0, np.nan, WAVE)), {}, "sample 201 of XX.SITE..HNE is not a finite number"),
        (trace(data=np.ma.masked_greater(WAVE, 0.9)), {}, "HNE has gaps"),
        ([trace(), trace(starttime=9.0)], {}, "a gap of 4.995 s"),
        (trace(data=1e300 * WAVE), {}, "an acceleration of"),
        (trace(data=[["a"]]), {}, "a row of real numbers is needed"),
    ],
)
def test_what_a_file_would_be_refused_for_a_trace_is_refused_for(traces: Any, keys: dict[str, Any], message: str) -> None:
    with pytest.raises(mc.InputError, match=message):
        mc.from_traces(traces, direction="x", **keys)


@pytest.mark.parametrize(
    ("given", "keys", "factor"),
    [
        (trace(), {}, 1.0),
        (trace(), {"units": "cm/s2"}, 0.01),
        (trace(), {"scale": 2.0}, 2.0),
        (trace(data=COUNTS), {"scale": 1e-4}, 1.0),
        (trace(data=COUNTS), {"calibration": 1e-4}, 1.0),
        (trace(data=COUNTS), {"calibration": 1e-2, "units": "gal"}, 1.0),
        (trace("HHE"), {"quantity": "acceleration"}, 1.0),
        (trace("HHE", processing=["remove_response(output='ACC')"]), {}, 1.0),
        (trace("HHE", processing=["ObsPy 1.4: differentiate(method='gradient')"]), {}, 1.0),
        ([trace(data=WAVE[:400]), trace(data=WAVE[400:], starttime=2.0)], {}, 1.0),
    ],
)
def test_what_is_said_of_a_trace_counts(given: Any, keys: dict[str, Any], factor: float) -> None:
    found = mc.from_traces(given, direction="x", **keys)
    assert found["acceleration"] == pytest.approx(factor * WAVE, abs=1e-4)


def test_a_velocity_is_differentiated_on_request() -> None:
    found = mc.from_traces(trace("HHE"), direction="x", quantity="velocity")
    assert found["acceleration"][200:600] == pytest.approx(np.gradient(WAVE, STEP)[200:600], abs=0.02)


def test_channels_keep_their_names(tables: dict[str, Any]) -> None:
    made = mc.scene(tables, loads=[mc.from_traces([trace(), trace("HNZ", 0.5 * WAVE)])])
    assert [(load["column"], load["direction"]) for load in made.tables["loads"]] == [("XX.SITE..HNE", "x"), ("XX.SITE..HNZ", "z")]
    assert [one["column"] for one in prepare(made.checked).loading.summary["tables"][:2]] == ["XX.SITE..HNE", "XX.SITE..HNZ"]
