# SPDX-License-Identifier: GPL-3.0-or-later
"""The risk sheet: hazard, capacity, return period, class and annual frequency on one page, as the structure is and as it is strengthened.

Nothing is computed here. The sheet lays side by side what ``masonry-cd limit`` has written into limit.json, of a scene with [hazard] and
[limit.check], and what ``masonry-cd study`` has written into summary.json, each number with the formula that its step has.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text
from masonry_cd.foundation.json_files import write_json
from masonry_cd.foundation.quantities import per_cent
from reports.page.document import Badge, Head, pictures, rows_of, write_document
from reports.page.words import number
from reports.risk.picture import draw_hazard

LIMIT, STUDY = "limit.json", "summary.json"
PAGE, FACTS, PICTURE = files_of("risk")
OF_THE_SITE = ("hazard", "code", "limit_state")  # of two analyses on one sheet these have to agree
SHOWN = 6  # mechanisms of each analysis
PARTS = ("hazard", "acceleration that is just borne", "risk class")  # of a check, whose formulas the sheet has
COLOURS_OF_STATES = {"satisfied": "good", "NOT satisfied": "doubtful"}
CAPTION = "The hazard of the site on rock: return period over peak acceleration, with the demand of the limit state and the capacity."


@dataclass(frozen=True)
class RiskSheet:
    """Limit analyses and a study of one site."""

    before: Mapping[str, Any]  # limit.json of the structure as it is
    after: Mapping[str, Any] | None = None  # that of the structure as strengthened
    study: Mapping[str, Any] | None = None  # summary.json of a study whose scene has the hazard

    @property
    def columns(self) -> list[tuple[str, Mapping[str, Any]]]:
        """Each analysis with its name."""
        if self.after is None:
            return [("as it is", self.before)]
        return [("as it is", self.before), ("strengthened", self.after)]

    @property
    def rows(self) -> list[tuple[str, list[str], str]]:
        """Rows of a quantity, its value in each column, and its formula."""
        values = [_values(found) for _, found in self.columns]
        return [(name, [own[name] for own in values], FORMULAS[name]) for name in FORMULAS]

    @property
    def lines(self) -> list[str]:
        """The line of the class of each analysis, and those of the study's limit states."""
        of_analyses = [f"{name}: {_risk(found)['words']}" for name, found in self.columns]
        return [*of_analyses, *(_line(row) for row in (self.study or {}).get("frequencies", ()))]

    def numbers(self) -> dict[str, Any]:
        """The contents of risk.json."""
        found = {name.replace(" ", "_"): _numbers(each) for name, each in self.columns}
        return {"hazard": self.before["hazard"], **found, "frequencies": (self.study or {}).get("frequencies", [])}


FORMULAS = {  # of the rows of the sheet, in their order
    "load factor that decides": "α0 of the mechanism with the least ratio",
    "required, PGA_D": "a_g of the hazard at T_R = -V_R / ln(1 - P_VR)",
    "borne, PGA_C": "the a_g at which capacity = demand",
    "ζ_E": "PGA_C / PGA_D",
    "return period borne": "T_C of PGA_C, between the rows of the hazard by powers",
    "IS-V": "PGA_C / PGA_D at SLV",
    "PAM": "area below the points of 1 / T_C and cost, SLID to SLR",
    "class": "the worse of IS-V's and PAM's",
    "verdict": "capacity ≥ demand, for all mechanisms found",
}


def read_sheet(before: Path, after: Path | None = None, study: Path | None = None) -> RiskSheet:
    """Read a sheet from the folders of one or two limit analyses and of a study.

    Raises:
        InputError: a folder without the results of its command, an analysis without a check or a hazard, two of different sites, limit
            states or codes, or a study over another hazard or none.
    """
    first = _analysis(before, "DIR")
    second = None if after is None else _analysis(after, "--after")
    if second is not None:
        for key in OF_THE_SITE:
            if _of_site(first, key) != _of_site(second, key):
                raise InputError("--after", f"{after} and {before} differ in {key.replace('_', ' ')}; a sheet describes one site")
    return RiskSheet(first, second, None if study is None else _study(study, first))


