# SPDX-License-Identifier: GPL-3.0-or-later
"""limit.html, a limit analysis on one page, and macro_elements.html with its table, the mechanisms of the parts of a structure."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from masonry_cd.analysis.limit.outcome import SURE, on_the_check
from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import force
from reports.page.document import Badge, Head, pictures, rows_of, write_document
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
    """Write the page, with those PNGs that are there."""
    summary = page.summary
    block, check = rows_of(page.report, f"masonry_cd {summary['version']}", page.scene), summary["check"] or {}
    made = summary["certificate"]
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
        certificate=[[name, number(made[key]), words] for key, (name, words) in CERTIFICATE.items()] if made else [],
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
            number(one["acceleration"], "m/s²"), number(one["height"], "m", digits=3),
            f"e* = 1 is taken: {one['doubt']}" if one["doubt"] else "",
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


CSV, PAGE, JSON, PICTURES = "macro_elements.csv", "macro_elements.html", "macro_elements.json", "macro_elements"
COLUMNS = (
    "element", "kind", "push", "mechanism", "found", "height", "moving_blocks", "alpha0", "fraction", "acceleration", "demand", "ratio",
    "state", "doubt", "undecided", "check", "last", "displacement", "displacement_demand", "displacement_ratio", "no_displacement",
)  # fmt: skip
HEADS = COLUMNS[:5] + (
    "height_m", "moving_blocks", "alpha0", "e_star", "a0_m_s2", "demand_m_s2", "ratio", "verdict", "e_star_is_one", "why", "check", "d0_m",
    "displacement_m", "displacement_demand_m", "displacement_ratio", "no_check_by_displacements",
)  # fmt: skip


@dataclass(frozen=True)
class MacroPage:
    """What the page shows."""

    summary: Mapping[str, Any]  # macro_elements.json
    least: Sequence[Mapping[str, Any]]  # the first row of each part and push
    held: Sequence[str]  # parts that are held
    scene: str  # its text
    command: str
    report: Mapping[str, Any]  # the scene's table [report]
    damage: Mapping[str, str] = field(default_factory=dict)  # of the groups of each part in a run, by its name


def write_macro_csv(rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Write all mechanisms, the least ratio first."""
    write_csv(path, HEADS, ([row[name] for name in COLUMNS] for row in rows), digits=6)


def write_macro_page(page: MacroPage, drawn: Mapping[Path, str], path: Path) -> None:
    """Write the page; ``drawn`` are PNGs with what each shows."""
    summary, least = page.summary, page.least
    block = rows_of(page.report, f"masonry_cd {summary['version']}", page.scene)
    rows = [_row(page, row) for row in least]
    columns = [*rows[0]] if rows else []
    write_document(
        path,
        "macro_elements.html",
        title=summary["title"],
        page=Head(summary["title"], summary["lines"][:1], doubts(summary), _tiles(summary, page), block, on_the_check(summary["verdict"])),
        csv=CSV,
        columns=columns,
        rows=rows,
        numbers=range(3, columns.index("verdict") if "verdict" in columns else len(columns) - bool(page.damage)),
        any_doubt=any(row["doubt"] for row in least),
        by_displacements=any(row["check"] == "non-linear" for row in least),
        followed=_followed(page),
        why_not=[*dict.fromkeys(row["no_displacement"] for row in least if row["no_displacement"])],
        held=page.held,
        undecided=[*dict.fromkeys(row["undecided"] for row in least if row["undecided"])],
        left_open=summary["left_open"],
        modelled=summary["modelled"],
        drawn=pictures(drawn),
        command=page.command,
        scene=page.scene,
    )


def _checked(page: MacroPage) -> bool:
    """Whether a check by a code was asked for."""
    return bool(page.least) and page.least[0]["ratio"] is not None


def _tiles(summary: Mapping[str, Any], page: MacroPage) -> list[tuple[str, object, str]]:
    """The headline numbers."""
    out: list[tuple[str, object, str]] = [("verdict", summary["verdict"]["state"], "")] if summary["verdict"] else []
    out += [("macro-elements", summary["elements"], ""), ("mechanisms looked at", len(summary["mechanisms"]), "")]
    if _checked(page):
        out.append(("least ratio, borne over asked for", number(page.least[0]["ratio"], digits=3), ""))
    return out


def _followed(page: MacroPage) -> bool:
    """Whether a mechanism of the table has its check by displacements."""
    return any(row["displacement"] is not None for row in page.least)


def _row(page: MacroPage, row: Mapping[str, Any]) -> dict[str, str | Badge]:
    """The least mechanism of a part and push, by the columns of the table."""
    cells: dict[str, str | Badge] = {
        "part": row["element"],
        "push": row["push"],
        "mechanism": row["mechanism"],
        "held at [m]": _aligned(row["height"]),
        "α0": _aligned(row["alpha0"], 4),
        "e*": _aligned(row["fraction"]) + ("¹" if row["doubt"] else ""),
        "a0* [m/s²]": _aligned(row["acceleration"], 4),
    }
    if _checked(page):
        cells["asked for [m/s²]"] = _aligned(row["demand"], 4)
        if _followed(page):
            for name, key in (("d0* [mm]", "last"), ("borne [mm]", "displacement"), ("asked for [mm]", "displacement_demand")):
                cells[name] = "–" if row[key] is None else number(1e3 * row[key], digits=3)
        cells["ratio"] = _aligned(row["ratio"]) + ("²" if row["check"] == "non-linear" else "")
        cells["verdict"] = Badge(f"verdict {VERDICTS[row['state']]}", row["state"])
    return cells | ({"damage in the run": page.damage.get(row["element"], "")} if page.damage else {})


def _aligned(value: float, digits: int = 3) -> str:
    """A number of a column, with the zeros at its end that keep digits below digits."""
    return f"{value:#.{digits}g}".rstrip(".") if 1e-3 <= abs(value) < 1e3 else number(value, digits=digits)


def damage_by_group(folder: Path) -> dict[str, str]:
    """Grade and mechanism of each part of a run, from its damage.csv.

    Raises:
        InputError: the folder has no such file.
    """
    path = folder / "damage.csv"
    if not path.exists():
        raise InputError("--run", f"{folder} has no damage.csv; masonry-cd report {folder} writes it where [report] damage = true")
    with path.open(newline="", encoding="utf-8") as file:
        return {row["part"]: " ".join(filter(None, (row.get("grade", ""), row.get("mechanism", "")))) for row in csv.DictReader(file)}
