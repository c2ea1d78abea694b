# SPDX-License-Identifier: GPL-3.0-or-later
"""Bridges that were loaded to collapse: what was found of them, and the load at collapse of those whose measures are known.

All are computed in one way: a span between rigid abutments under a line of load over its whole width, by limit analysis, with what is not
known of a bridge as every scene has it by default. Nothing is fitted to a test.
"""

from __future__ import annotations

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
