# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/field_tests.md: a bridge that was loaded to collapse, by limit analysis under several assumptions on its fill.

python docs/write_field_tests.py
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

from masonry_cd.app.limit_case import case_of
from masonry_cd.app.scene import parse_scene

PAGE = Path(__file__).parent / "field_tests.md"
MEASURED = 228.0  # [kN]
WITHIN = 0.2
SCENE = """title = "Prestwood"
[structure]
kind = "bridge"
width = 3.8
cover = 0.165
[[structure.spans]]
span = 6.55
rise = 1.428
thickness = 0.22
voussoirs = 37
[structure.fill]
density = 2000.0
friction_angle = 30.0
[material]
density = 2000.0
friction = 0.6
[[loads]]
kind = "vehicle"
axles = [1e3]
across = "line"
contact = [0.3, 0.3]
position = 1.6375
[limit]
live = [0]
starts = 1
"""
SPREADS = ("2:1", "boussinesq")
SHARES = (("none", 0.0), ("1/3 K_p (the default)", 1.0 / 3.0), ("2/3 K_p", 2.0 / 3.0), ("K_p", 1.0))
ANGLES = (30.0, 37.0)
VARIED = (
    ("as above, a third of K_p at 30 degrees", ()),
    ("width 3.6 m", ("structure.width=3.6",)),
    ("fill of 1,800 kg/m3", ("structure.fill.density=1800.0",)),
    ("fill of 2,200 kg/m3", ("structure.fill.density=2200.0",)),
    ("masonry of 1,800 kg/m3", ("material.density=1800.0",)),
    ("19 voussoirs", ("structure.spans=[{span=6.55,rise=1.428,thickness=0.22,voussoirs=19}]",)),
    ("73 voussoirs", ("structure.spans=[{span=6.55,rise=1.428,thickness=0.22,voussoirs=73}]",)),
    ("friction 0.4", ("material.friction=0.4",)),
)
HEAD = """# Bridges loaded to collapse

Nothing is tuned to a test: all values are defaults, or stated. The page is written by `python docs/write_field_tests.py`.

## Prestwood

A single span over a canal, loaded until it fell (J. Page, TRRL Research Report 110, 1987): a segmental ring of brick, 220 mm thick,
span 6.55 m, rise 1.428 m, 165 mm of fill over the crown, width 3.6 to 3.8 m, distorted and without parapets; a line of load 300 mm long
over the whole width at a quarter of the span. It carried **228 kN** and gave way by four hinges. These figures are as later papers
quote them, and as the report's public abstract has them. Assumed: 2,000 kg/m3 for masonry and fill, friction 0.6, rigid abutments, no
crushing, no tension, fill at rest as [Model a bridge](howto/bridges.md#fill) says, the shape as designed.

Loads at collapse [kN], over the measured one in brackets:

"""
TAIL = """
## What can be said

- **Weight and spreading alone** bear about half of what was measured. That is no fault of the method: limit analysis without resisting
  fill is the conservative end of practice.
- **A third of K_p**, the default, brings two thirds: still on the safe side, not within 20 %. More than that needs either an angle of
  friction that a compacted fill has, or a larger share   of it. The table marks in bold what comes within 20 %.
- The two ways of spreading differ by a few per cent under so thin a cover.
- Four hinges are found in every row of the second table, as in the test.
- What is left out helps the bridge or hurts it: cohesion and stiffness of a road, friction of fill on masonry and the tension of mortar
  would raise the load, the distorted shape would   lower it.

## Other tests

Of four more bridges of the same series the public abstracts (TRRL Research Reports 159 and 201) have spans and loads: Torksey, three
rings of brick, 4.90 m, 1,080 kN, where three hinges snapped through; Shinafoot, rubble, 6.16 m, 2,524 kN, four hinges; Strathmashie,
rubble, 9.42 m, 1,325 kN; Barlae, ashlar, 8.53 m square, skew of 29 degrees, 2,900 kN. Rise, thickness, cover and width were not found
in a public source, so they are not computed here: with them, `kind = "bridge"` and `across = "line"` make each a scene of thirty lines.
"""


def factor(*changes: str) -> tuple[float, int]:
    """The load at collapse [kN] of the scene with changes, and how many joints hinge."""
    case = case_of(parse_scene(SCENE, Path("prestwood.toml"), list(changes)))
    return case.analysis.governing.factor, case.collapse.mechanism.count("hinge")


def cell(load: float) -> str:
    """A load, in bold within 20 % of the measured one."""
    text = f"{load:.0f} ({load / MEASURED:.2f})"
    return f"**{text}**" if abs(load / MEASURED - 1.0) <= WITHIN else text


def page() -> str:
    """The text of the page."""
    columns = list(product(SPREADS, ANGLES))
    lines = ["| passive share | " + " | ".join(f"{spread}, phi = {angle:g}" for spread, angle in columns) + " |", "|---" * 5 + "|"]
    for name, share in SHARES:
        loads = [
            factor(f'structure.fill.spread="{spread}"', f"structure.fill.friction_angle={angle}", f"structure.fill.passive={share}")[0]
            for spread, angle in columns
        ]
        lines.append(f"| {name} | " + " | ".join(map(cell, loads)) + " |")
    lines += ["", "What the other assumptions are worth:", "", "| changed | load [kN] | hinges |", "|---|---|---|"]
    for name, changes in VARIED:
        load, hinges = factor(*changes)
        lines.append(f"| {name} | {cell(load)} | {hinges} |")
    return HEAD + "\n".join(lines) + "\n" + TAIL


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