def write_sheet(sheet: RiskSheet, folder: Path) -> list[Path]:
    """Write risk.html, risk.json and hazard.png; return their paths.

    Raises:
        InputError: matplotlib is not installed, or a folder that cannot be written.
    """
    own_files.begin(folder, files_of("risk"))
    picture = draw_hazard(sheet.before["hazard"], _marks(sheet), folder / PICTURE, sheet.before["title"])
    write_json(folder / FACTS, sheet.numbers())
    before, check = sheet.before, sheet.before["check"]
    last = sheet.columns[-1][1]
    write_document(
        folder / PAGE,
        "risk.html",
        title=before["title"],
        page=Head(before["title"], sheet.lines, (), _tiles(sheet), rows_of({}, f"masonry_cd {before['version']}", "")),
        check=check,
        columns=["", *(name for name, _ in sheet.columns), "formula"],
        rows=[[name, *values, formula] for name, values, formula in sheet.rows],
        mechanisms=[(name, _mechanisms(found)) for name, found in sheet.columns],
        frequencies=[_frequency(row) for row in (sheet.study or {}).get("frequencies", ())],
        formulas=[_formula(step) for step in last["check"]["steps"] if step["part"] in PARTS and step["line"]],
        assumed=_assumed(sheet),
        drawn=pictures({picture: CAPTION}),
    )
    return [folder / name for name in (PAGE, FACTS, PICTURE)]


def _analysis(folder: Path, where: str) -> Mapping[str, Any]:
    """limit.json of a folder whose scene has a check, a hazard, and a class of risk."""
    path = folder / LIMIT
    if not path.is_file():
        raise InputError(where, f"{folder} has no {LIMIT}; masonry-cd limit SCENE -o {folder} writes it")
    found: Mapping[str, Any] = _read(path, where)
    if not found.get("check"):
        raise InputError(where, f"{path} has no code check; its scene needs [limit.check]")
    if not found.get("hazard") or not found["check"].get("risk"):
        raise InputError(where, f"{path} has no hazard with rows of a_g and a class of risk; its scene needs [hazard] and an Italian code")
    return found


def _study(folder: Path, first: Mapping[str, Any]) -> Mapping[str, Any]:
    """summary.json of a study that has frequencies over the hazard of an analysis."""
    path = folder / STUDY
    if not path.is_file():
        raise InputError("--study", f"{folder} has no {STUDY}; masonry-cd study FILE -o {folder} writes it")
    found: Mapping[str, Any] = _read(path, "--study")
    if not found.get("frequencies"):
        raise InputError("--study", f"{path} has no frequencies; its scene needs [hazard] of the study's measure, and a fit")
    for key in ("measure", "intensity", "frequency"):
        if found["hazard"][key] != first["hazard"][key]:
            raise InputError("--study", f"{path} is for another hazard (its {key} differs); a sheet describes one site")
    return found


def _read(path: Path, where: str) -> Mapping[str, Any]:
    """The table that a JSON file holds."""
    try:
        found = json.loads(read_text(path))
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise InputError(where, f"{path} is damaged: it holds no table")
    return found


def _of_site(found: Mapping[str, Any], key: str) -> Any:
    """The hazard, the code or the limit state of an analysis."""
    return found["hazard"] if key == "hazard" else found["check"][key]


def _risk(found: Mapping[str, Any]) -> Mapping[str, Any]:
    """The class of risk of an analysis."""
    risk: Mapping[str, Any] = found["check"]["risk"]
    return risk


def _least(found: Mapping[str, Any]) -> Mapping[str, Any]:
    """The acceleration that is just borne, of the check that bears least; where one bears every ag, the other."""
    every: list[Mapping[str, Any]] = found["check"]["borne"]
    return min(every, key=lambda one: float("inf") if one["borne"] is None else one["borne"])


def _period(one: Mapping[str, Any]) -> str:
    """A return period with its bound."""
    years = one["return_period_years"]
    return "–" if years is None else f"{one['return_period_bound']} {number(years, 'years', digits=4)}".strip()


