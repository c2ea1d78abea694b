# SPDX-License-Identifier: GPL-3.0-or-later
r"""Which pulse throws an arch of 17 voussoirs down, by the stiffness of its joints and their points: a table for docs/validation.md.

    python -m benchmarks.soft_arch
    python -m benchmarks.soft_arch --only "rigid, 0.47 m"

The arch is that of ``masonry-cd validate arch``. An open bed without tension has its force c / 3 inside its edge, where it touches over
c = sqrt(2 N / (k_n theta)): an arch on soft joints is a rigid one that is thinner by 2 c / 3. So the table has thinner rigid arches of the
same axis and weight next to it.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.gauge_histories import point_histories
from masonry_cd.studies.laboratory.case import run_in
from structures.kinds.arch import build

THICK, DENSITY, GRAVITY = 0.5, 2700.0, 9.81  # [m], [kg/m3], [m/s2]
LEAST, MOST, APART = 0.08, 0.26, 0.003  # pulses that are looked at, and how near to the least one that throws it down [g]
DAMPED = {"tangential_stiffness": 1e10, "damping": 0.05, "damping_frequency": 11.0}  # as 3DEC's arch, nearly
FALLEN = 0.3  # by which the crown sinks [m]


def law(points: int, stiffness: float, **more: float) -> dict[str, Any]:
    """An elastic joint; k_t = 0.4 k_n where it is not given."""
    return {"joint_points": points, "normal_stiffness": stiffness, "tangential_stiffness": 0.4 * stiffness, **more}


WAYS: dict[str, tuple[dict[str, Any] | None, float]] = {
    "rigid": (None, THICK),
    **{f"2e10 N/m3, {points} points": (law(points, 2e10), THICK) for points in (3, 5, 7, 9, 11, 15)},
    **{f"1.5e10 / 1e10 N/m3, 5 % at 11 Hz, {points} points": (law(points, 1.5e10, **DAMPED), THICK) for points in (3, 9)},
    **{f"1e11 N/m3, {points} points": (law(points, 1e11), THICK) for points in (3, 7, 9, 15)},
    **{f"1e12 N/m3, {points} points": (law(points, 1e12), THICK) for points in (3, 9)},
    **{f"rigid, {thick:g} m": (None, thick) for thick in (0.48, 0.47, 0.46)},
}


def falls(share: float, joints: dict[str, Any] | None, thick: float) -> bool:
    """Return True if a half sine of 0.25 s and a share of gravity throws it down."""
    blocks = build({"radius": 4.0, "thickness": thick, "width": 1.0, "voussoirs": 17}, DENSITY * THICK / thick, Path())
    tables = {
        "material": {"density": DENSITY, "friction": 0.7} | ({} if joints is None else {"joints": {"default": joints}}),
        "loads": [{"kind": "pulse", "direction": "x", "acceleration": share * GRAVITY, "duration": 0.25}],
        "run": {"dt": 1e-3, "duration": 2.0, "tolerance": 1e-6},
        "output": {"point": [{"block": "v9", "name": "crown"}]},
    }
    with tempfile.TemporaryDirectory() as folder, run_in(Path(folder), blocks, tables) as results:
        return bool(np.abs(point_histories(results)["crown"]["uz"]).max() > FALLEN)


def least(joints: dict[str, Any] | None, thick: float) -> tuple[float, float]:
    """A pulse that it stands, and one that throws it down, not far apart [g]."""
    low, high = LEAST, MOST
    while high - low > APART:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if falls(middle, joints, thick) else (middle, high)
    return low, high


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Which pulse throws an arch down, by the points and the stiffness of its joints.")
    parser.add_argument("--only", choices=WAYS, help="one row")
    only = parser.parse_args().only
    print("| joints | stands [g] | falls [g] |\n|---|---|---|")
    for name, way in WAYS.items():
        if only in (None, name):
            low, high = least(*way)
            print(f"| {name} | {low:.3f} | {high:.3f} |", flush=True)


if __name__ == "__main__":
    main()
