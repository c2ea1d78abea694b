# SPDX-License-Identifier: GPL-3.0-or-later
"""limit.html, a limit analysis on one page: verdict, mechanisms of the whole and of its parts, code check, pictures, certificate."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from masonry_cd.analysis.limit.outcome import STATES_OF_CHECKS
from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import force
from reports.page.document import Badge, Head, pictures, rows_of, write_document
from reports.page.words import number

CAPTIONS = {
    "mechanism.png": "How the structure fails: blocks that move, joints that are hinges, slide or open; thin lines: the structure as "
    "built. The displacements are scaled for the picture; only their ratios are computed.",
    "thrust.png": "The forces at collapse: the line passes through each joint where the resultant crosses it, and its width shows the "
    "force. In parts that do not move, the forces are one of many sets that balance the loads.",
    "spectrum.png": "The demand of the code check, on the ground and at the height of the governing mechanism, and its capacity.",
    "capacity.png": "The load factor as the mechanism proceeds, as far as it was followed; below, the structure at the marked points.",
}
NAMED = 40  # blocks at most that are listed
CERTIFICATE = {
    "static": (
        "Static value",
        "load that the computed forces balance: a lower bound of the associated factor, where the residuals of forces are zero",
    ),
    "kinematic": ("Kinematic value", "load that the computed mechanism cannot resist: an upper bound of the factor"),
    "gap": ("Gap", "difference of the two: how precisely the associated factor is known"),
    "equilibrium": ("Equilibrium", "largest unbalanced force on a block, over the mean weight of a block"),
    "friction": ("Strength", "largest force in excess of friction or bond strength, over the mean weight of a block"),
    "flow": ("Flow rule", "largest closing velocity of a joint that must not close, over the largest velocity"),
}
STATES = {"hinge": "hinges", "slide": "slide", "hinge_and_slide": "hinge and slide", "open": "open"}


@dataclass(frozen=True)
class LimitPage:
    """The contents of the page."""

    summary: Mapping[str, Any]  # limit.json
    lines: Sequence[str]  # what was found; the first says of what
    scene: str  # its text
    options: Sequence[str]  # of the command, in addition to what the scene asks for
    report: Mapping[str, Any]  # the scene's table [report]
    damage: Mapping[str, str] = field(default_factory=dict)  # of the groups of each part in a run, by its name


def write_limit_page(page: LimitPage, drawn: Mapping[Path, str], path: Path) -> None:
    """Write the page; ``drawn`` are PNGs with what each shows, those of the whole without words."""
    summary = page.summary
    block, check = rows_of(page.report, f"masonry_cd {summary['version']}", page.scene), summary["check"] or {}
    made, verdict, least = summary.get("certificate"), summary["on_the_whole"], _least(summary["mechanisms"])
    rows = [_row(row, page.damage, any(each["state"] for each in least)) for row in least]
    columns = [*rows[0]] if rows else []
    write_document(
        path,
        "limit.html",
        title=summary["title"],
        page=Head(
            summary["title"], page.lines, summary["notes"], _numbers(summary), block, None if verdict is None else Verdict(**verdict)
        ),
        summary=summary,
        verdicts=STATES_OF_CHECKS,
        states=STATES,
        named=NAMED,
        looked=_looked(check["basis"]) if check else [],
        steps=_steps(check) if check else [],
        columns=columns,
        rows=rows,
        numbers=range(3, columns.index("verdict") if "verdict" in columns else len(columns) - bool(page.damage)),
        notes=_notes(summary, least),
        held=[f"{part['element']} {part['push']}" for part in summary["parts"] if part["held"]],
        drawn=pictures({path: words or CAPTIONS[path.name] for path, words in drawn.items() if path.exists()}),
        ties=_ties(summary),
        assumed=_assumed(summary["assumed"]),
        rated=_rated(summary["rating"]),
        in_service=_in_service(summary["service"]),
        certificate=[[name, number(made[key]), words] for key, (name, words) in CERTIFICATE.items()] if made else [],
        command=" ".join(["masonry-cd limit scene.toml -o out", *page.options]),
        scene=page.scene,
    )


def _numbers(summary: Mapping[str, Any]) -> list[tuple[str, object, str]]:
    """The headline numbers."""
    out = _numbers_of_the_whole(summary) if "stands" in summary else []
    if summary["parts"]:
        out.append(("macro-elements", len({part["element"] for part in summary["parts"]}), ""))
    out.append(("mechanisms examined", len(summary["mechanisms"]), ""))
    for one in (summary["check"] or {}).get("verdicts", []):
        out.append((f"{one['check']} check, {one['state']}: capacity over demand", number(one["ratio"], digits=3), ""))
    if (rating := summary["rating"]) is not None:
        out.append((f"heaviest level of CS 454 with a load factor of {rating['asked']:g}", rating["level"] or "none", ""))
    if (risk := (summary["check"] or {}).get("risk")) and risk["risk_class"]:
        out.append(("class of seismic risk", risk["risk_class"], ""))
    return out


def _numbers_of_the_whole(summary: Mapping[str, Any]) -> list[tuple[str, object, str]]:
    """The headline numbers of the whole."""
    out: list[tuple[str, object, str]] = [("stands under its dead loads", "yes" if summary["stands"] else "no", "")]
    if summary["bears_nothing"]:
        out.append(("load factor", "none", ""))
    elif summary["no_finite_factor"]:
        out.append(("load factor", "not finite", ""))
    elif summary.get("associated") is not None:
        out.append(("load factor (upper bound)", number(summary["associated"]), ""))
    if summary.get("least") and not summary["bears_nothing"]:
        out.append(("least factor found without dilation", number(summary["least"]["factor"]), ""))
    return [*out, ("blocks that move", len(summary["mechanism"]["moving_blocks"]), f" of {summary['blocks']}")]


def _looked(basis: Mapping[str, Any]) -> list[list[str]]:
    """The mechanisms examined, the one that is checked first."""
    return [
        [
            one["found"], f"{one['moving_blocks']:,}", number(one["alpha0"]), number(one["fraction"], digits=3),
            number(one["acceleration"], "m/s²"), number(one["height"], "m", digits=3),
            f"e* = 1 is used: {one['doubt']}" if one["doubt"] else "",
        ]
        for one in basis["looked"]
    ]  # fmt: skip


def _steps(check: Mapping[str, Any]) -> list[list[str]]:
    """The values of a check in their order, those that follow from others with the formula and its numbers."""
    return [[step["symbol"], _value(step), step["line"].partition(" = ")[2], step["clause"], step["meaning"]] for step in check["steps"]]


def _value(step: Mapping[str, Any]) -> str:
    """Four digits and the unit; weights and masses in full."""
    value = step["value"]
    return f"{value:,.0f} {step['unit']}" if abs(value) >= 1e4 else number(value, step["unit"].replace("s2", "s²"))


def _assumed(assumed: Mapping[str, Any]) -> list[list[str]]:
    """The load factors of a bridge under other assumptions; none of anything else."""
    return [
        [
            row["words"], row["why"] if row["factor"] is None else _aligned(row["factor"], 4) if row["factor"] else "does not stand",
            "" if row["position"] is None else f"{row['position']:.4g}", row["key"],
        ]
        for row in (assumed["rows"] if assumed["range"] else ())
    ]  # fmt: skip


def _rated(rating: Mapping[str, Any] | None) -> list[list[str]]:
    """The vehicles of a load rating."""
    rows = []
    for row in () if rating is None else rating["rows"]:
        axles = ", ".join(f"{1e-3 * load:.4g}" for load in row["axles"])
        if row["axle_load_n"] is None:
            rows.append([row["vehicle"], axles, "–", "–", "–", "–", "–", "–", "", row["why"]])
            continue
        found = ["–" if row["computed"] is None else _aligned(row["computed"]), _aligned(row["factor"]), _aligned(row["ratio"])]
        borne = [_aligned(1e-3 * row["axle_load_n"]), _aligned(row["axle_load_t"])]
        place = "–" if row["position"] is None else f"{row['position']:.4g}"
        rows.append([row["vehicle"], axles, *found, *borne, place, ", ".join(row["gives_way"]), row["decides"]])
    return rows


def _in_service(service: Mapping[str, Any] | None) -> list[list[str | Badge]]:
    """The checks in service."""
    return [
        [
            row["words"], "not met under dead loads" if row["factor"] is None and not row["met"] else _factor(row["factor"]),
            f"{row['asked']:g}", "–" if row["position"] is None else f"{row['position']:.4g}",
            Badge(f"verdict {STATES_OF_CHECKS['satisfied' if row['met'] else 'NOT satisfied']}", "met" if row["met"] else "not met"),
        ]
        for row in (() if service is None else service["rows"])
    ]  # fmt: skip


def _factor(factor: float | None) -> str:
    return "any" if factor is None else _aligned(factor)


def _ties(summary: Mapping[str, Any]) -> list[list[str]]:
    """The tensions of the ties at collapse."""
    return [
        [
            tie["tie"], f"{tie['block_a']} to {tie['block_b']}", force(tie["tension_n"]),
            "never" if tie["yield_force_n"] is None else force(tie["yield_force_n"]), "yes" if tie["yields"] else "no",
        ]
        for tie in summary.get("ties", ())
    ]  # fmt: skip


def _least(rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The governing mechanism of each part and push, the first in the table."""
    first: dict[tuple[str, str], Mapping[str, Any]] = {}
    for row in rows:
        first.setdefault((row["element"], row["push"]), row)
    return list(first.values())