def _values(found: Mapping[str, Any]) -> dict[str, str]:
    """The cells of an analysis by the rows of the sheet."""
    one, risk, verdict = _least(found), _risk(found), found["verdict"]
    index = "–" if risk["index_class"] is None else "every a_g" if risk["index"] is None else per_cent(risk["index"])
    loss = "–" if risk["loss"] is None else f"{'≤ ' if risk['loss_at_most'] else ''}{100.0 * risk['loss']:.3g} % a year"
    return {
        "load factor that decides": number(found["mechanisms"][0]["alpha0"], digits=4),
        "required, PGA_D": number(one["asked"], "m/s²", digits=4),
        "borne, PGA_C": "every a_g" if one["borne"] is None else number(one["borne"], "m/s²", digits=4),
        "ζ_E": "–" if one["share"] is None else number(one["share"], digits=3),
        "return period borne": _period(one),
        "IS-V": index + ("" if risk["index_class"] is None else f", class {risk['index_class']}"),
        "PAM": loss + ("" if risk["loss_class"] is None else f", class {risk['loss_class']}"),
        "class": risk["risk_class"] or "not known",
        "verdict": verdict["state"],
    }


def _numbers(found: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of an analysis for risk.json."""
    one = {key: value for key, value in _least(found).items() if key != "words"}
    return {"title": found["title"], "verdict": found["verdict"]["state"], "capacity": one, "risk": _risk(found)}


def _tiles(sheet: RiskSheet) -> list[tuple[str, object, str]]:
    """The headline numbers: class, return period and zeta_E of each analysis."""
    out: list[tuple[str, object, str]] = []
    for name, found in sheet.columns:
        values = _values(found)
        out += [(f"class, {name}", values["class"], ""), (f"return period borne, {name}", values["return period borne"], "")]
    return out


def _mechanisms(found: Mapping[str, Any]) -> list[list[str | Badge]]:
    """The governing mechanisms of an analysis, one for each part and push."""
    first: dict[tuple[str, str], Mapping[str, Any]] = {}
    for row in found["mechanisms"]:
        first.setdefault((row["element"], row["push"]), row)
    return [
        [
            f"{row['element']}, push {row['push']}", row["mechanism"], number(row["alpha0"]), number(row["acceleration"], "m/s²", digits=3),
            "–" if row["demand"] is None else number(row["demand"], "m/s²", digits=3),
            "–" if row["ratio"] is None else number(row["ratio"], digits=3),
            Badge(f"verdict {COLOURS_OF_STATES.get(row['state'], 'look')}", row["state"]) if row["state"] else "–",
        ]
        for row in [*first.values()][:SHOWN]
    ]  # fmt: skip


def _frequency(row: Mapping[str, Any]) -> list[str]:
    """A limit state of the study."""
    return [
        row["limit_state"],
        f"{row['frequency']:.2g}",
        f"{row['frequency_low']:.2g} to {row['frequency_high']:.2g}",
        number(row["return_period_years"], "years", digits=3),
        per_cent(row["probability_50_years"]),
    ]


def _line(row: Mapping[str, Any]) -> str:
    """The line of a limit state of the study."""
    name, often, *_ = _frequency(row)
    return f"study, {name}: exceeded {often} times a year, {per_cent(row['probability_50_years'])} in 50 years"


def _assumed(sheet: RiskSheet) -> list[str]:
    """The assumptions and notes of all analyses, each once, with its analysis where others do not have it."""
    found = {name: [*_risk(each)["assumed"], *each["check"]["notes"], *each["check"]["left_open"]] for name, each in sheet.columns}
    every = [*dict.fromkeys(line for lines in found.values() for line in lines)]
    return [
        line if all(line in lines for lines in found.values()) else f"{line} ({', '.join(name for name in found if line in found[name])})"
        for line in every
    ]


def _formula(step: Mapping[str, Any]) -> list[str]:
    """A step with its formula in numbers and its clause."""
    return [step["line"], step["clause"]]


def _marks(sheet: RiskSheet) -> list[tuple[str, float, float]]:
    """Points of the picture: what is required, and what each analysis bears within the rows of the hazard; a_g [m/s2], years."""
    one = _least(sheet.before)
    steps = {step["symbol"]: step["value"] for step in sheet.before["check"]["steps"] if step["part"] == PARTS[0]}
    marks = [(f"required at {sheet.before['check']['limit_state']}", one["asked"], steps["TR"])]
    for name, found in sheet.columns:
        own = _least(found)
        if own["borne"] and own["return_period_years"] and not own["return_period_bound"]:
            marks.append((f"borne {name}", own["borne"], own["return_period_years"]))
    return marks
