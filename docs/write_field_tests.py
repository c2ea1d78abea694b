# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/field_tests.md and its picture: bridges and bare arches that were loaded to collapse, by limit analysis.

python docs/write_field_tests.py
"""

from __future__ import annotations

from itertools import product
from pathlib import Path

from masonry_cd.studies.laboratory.field_tests import (
    ARCHES,
    MISSING,
    PRESTWOOD,
    TESTS,
    WITHIN,
    FieldTest,
    band,
    collapse,
    of_arch,
    tension_of,
)

PAGE = Path(__file__).parent / "field_tests.md"
PICTURE = PAGE.with_suffix(".png")
SPREADS = ("2:1", "boussinesq")
SHARES = (("none", 0.0), ("1/3 K_p (the default)", 1.0 / 3.0), ("2/3 K_p", 2.0 / 3.0), ("K_p", 1.0))
ANGLES = (30.0, 37.0)
VARIED = (
    ("as above, a third of K_p at 30 degrees", ()),
    ("width 3.6 m", ("structure.width=3.6",)),
    ("fill of 1,800 kg/m3", ("structure.fill.density=1800.0",)),
    ("masonry of 2,000 kg/m3", ("material.density=2000.0",)),
    ("19 voussoirs", ("structure.spans[0].voussoirs=19",)),
    ("73 voussoirs", ("structure.spans[0].voussoirs=73",)),
    ("friction 0.4", ("material.friction=0.4",)),
    ("crushing at 4.5 MPa", ("material.joints={compressive_strength=4.5e6}",)),
)
HEAD = """# Bridges loaded to collapse

Nothing is tuned to a test: values are those of a source, defaults, or stated. The page is written by `python docs/write_field_tests.py`.

## The tests

"""
FOUND = """
`-` stands for what no public source was found to say; the full reports were not read. A bridge without rise, thickness, cover or width
cannot be computed, and none of these is guessed. With them a line in `masonry_cd/studies/laboratory/field_tests.py` puts it among those
computed here. Not in the table, as less still was found: {missing}.

"""
COMPUTED = """## {name}