def _notes(summary: Mapping[str, Any], least: Sequence[Mapping[str, Any]]) -> list[str]:
    """Notes on the table of mechanisms, a sentence or two each."""
    out = []
    if any(row["doubt"] for row in least):
        out.append("¹ e* = 1 is used, on the safe side: the mechanism dilates, spreads, or moves much mass that does not participate.")
    if any(row["check"] == "non-linear" for row in least):
        out.append("² The displacement check governs; elsewhere the acceleration check does.")
    if any(row["displacement"] is not None for row in least):
        by = " or a ".join(dict.fromkeys(row["last_by"] for row in least if row["last_by"]))
        out.append(f"d0* is the displacement of a {by}, followed until the factor vanishes: column d0_by of mechanisms.csv.")
        out.append("The friction of interlock counts in α0 but not in d0*, because it does not last until collapse (C8.7.1.2.1.6).")
    if why_not := [*dict.fromkeys(row["no_displacement"] for row in least if row["no_displacement"])]:
        out.append(f"No displacement check: {'; '.join(why_not)}.")
    if undecided := [*dict.fromkeys(row["undecided"] for row in least if row["undecided"])]:
        out.append(f"Undecided mechanisms: {'; '.join(undecided)}.")
    return out + [f"Left open by the clauses: {one}." for one in summary["left_open"]]


