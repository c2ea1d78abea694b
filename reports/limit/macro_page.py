"""macro_elements.csv and macro_elements.html: the mechanisms of the parts of a structure, ranked, with a picture each."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError
from reports.limit.page import VERDICTS
from reports.page.document import header, pictures, plain_style, write_document
from reports.page.findings import section, table
from reports.page.title_block import rows_of
from reports.page.words import escaped, number

CSV, PAGE, JSON, PICTURES = "macro_elements.csv", "macro_elements.html", "macro_elements.json", "macro_elements"
COLUMNS = (
    "element", "kind", "push", "mechanism", "found", "height", "moving_blocks", "alpha0", "fraction", "acceleration", "demand", "ratio",
    "state", "doubt", "undecided", "check", "last", "displacement", "displacement_demand", "displacement_ratio", "no_displacement",
)  # fmt: skip
HEADS = COLUMNS[:5] + (
    "height_m",
    "moving_blocks",
    "alpha0",
    "e_star",
    "a0_m_s2",
    "demand_m_s2",
    "ratio",
    "verdict",
    "e_star_is_one",
    "why",
    "check",
    "d0_m",
    "displacement_m",
    "displacement_demand_m",
    "displacement_ratio",
    "no_check_by_displacements",
)


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
    write_csv(path, HEADS, ([_cell(row[name]) for name in COLUMNS] for row in rows))


def _cell(value: object) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def write_macro_page(page: MacroPage, drawn: Mapping[Path, str], path: Path) -> None:
    """Write the page; ``drawn`` are PNGs with what each shows.

    Raises:
        InputError: it cannot be written.
    """
    summary = page.summary
    block = rows_of(page.report, f"masonry_cd {summary['version']}", page.scene)
    lines = [summary["lines"][0], *([summary["verdict"]["words"]] if summary["verdict"] else [])]
    said = (
        "Each part is free with what rests on it, all else is held; a bonded wall holds it by the friction of its interlock ([C8.7.1.2]), "
        "ties by the force at which they yield. The least mechanism of each part and push, the gravest first; all others are in "
        f"<code>{CSV}</code>. Mechanisms of rigid bodies are those that practice checks by hand; the free least one is found block by "
        "block."
    )
    body = [
        header(summary["title"], lines, summary["notes"], _tiles(summary, page), block),
        "<main>",
        section("parts", "Macro-elements", f"<p>{said}</p>{_table(page)}{_more(summary, page)}"),
        pictures(drawn),
        "</main><footer>",
        section("again", "To compute it again", f'<pre>{escaped(page.command)}</pre><pre tabindex="0">{escaped(page.scene)}</pre>'),
        "</footer>",
    ]
    write_document(path, summary["title"], "".join(body), plain_style())


def _tiles(summary: Mapping[str, Any], page: MacroPage) -> list[tuple[str, object]]:
    """The headline numbers."""
    out: list[tuple[str, object]] = [
        ("macro-elements", str(summary["elements"])),
        ("mechanisms looked at", str(len(summary["mechanisms"]))),
    ]
    if summary["verdict"]:
        out.insert(0, ("verdict", escaped(summary["verdict"]["state"])))
    if page.least and page.least[0]["ratio"] is not None:
        out.append(("least ratio, borne over asked for", number(float(f"{page.least[0]['ratio']:.3g}"))))
    return out


def _table(page: MacroPage) -> str:
    """The least mechanism of each part and push."""
    checked = bool(page.least) and page.least[0]["ratio"] is not None
    heads = ["part", "push", "mechanism", "held at [m]", "α0", "e*", "a0* [m/s²]"]
    followed = any(row["displacement"] is not None for row in page.least)
    heads += ["asked for [m/s²]"] if checked else []
    heads += ["d0* [mm]", "borne [mm]", "asked for [mm]"] if followed else []
    heads += ["ratio", "verdict"] if checked else []
    heads += ["damage in the run"] if page.damage else []
    rows = []
    for row in page.least:
        e_star = number(float(f"{row['fraction']:.3g}")) + ("<sup>1</sup>" if row["doubt"] else "")
        cells = [
            escaped(row["element"]), escaped(row["push"]), escaped(row["mechanism"]), number(float(f"{row['height']:.3g}")),
            number(float(f"{row['alpha0']:.4g}")), e_star, number(float(f"{row['acceleration']:.4g}")),
        ]  # fmt: skip
        if checked:
            state = f'<span class="verdict {VERDICTS[row["state"]]}">{row["state"]}</span>'
            cells.append(number(float(f"{row['demand']:.4g}")))
            cells += [_millimetres(row[name]) for name in ("last", "displacement", "displacement_demand")] if followed else []
            cells += [number(float(f"{row['ratio']:.3g}")) + ("<sup>2</sup>" if row["check"] == "non-linear" else ""), state]
        rows.append(cells + ([escaped(page.damage.get(row["element"], ""))] if page.damage else []))
    return table(heads, rows, tuple(range(3, heads.index("verdict") if checked else 7)))


def _millimetres(value: float | None) -> str:
    return "–" if value is None else number(float(f"{1e3 * value:.3g}"))


def _more(summary: Mapping[str, Any], page: MacroPage) -> str:
    """What stands below the table."""
    out = []
    if any(row["doubt"] for row in page.least):
        out.append("<sup>1</sup> e* = 1 is taken, the safe side: the mechanism dilates, spreads, or moves much that takes no part.")
    if any(row["check"] == "non-linear" for row in page.least):
        out.append("<sup>2</sup> the check by displacements decides; elsewhere that by accelerations.")
    if any(row["displacement"] is not None for row in page.least):
        why_not = dict.fromkeys(row["no_displacement"] for row in page.least if row["no_displacement"])
        last = "The friction of interlock counts in α0 and not in d0*, since it does not last to collapse (C8.7.1.2.1.6)."
        out.append(f"{last} {'No check by displacements: ' + escaped('; '.join(why_not)) + '.' if why_not else ''}")
    if page.held:
        out.append(f"Held, no mechanism below a factor of 5: {escaped(', '.join(page.held))}.")
    why = dict.fromkeys(row["undecided"] for row in page.least if row["undecided"])
    out += [f"Why some are not decided: {escaped('; '.join(why))}."] if why else []
    out += [f"Left open by the clauses: {escaped(one)}." for one in summary["left_open"]]
    return "".join(f'<p class="note">{one}</p>' for one in out)


def damage_by_group(folder: Path) -> dict[str, str]:
    """Grade and mechanism of each part of a run, from its damage.csv.

    Raises:
        InputError: the folder has no such file.
    """
    path = folder / "damage.csv"
    if not path.exists():
        raise InputError(f"--run: {folder} has no damage.csv; masonry-cd report {folder} writes it where [report] damage = true")
    with path.open(newline="", encoding="utf-8") as file:
        return {row["part"]: " ".join(filter(None, (row.get("grade", ""), row.get("mechanism", "")))) for row in csv.DictReader(file)}
