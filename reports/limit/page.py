# SPDX-License-Identifier: GPL-3.0-or-later
"""limit.html: a limit analysis on one page that needs nothing else: factor, check by a code, pictures, mechanism, certificate, scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_cd.analysis.limit.outcome import SURE
from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.quantities import force
from reports.page.document import Head, pictures, write_document
from reports.page.title_block import rows_of
from reports.page.words import number

CAPTIONS = {
    "mechanism.png": "How the structure gives way: blocks that move, joints that are hinges, slide or open; thin lines: the structure as "
    "built. The size of the displacements is chosen for the eye; only their ratios are computed.",
    "thrust.png": "The forces at collapse: where the resultant crosses each joint, as wide as it is large. Forces in parts that do not "
    "move are one of many sets that balance the loads.",
    "capacity.png": "The load factor while the mechanism goes on, as far as it was followed; below, the structure at the marked points.",
}
NAMED = 40  # blocks at most that are listed
CERTIFICATE = {
    "static": (
        "Static value",
        "what the forces found bear: the associated factor is no less, where the residuals of forces are zero",
    ),
    "kinematic": ("Kinematic value", "the load that the mechanism found cannot resist: no factor is more"),
    "gap": ("Gap", "between the two: how far the associated factor is known"),
    "equilibrium": ("Equilibrium", "largest force that is left over on a block, over the mean weight of a block"),
    "friction": ("Strength", "largest force beyond what friction or a bond allows, over the mean weight of a block"),
    "flow": ("Flow rule", "by how much a joint closes that must not, over the largest velocity"),
}
VERDICTS = {state: sure for state, (sure, _) in SURE.items()}  # how states of a check are coloured
STATES = {"hinge": "hinges", "slide": "slide", "hinge_and_slide": "hinge and slide", "open": "open"}


@dataclass(frozen=True)
class LimitPage:
    """What the page shows."""

    summary: Mapping[str, Any]  # limit.json
    lines: Sequence[str]  # what was found; the first says of what
    scene: str  # its text
    options: Sequence[str]  # of the command, beside what the scene asks for
    report: Mapping[str, Any]  # the scene's table [report]


def write_limit_page(page: LimitPage, drawn: Sequence[Path], path: Path) -> None:
    """Write the page.

    Args:
        page: its contents.
        drawn: PNGs; those that are not there are left out.
        path: of the page.

    Raises:
        InputError: it cannot be written.
    """
    summary = page.summary
    block, check = rows_of(page.report, f"masonry_cd {summary['version']}", page.scene), summary["check"] or {}
    write_document(
        path,
        "limit.html",
        title=summary["title"],
        page=Head(summary["title"], page.lines, doubts(summary), _numbers(summary), block, Verdict(**summary["on_the_whole"])),
        summary=summary,
        verdicts=VERDICTS,
        states=STATES,
        named=NAMED,
        looked=_looked(check["basis"]) if check else [],
        steps=[[step["symbol"], _value(step), step["clause"], step["meaning"]] for step in check.get("steps", ())],
        drawn=pictures({picture: CAPTIONS[picture.name] for picture in drawn if picture.exists()}),
        ties=_ties(summary),
        certificate=_certificate(summary),
        command=" ".join(["masonry-cd limit scene.toml -o out", *page.options]),
        scene=page.scene,
    )


def doubts(summary: Mapping[str, Any]) -> list[str]:
    """What must not be overlooked of the notes: those on what is modelled have a section of their own."""
    return [note for note in summary["notes"] if note not in summary["modelled"]]


def _numbers(summary: Mapping[str, Any]) -> list[tuple[str, object, str]]:
    """The headline numbers."""
    out: list[tuple[str, object, str]] = [("stands under its dead loads", "yes" if summary["stands"] else "no", "")]
    if summary["bears_nothing"]:
        out.append(("load factor", "none", ""))
    elif summary["no_finite_factor"]:
        out.append(("load factor", "not finite", ""))
    elif summary.get("associated") is not None:
        out.append(("load factor, an upper value", number(summary["associated"]), ""))
    if summary.get("least") and not summary["bears_nothing"]:
        out.append(("least factor found without dilation", number(summary["least"]["factor"]), ""))
    out.append(("blocks that move", len(summary["mechanism"]["moving_blocks"]), f" of {summary['blocks']}"))
    if summary["verdict"]:
        out.append(("verdict of the check", summary["verdict"]["state"], ""))
    for one in (summary["check"] or {}).get("verdicts", []):
        out.append((f"{one['check']} check, {one['state']}: borne over asked for", number(one["ratio"], digits=3), ""))
    return out


def _looked(basis: Mapping[str, Any]) -> list[list[str]]:
    """The mechanisms looked at, the one that is checked first."""
    return [
        [
            one["found"], f"{one['moving_blocks']:,}", number(one["alpha0"]), number(one["fraction"], digits=3),
            number(one["acceleration"], "m/s²"), f"e* = 1 is taken: {one['doubt']}" if one["doubt"] else "",
        ]
        for one in basis["looked"]
    ]  # fmt: skip


def _value(step: Mapping[str, Any]) -> str:
    """Four digits and the unit; weights and masses in full."""
    value = step["value"]
    return f"{value:,.0f} {step['unit']}" if abs(value) >= 1e4 else number(value, step["unit"].replace("s2", "s²"))


def _ties(summary: Mapping[str, Any]) -> list[list[str]]:
    """What the ties pull at collapse."""
    return [
        [
            tie["tie"], f"{tie['block_a']} to {tie['block_b']}", force(tie["tension_n"]),
            "never" if tie["yield_force_n"] is None else force(tie["yield_force_n"]), "yes" if tie["yields"] else "no",
        ]
        for tie in summary["ties"]
    ]  # fmt: skip


def _certificate(summary: Mapping[str, Any]) -> list[list[str]]:
    """How good the answer is."""
    made = summary["certificate"]
    return [] if made is None else [[name, number(made[key]), words] for key, (name, words) in CERTIFICATE.items()]
