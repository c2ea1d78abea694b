# SPDX-License-Identifier: GPL-3.0-or-later
"""Bridges that were loaded to collapse: what was found of them, and the load at collapse of those whose measures are known.

All are computed in one way: a span between rigid abutments under a line of load over its whole width, by limit analysis, with what is not
known of a bridge as every scene has it by default. Nothing is fitted to a test.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from masonry_cd.app.scene import parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.limit.assumed import Assumed
from masonry_cd.limit.case import limit_case

WITHIN = 0.2  # share of the measured load that counts as near
LINE = 0.3  # length of the line of load along the span [m]
KILONEWTON = 1e3  # [N]
FRICTION = 0.6  # assumed of all joints
TURNS, CLOSE = 8, 0.01  # of the search for a tension at most, and how near the load comes

ABSTRACT = "{} of the Transport and Road Research Laboratory, its public abstract"
RR110, RR159, RR201 = (ABSTRACT.format(f"Research Report {number}") for number in (110, 159, 201))
CR155 = ABSTRACT.format("Contractor Report 155")
PADUA = "Simoncello and others, Frontiers in Built Environment 6, 7, 2020, figure 7 and table 4"


class FieldTest(NamedTuple):
    """A test; None is what was not found."""

    name: str
    built: str
    shape: str
    span: float  # clear, square to the springings [m]
    place: str  # of the line of load
    measured: float  # [kN]
    gave_way: str
    sources: tuple[str, ...]
    rise: float | None = None  # [m]
    thickness: float | None = None  # [m]
    cover: float | None = None  # over the crown [m]
    width: float | None = None  # [m]
    skew: float = 0.0  # [degrees]
    densities: tuple[float, float] | None = None  # of masonry and of fill [kg/m3]
    angle: float | None = None  # of friction of the fill [degrees]
    voussoirs: int | None = None

    @property
    def absent(self) -> list[str]:
        """The measures that were not found and without which nothing can be computed."""
        return [name for name in ("rise", "thickness", "cover", "width") if getattr(self, name) is None]


PRESTWOOD = FieldTest(
    "Prestwood", "a ring of brick, distorted, without parapets", "segmental", 6.55, "1/4", 228.0, "four hinges", (RR110, PADUA),
    rise=1.428, thickness=0.22, cover=0.165, width=3.8, densities=(1800.0, 2040.0), angle=30.0, voussoirs=37,
)  # fmt: skip
TESTS: Sequence[FieldTest] = (
    PRESTWOOD,
    FieldTest("Torksey", "three rings of brick, poor", "", 4.90, "1/4", 1080.0, "three hinges, snapped through", (RR159,)),
    FieldTest("Shinafoot", "random rubble", "", 6.16, "1/4", 2524.0, "four hinges", (RR159,)),
    FieldTest("Strathmashie", "rubble, little mortar, cracked along", "", 9.42, "1/4", 1325.0, "not stated", (RR201,)),
    FieldTest("Barlae", "ashlar", "", 8.53, "1/4", 2900.0, "not stated", (RR201,), skew=29.0),
    FieldTest("laboratory arch", "full scale", "semicircular", 4.0, "not stated", 1050.0, "not stated", (CR155,), rise=2.0),
)
MISSING = (  # no public source of their measures was found
    "Preston (sandstone, elliptical, 360 mm thick, loaded at a third of its span, crushed under the line at 2,110 kN; Research Report 110)",
    "Bridgemill",
    "Bargower",
)


class ArchTest(NamedTuple):
    """A bare arch on rigid springings under a load at a place of its span."""

    name: str
    built: str
    span: float  # clear [m]
    rise: float
    thickness: float
    width: float
    voussoirs: int
    place: float  # of the load, from the left springing [m]
    measured: float  # [kN]
    strength: float  # of the masonry in compression [Pa]
    sources: tuple[str, ...]
    density: float = 18e3 / 9.80665  # of solid brick, table C8.5.I of Circolare 7/2019 [kg/m3], where the source has none

    @property
    def point(self) -> tuple[str, float, float]:
        """The voussoir below the load, and where the load meets its extrados, from the middle of the span and the springings [m]."""
        half = 0.5 * self.span
        radius = (half**2 + self.rise**2) / (2.0 * self.rise)
        x, below, opens = self.place - half, radius - self.rise, math.atan2(half, radius - self.rise)
        up = math.sqrt((radius + self.thickness) ** 2 - x**2)
        number = int((math.atan2(x, up) + opens) / (2.0 * opens) * self.voussoirs)
        edges = (opens * (2.0 * k / self.voussoirs - 1.0) for k in (number, number + 1))
        (x0, z0), (x1, z1) = (((radius + self.thickness) * math.sin(a), (radius + self.thickness) * math.cos(a) - below) for a in edges)
        return f"v{number + 1}", x, z0 + (x - x0) / (x1 - x0) * (z1 - z0)


CORPUS = "as transcribed in the public records of arch tests of structural-checks-ts"
MILAN = f"Carozzi and others, Composite Structures 187, 466, 2018, sections 2.1 and 2.3, table 6, {CORPUS}"
MINHO = f"Oliveira and others, Journal of Composites for Construction 14, 312, 2010, and Basilio's thesis, Minho, 2007, table 6.5, {CORPUS}"
ARCHES: Sequence[ArchTest] = (
    ArchTest("arch U_A", "bricks on edge, lime mortar", 3.3, 0.83, 0.12, 0.25, 59, 0.556, 2.08, 3.5e6, (MILAN,)),
    ArchTest("vault U_V", "a leaf of brick, lime mortar", 3.3, 0.83, 0.06, 0.3, 29, 0.556, 0.39, 3.5e6, (MILAN,)),
    ArchTest("arch US-1", "half-scale bricks, cement mortar", 1.467, 0.593, 0.05, 0.45, 59, 0.367, 1.43, 9.1e6, (MINHO,)),
    ArchTest("arch US-2", "half-scale bricks, cement mortar", 1.467, 0.593, 0.05, 0.45, 59, 0.367, 1.92, 9.1e6, (MINHO,)),
    ArchTest(
        "Perugia arch",
        "a row of bricks",
        2.0,
        1.0,
        0.125,
        0.25,
        49,
        1.0,
        0.70,
        6.63e6,
        (f"{PADUA.partition(',')[0]}, 2020, on Borri and others, 2011, {CORPUS}",),
        1807.0,
    ),
)


def of_arch(test: ArchTest, **joints: float) -> float:
    """The load at collapse of a bare arch [kN], its joints with a strength in SI units or as they are by default, without any."""
    block, x, z = test.point
    keys = ("span", "rise", "thickness", "width", "voussoirs")
    scene = {
        "structure": {"kind": "arch"} | {key: getattr(test, key) for key in keys},
        "material": {"density": test.density, "friction": FRICTION, "joints": joints},
        "loads": [{"kind": "point", "block": block, "force": [0.0, 0.0, -KILONEWTON], "point": [x, 0.0, z]}],
        "limit": {"live": [0], "starts": 1},
    }
    whole = limit_case(parse_scene(dump_toml(scene), Path("scene.toml"))).whole
    assert whole is not None
    return whole.analysis.governing.factor


def tension_of(test: ArchTest) -> float:
    """The tensile strength of joints with which a bare arch bears what was measured [Pa], by secants."""
    low, high = (0.0, of_arch(test)), (1e4, 0.0)
    for _ in range(TURNS):
        high = high[0], of_arch(test, cohesion=FRICTION * high[0])
        if abs(high[1] / test.measured - 1.0) < CLOSE:
            break
        low, high = high, (high[0] + (test.measured - high[1]) * (high[0] - low[0]) / (high[1] - low[1]), 0.0)
    return high[0]


def scene_of(test: FieldTest) -> dict[str, Any]:
    """The tables of a test's scene: its factor is the load at collapse in kN."""
    masonry, fill = test.densities or (2000.0, 2000.0)
    span = {"shape": test.shape, "span": test.span, "rise": test.rise, "thickness": test.thickness, "voussoirs": test.voussoirs}
    return {
        "title": test.name,
        "structure": {
            "kind": "bridge", "width": test.width, "cover": test.cover, "skew": test.skew, "spans": [span],
            "fill": {"density": fill, "friction_angle": test.angle or 30.0},
        },
        "material": {"density": masonry, "friction": FRICTION},
        "loads": [{"kind": "vehicle", "axles": [KILONEWTON], "across": "line", "contact": [LINE, LINE], "position": 0.25 * test.span}],
        "limit": {"live": [0], "starts": 1},
    }  # fmt: skip


def band(test: FieldTest) -> Assumed:
    """The loads at collapse of a test [kN] by what a scene does not state: its fill as by default, its strength not known."""
    return limit_case(parse_scene(dump_toml(scene_of(test)), Path("scene.toml"))).assumed


def collapse(test: FieldTest, *changes: str, folder: Path | None = None) -> tuple[float, int]:
    """The load at collapse [kN], and how many joints hinge, of the scene with changes as ``--set`` takes them; it is kept in a folder."""
    scene = parse_scene(dump_toml(scene_of(test)), (folder or Path()) / "scene.toml", list(changes))
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "scene.toml").write_text(scene.text, encoding="utf-8")
    whole = limit_case(scene).whole
    assert whole is not None  # the scene has a live load
    return whole.analysis.governing.factor, whole.collapse.mechanism.count("hinge")