A single span over a canal, loaded until it fell: a segmental ring of brick, distorted and without parapets, under a line of load 300 mm
long over the whole width at a quarter of the span. It carried **{measured:g} kN** and gave way by four hinges. Rise, thickness, width,
densities and angle of friction are those of the second source, which computed 245 kN with a cohesion of 5 kPa in the fill; the cover is as
the test is commonly quoted, without a source that was read. Assumed: friction 0.6, rigid abutments, no crushing, no tension, no cohesion,
fill at rest as [Model a bridge](howto/bridges.md#fill) says, the shape as designed. `masonry-cd validate arch_bridge` computes the last
column but one.

Loads at collapse [kN], over the measured one in brackets, in bold within 20 %:

"""
BARE = """
## Bare arches in laboratories

Arches without fill under a load at a place of their span. Computed as dry: friction 0.6, no tension, the density of solid brick by table
C8.5.I of Circolare 7/2019 where the source has none; in brackets over the measured load. The last column is the tension of all joints at
once with which limit analysis bears what was measured.

"""
BARE_SAYS = """
Measured loads lie **above** what is computed for all of them: these arches bear by the tension of their mortar, as light rings without
fill have hardly any thrust to close their joints, the thinner the less. They are no tests of a dry arch, nor is a bridge to be computed
with such tension: weight grows with size, tension does not, and a ring under traffic is cracked. The authors of U_A and U_V computed 1.73
and 0.26 kN without tension; the weight that they took is not in the record.

![Computed over measured, with the band of what is assumed](field_tests.png)
"""
TAIL = """
## What can be said

- **Weight and spreading alone** bear half of what was measured: limit analysis without resisting fill leaves out what a bridge has, and is
  still no lower bound, as it leaves out crushing and what has decayed as well.
- **A third of K_p**, the default, brings two thirds. This is one bridge, thin and shallow, and no proof that a default is safe: under a
  thick ring that is taken not to crush, or a deep arch that leans on its fill, it may lie above what the bridge bears. So
  `masonry-cd limit` shows [what a factor rests on](howto/bridges.md#what-a-factor-rests-on), and its verdict takes no default that helps.
- The two ways of spreading differ by a few per cent under so thin a cover.
- Four hinges are found in every row of the second table, as in the test.
- What is left out helps the bridge or hurts it: cohesion and stiffness of a road, friction of fill on masonry and the tension of mortar
  would raise the load, the distorted shape would lower it.
"""


def cell(load: float, test: FieldTest) -> str:
    """A load, in bold within 20 % of the measured one."""
    text = f"{load:.0f} ({load / test.measured:.2f})"
    return f"**{text}**" if abs(load / test.measured - 1.0) <= WITHIN else text


def known(value: float | None) -> str:
    """A number, or that there is none."""
    return "-" if value is None else f"{value:g}"


def tests() -> list[str]:
    """The table of all tests, and their sources below it."""
    sources = list(dict.fromkeys(source for test in TESTS for source in test.sources))
    lines = [
        "| bridge | built | span, rise, ring, cover, width [m] | skew | line at | carried [kN] | gave way | sources |",
        "|---" * 8 + "|",
    ]
    for test in TESTS:
        measures = ", ".join(known(value) for value in (test.span, test.rise, test.thickness, test.cover, test.width))
        numbers = ", ".join(str(sources.index(source) + 1) for source in test.sources)
        cells = (test.name, test.built, measures, f"{test.skew:g}", test.place, f"{test.measured:,.0f}", test.gave_way, numbers)
        lines.append(f"| {' | '.join(cells)} |")
    return [*lines, "", *(f"{number}. {source}." for number, source in enumerate(sources, start=1))]


def of_test(test: FieldTest) -> list[str]:
    """The loads at collapse of a test, by what is assumed of its fill, and what else is worth how much."""
    columns = list(product(SPREADS, ANGLES))
    lines = ["| passive share | " + " | ".join(f"{spread}, phi = {angle:g}" for spread, angle in columns) + " |", "|---" * 5 + "|"]
    for name, share in SHARES:
        asked = f"structure.fill.passive={share}"
        loads = [collapse(test, asked, f'structure.fill.spread="{s}"', f"structure.fill.friction_angle={a}")[0] for s, a in columns]
        lines.append(f"| {name} | " + " | ".join(cell(load, test) for load in loads) + " |")
    lines += ["", "What the other assumptions are worth:", "", "| changed | load [kN] | hinges |", "|---|---|---|"]
    for name, changes in VARIED:
        load, hinges = collapse(test, *changes)
        lines.append(f"| {name} | {cell(load, test)} | {hinges} |")
    return lines


def of_band(test: FieldTest) -> list[str]:
    """The loads at collapse of a test with nothing stated of fill and strength, and where the measured one lies among them."""
    found = band(test)
    assert found.range is not None and found.decides is not None and found.decides.factor is not None
    low, high = found.range
    where = "below" if test.measured < low else "above" if test.measured > high else "within"
    return [
        "", "What `masonry-cd limit` says of the scene, which states neither how its fill resists nor how strong it is:", "",
        "| assumed | load [kN] |", "|---|---|", *(f"| {row.words} | {cell(row.factor or 0.0, test)} |" for row in found.rows), "",
        f"The measured load lies **{where}** this band, {low:.0f} to {high:.0f} kN; the verdict takes {found.decides.factor:.0f} kN.",
    ]  # fmt: skip


def bare() -> list[str]:
    """The table of bare arches, and their sources below it."""
    sources = list(dict.fromkeys(source for test in ARCHES for source in test.sources))
    heads = (
        "| arch | built | span, rise, ring, width [m] | load at [m] | measured [kN] | computed [kN] | crushing | tension [MPa] | source |"
    )
    lines = [heads, "|---" * 9 + "|"]
    for test in ARCHES:
        dry, crushed = of_arch(test), of_arch(test, compressive_strength=test.strength)
        measures = f"{test.span:g}, {test.rise:g}, {test.thickness:g}, {test.width:g}"
        cells = [test.name, test.built, measures, f"{test.place:g}", f"{test.measured:g}"]
        cells += [f"{load:.3g} ({load / test.measured:.2g})" for load in (dry, crushed)]
        cells += [f"{1e-6 * tension_of(test):.2g}", str(sources.index(test.sources[0]) + 1)]
        lines.append(f"| {' | '.join(cells)} |")
    return [*lines, "", *(f"{number}. {source}." for number, source in enumerate(sources, start=1))]


def draw() -> None:
    """Draw computed over measured loads, from the least to the largest of the band of each test."""
    from masonry_cd.foundation.figures import blank

    found = band(PRESTWOOD)
    assert found.range is not None and found.rows[0].factor is not None
    bands = [(PRESTWOOD.name, *found.range, found.rows[0].factor, PRESTWOOD.measured)]
    for test in ARCHES:
        dry = of_arch(test)
        bands.append((test.name, of_arch(test, compressive_strength=test.strength), dry, dry, test.measured))
    figure = blank((8.0, 3.2))
    axes = figure.add_subplot()
    for k, (_, low, high, own, measured) in enumerate(reversed(bands)):
        axes.plot([low / measured, high / measured], [k, k], color="#8a6d3b", linewidth=6.0, solid_capstyle="butt")
        axes.plot([own / measured], [k], "o", color="black", markersize=5.0)
    axes.axvline(1.0, color="#b03030", linewidth=1.0)
    axes.set_yticks(range(len(bands)), [name for name, *_ in reversed(bands)])
    axes.set_xscale("log")
    axes.set_xlabel("load at collapse, computed over measured: band of what is assumed, dot as computed by default")
    figure.tight_layout()
    figure.savefig(PICTURE)


def page() -> str:
    """The text of the page."""
    return (
        HEAD + "\n".join(tests()) + "\n" + FOUND.format(missing=", ".join(MISSING))
        + COMPUTED.format(name=PRESTWOOD.name, measured=PRESTWOOD.measured)
        + "\n".join([*of_test(PRESTWOOD), *of_band(PRESTWOOD)]) + "\n" + BARE + "\n".join(bare()) + "\n" + BARE_SAYS + TAIL
    )  # fmt: skip


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    draw()