def _row(row: Mapping[str, Any], damage: Mapping[str, str], checked: bool) -> dict[str, str | Badge]:
    """A mechanism by the columns of the table, with those of a check or not; ``damage`` of a run by the names of parts."""
    cells: dict[str, str | Badge] = {
        "part": row["element"],
        "push": row["push"],
        "mechanism": row["mechanism"],
        "held at [m]": _aligned(row["height"]),
        "α0": _aligned(row["alpha0"], 4),
        "e*": _aligned(row["fraction"]) + ("¹" if row["doubt"] else ""),
        "a0* [m/s²]": _aligned(row["acceleration"], 4),
    }
    if checked:
        cells["required [m/s²]"] = "–" if row["demand"] is None else _aligned(row["demand"], 4)
        for name, key in (("d0* [mm]", "last"), ("borne [mm]", "displacement"), ("required [mm]", "displacement_demand")):
            cells[name] = "–" if row[key] is None else number(1e3 * row[key], digits=3)
        cells["ratio"] = "–" if row["ratio"] is None else _aligned(row["ratio"]) + ("²" if row["check"] == "non-linear" else "")
        cells["verdict"] = Badge(f"verdict {STATES_OF_CHECKS[row['state']]}", row["state"]) if row["state"] else "–"
    return cells | ({"damage in the run": damage.get(row["element"], "")} if damage else {})


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
        raise InputError("--run", f"{folder} has no damage.csv; set [report] damage = true in its scene and run masonry-cd report {folder}")
    with path.open(newline="", encoding="utf-8") as file:
        return {row["part"]: " ".join(filter(None, (row.get("grade", ""), row.get("mechanism", "")))) for row in csv.DictReader(file)}
