# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls in running bond under a beam that is pushed along their plane, under a constant vertical force: their scenes and limit loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.crack_pattern import Polyline, agreement, cracked, joint_lines
from masonry_cd.analysis.pushover import PushCurve
from masonry_cd.app.run_case import RESULTS
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.studies.laboratory.case import CaseRow, elastic, limit_factor, pushed
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
    strength: float | None = None  # of its masonry in compression, at which joints crush [Pa]; None: never

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
        law |= {"compressive_strength": self.strength} if self.strength else {}
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
        rigid = self.limit_force(folder / name.replace("*", "limit"), title, stress, young if self.strength else None)
        curve = pushed(folder / name.replace("*", "push"), self.blocks(), self.scene(title, stress, young, [reach]))
        most, inertia = 1e-3 * curve.envelope()[1].max(), 100 * curve.inertia_share
        say(f"{title}: limit {1e-3 * rigid:.1f} kN, push {most:.1f} kN, inertia {inertia:.2g} %")
        return rigid, curve

    def limit_force(self, folder: Path, title: str, stress: float, young: float | None = None) -> float:
        """The least horizontal force on the beam by limit analysis, rigid and without dilation where it is found [N]; joints that crush
        are to have an E [Pa], which it takes no account of.
        """
        tables = self.scene(title, stress, young, [0.0])
        tables["loads"] = [tables["loads"][0], {"kind": "point", "block": "beam", "force": [1.0, 0.0, 0.0]}]
        return limit_factor(folder, self.blocks(), tables, [1])


def crack_rows(folder: Path, name: str, maps: Sequence[Sequence[Polyline]], wall: ShearWall, both_ways: bool = False) -> list[CaseRow]:
    """Agreement of the cracks at the end of a push with crack maps of its test: means over the maps, each of 1 at best.

    Args:
        folder: of the run.
        name: of the test.
        maps: lines [m] in the elevation of a wall that is pushed along +x.
        wall: that was pushed.
        both_ways: the test went to and fro, so that the cracks of the push and their mirror image are compared.
    """
    with Results.open(folder / RESULTS) as results:
        computed = joint_lines(results, (1.0, 0.0, 0.0))[cracked(results)]
    if both_ways:
        computed = np.concatenate([computed, computed * [-1.0, 1.0] + [wall.length, 0.0]])
    each = [agreement(computed, drawn, wall.course) for drawn in maps]
    words = f"{name}: {{}} within a course, {len(each)} map{'s' if len(each) > 1 else ''}"
    return [
        CaseRow(words.format("crack length found"), "of 1", 1.0, None, float(np.mean([one.found for one in each]))),
        CaseRow(words.format("computed crack length that is drawn"), "of 1", 1.0, None, float(np.mean([1.0 - one.false for one in each]))),
    ]
