# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls in running bond under a beam that is pushed along their plane, under a constant vertical force: their scenes and limit loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.pushover import PushCurve
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.studies.laboratory.case import elastic, limit_factor, pushed
from structures.geometry.prism import box


@dataclass(frozen=True)
class ShearWall:
    """A wall, on a fixed base and under a beam as long as it is, which is pushed at its middle."""

    courses: int
    course: float  # height [m]
    unit: float  # length [m]
    depth: float  # of the beam [m]
    friction: float
    length: float = 1.0  # [m]
    thick: float = 0.2  # [m]
    density: float = 2650.0  # of granite [kg/m3]

    def blocks(self) -> list[Block]:
        """Courses that are shifted by half a unit in turn."""
        blocks = [Block("base", *box((-0.5, -0.3, -0.2), (self.length + 0.5, 0.5, 0.0)), self.density, "base", fixed=True)]
        for course in range(self.courses):
            cuts = np.arange(0.0, self.length + 1e-9, self.unit)
            edges = cuts if course % 2 == 0 else np.concatenate([[0.0], cuts[:-1] + 0.5 * self.unit, [self.length]])
            low, high = self.course * course, self.course * (course + 1)
            for k, (a, b) in enumerate(pairwise(edges.tolist())):
                blocks.append(Block(f"u{course + 1}.{k + 1}", *box((a, 0.0, low), (b, self.thick, high)), self.density, "wall"))
        top = self.course * self.courses
        return [*blocks, Block("beam", *box((0.0, 0.0, top), (self.length, self.thick, top + self.depth)), 2500.0, "beam")]

    def scene(self, title: str, stress: float, young: float | None, targets: Sequence[float]) -> dict[str, Any]:
        """A push through targets [m] under a vertical stress [MPa]; joints of E [Pa] over the height of a course, or rigid ones."""
        force = 1e6 * stress * self.length * self.thick
        stiffness = 0.0 if young is None else young / self.course
        law = {"normal_stiffness": stiffness, "tangential_stiffness": 0.4 * stiffness, "damping": 0.1} if stiffness else {}
        return {
            "title": title,
            "material": {"density": self.density, "friction": self.friction, **elastic(law)},
            "loads": [
                {"kind": "point", "block": "beam", "force": [0.0, 0.0, -force], "ramp": 0.3},
                {
                    "kind": "push", "control": "displacement", "direction": "x", "blocks": "beam", "targets": list(targets),
                    "speed": 0.0125, "start": 0.4,
                },
            ],
            "run": {"dt": 1e-3, "tolerance": 1e-5},
            "quiet_checks": ["loads[0].force"],
        }  # fmt: skip

    def tested(
        self, folder: Path, name: str, title: str, test: tuple[float, float, float], say: Callable[[str], object]
    ) -> tuple[float, PushCurve]:
        """The limit force [N], and the push on elastic joints, of a ``test`` at a stress [MPa], with E [Pa], to a reach [m]."""
        stress, young, reach = test
        rigid = self.limit_force(folder / name.replace("*", "limit"), title, stress)
        curve = pushed(folder / name.replace("*", "push"), self.blocks(), self.scene(title, stress, young, [reach]))
        most, inertia = 1e-3 * curve.envelope()[1].max(), 100 * curve.inertia_share
        say(f"{title}: limit {1e-3 * rigid:.1f} kN, push {most:.1f} kN, inertia {inertia:.2g} %")
        return rigid, curve

    def limit_force(self, folder: Path, title: str, stress: float) -> float:
        """The least horizontal force on the beam by limit analysis, rigid and without dilation where it is found [N]."""
        tables = self.scene(title, stress, None, [0.0])
        tables["loads"] = [tables["loads"][0], {"kind": "point", "block": "beam", "force": [1.0, 0.0, 0.0]}]
        return limit_factor(folder, self.blocks(), tables, [1])
