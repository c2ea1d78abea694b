# SPDX-License-Identifier: GPL-3.0-or-later
"""A block on one elastic bed that is pushed over: the closed form of a bed without tension."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.studies.laboratory.case import CaseResults, CaseRow, LaboratoryCase, at, elastic, pushed
from structures.geometry.prism import box

WIDTH, HEIGHT, PUSHED, WEIGHT, STIFFNESS = 0.5, 2.0, 1.998, 60e3, 2e10  # [m], [N], [N/m3]
FEW = 3  # points over the depth, where the default has 9
WAYS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2)  # [m]


def exact(way: float) -> float:
    """The force at a displacement of the point that is pushed [N].

    With rotation theta the bed is compressed over c: the whole width while it stays closed, W = k theta c^2 / 2 once it opens.
    """

    def force(theta: float) -> float:
        whole = 0.5 * STIFFNESS * theta * WIDTH**2
        if whole <= WEIGHT:  # closed: moment k theta B^3 / 12
            return (STIFFNESS * theta * WIDTH**3 / 12.0 - WEIGHT * 0.5 * HEIGHT * theta) / PUSHED
        c = float(np.sqrt(2.0 * WEIGHT / (STIFFNESS * theta)))
        return (WEIGHT * (0.5 * WIDTH - c / 3.0) - WEIGHT * 0.5 * HEIGHT * theta) / PUSHED

    return force(float(brentq(lambda theta: PUSHED * theta - way, 1e-9, 1.0)))


def compute(folder: Path, say: Callable[[str], object]) -> CaseResults:
    """Push it by 10 mm."""
    blocks = [
        Block("ground", *box((-0.5, -0.5, -0.5), (1.0, 1.5, 0.0)), 2000.0, "base", fixed=True),
        Block("block", *box((0.0, 0.0, 0.0), (WIDTH, 1.0, HEIGHT)), WEIGHT / 9.81 / (WIDTH * HEIGHT), "block"),
    ]
    push = {
        "kind": "push", "control": "displacement", "direction": "x", "blocks": "block", "point": [0.0, 0.5, PUSHED], "targets": [0.0102],
        "speed": 0.005,
    }  # fmt: skip
    law = {"normal_stiffness": STIFFNESS, "tangential_stiffness": 100.0 * STIFFNESS, "damping": 0.2}
    found = CaseResults()
    few = law | {"joint_points": FEW}
    for label, joint, points in (("elastic", law, ""), (f"elastic_{FEW}", few, f", {FEW} points"), ("rigid", {}, "")):
        material = {"density": 2000.0, "friction": 5.0, **elastic(joint)}
        tables = {"title": f"A block on its bed, {label}", "material": material, "loads": [push], "run": {"dt": 1e-3, "tolerance": 1e-7}}
        curve = pushed(folder / label, blocks, tables | {"quiet_checks": ["material.friction"]})
        say(f"{label}: {curve.numbers().peak_force:.6g} N")
        u, f = curve.envelope()
        found.computed.append((f"{label.partition('_')[0]} joint{points}", 1e3 * u, 1e-3 * f))
        if joint:
            found.rows += [CaseRow(f"force at {1e3 * way:g} mm{points}", "N", exact(way), None, at(curve, way)) for way in WAYS]
    ways = np.geomspace(2e-5, 1.02e-2, 200)
    found.measured.append(("closed form", 1e3 * ways, np.array([1e-3 * exact(way) for way in ways])))
    return found


CASE = LaboratoryCase(
    "bed",
    "A joint's bed in closed form",
    "exact: W (B/2 - c/3) - W (H/2) theta = F h, with c = sqrt(2 W / (k_n theta)) once the bed opens",
    "block 0.5 x 1 x 2 m of 60 kN on one joint of 2e10 N/m3, pushed at 1.998 m; friction 5, so that it does not slide",
    "nothing",
    "A joint is as many springs as it has contact points. How the force goes from the closed to the open joint shows how well they stand "
    "for a bed: nine over its depth, the default, are within a few per cent, three (`joint_points = 3`) are up to a quarter too strong "
    "once it opens.",
    compute,
)
