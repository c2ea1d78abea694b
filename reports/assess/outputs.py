# SPDX-License-Identifier: GPL-3.0-or-later
"""Outputs in the folder of an assessment: table, tornado, page, and in assess.json the findings from the runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from masonry_cd.analysis.assessment.assessment import (
    BASE,
    DISPLACEMENT,
    ENSEMBLE,
    FELT,
    FILE,
    GRADE,
    AssessedNumber,
    Assessment,
    Member,
    read_assessment,
)
from masonry_cd.analysis.assessment.indices import LARGEST_ERROR
from masonry_cd.analysis.assessment.verdict import (
    between,
    heading,
    lines_of,
    on_the_whole,
    place_of,
    shown,
    to_pin_down,
    verdict,
    warnings_of,
)
from masonry_cd.analysis.outputs import ANSWER, ASSESS, numbers_in
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.foundation import own_files
from masonry_cd.foundation.csv_files import plain, write_csv
from masonry_cd.foundation.json_files import write_json
from masonry_cd.foundation.quantities import counted
from reports.assess.picture import INDICES, PICTURE, draw_indices, draw_tornado
from reports.page.document import Head, pictures, rows_of_many, write_document
from reports.study.tables import DIGITS

CSV = "assess.csv"
NUMBERS = (*numbers_in(ASSESS), "remark", "seconds")
COLUMNS = ("status", "reason", *NUMBERS)
SHORT = {key: number.short or number.name for key, number in numbers_in(ANSWER).items()}
NO_GRADE = "none"
MISSED, WAITS = "*", "not run yet"
WIDEST = 44  # characters of a reason in the terminal


def write_table(found: Assessment, path: Path) -> None:
    """Write assess.csv: a row per run, SI units, all digits."""
    rows = ([*heading(one), *cells_of(one), one.run] for one in (*found.members, *found.sampled))
    write_csv(path, ["assumption", "level", *COLUMNS, "run"], rows)


def cells_of(member: Member) -> list[Any]:
    """The cells of a run in the COLUMNS."""
    row = member.row
    ended = {"remark": row.remark or None, "seconds": row.seconds if row.status else None}
    return [row.status or WAITS, row.reason or row.limit_reason, *(ended.get(name, row.number(name)) for name in NUMBERS)]


def heads(found: Assessment) -> list[str]:
    """Headings of the answers, with their units."""
    return [f"{SHORT[one.key]}{f' [{one.unit}]' if one.unit else ''}" for one in found.answers]


def _cell(answer: AssessedNumber, member: Member) -> str:
    """An answer: ``D2``, ``none`` for a run that is not graded."""
    if answer.key == "grade_number" and member.row.done and member.row.number("grade_number") is None:
        return NO_GRADE
    return shown(answer, member.of(answer))


def note_of(found: Assessment, member: Member) -> str:
    """A remark on a run: why it has no result, that steps missed the tolerance, that it alone was cut off."""
    if not member.row.status:
        return WAITS
    if not member.row.done:
        return f"{member.row.status}: {member.row.reason}"
    cut = "provisional" if member.row.number("provisional") and not found.base.row.number("provisional") else ""
    missed = f"{MISSED} {counted(member.row.number('steps_missed'), 'step')} missed" if member.missed else ""
    return ", ".join(filter(None, [missed, member.row.remark, cut]))


def rows_of(found: Assessment) -> Iterator[list[str]]:
    """The rows of a table for people: the base case, the range of the ensemble, the levels, the pairs."""
    shown_name = ""
    for member in found.members:
        if member.kind == ENSEMBLE:
            if shown_name != "ensemble" and all(not one.row.status or one.row.done for one in found.ensemble):
                chance = [between(answer, *found.chance(answer)).removesuffix(f" {answer.unit}") for answer in found.answers]
                missed, waiting = sum(one.missed for one in found.ensemble), sum(not one.row.status for one in found.ensemble)
                notes = [f"{MISSED} {missed} members missed steps"] * bool(missed) + [f"{waiting} {WAITS}"] * bool(waiting)
                yield ["ensemble", f"{sum(one.row.done for one in found.ensemble)} members", *chance, ", ".join(notes)]
                shown_name = "ensemble"
            if shown_name == "ensemble":
                continue
        name, level = heading(member)
        if member.kind == BASE:
            level = "as the scene has it"
        yield [
            "" if name == shown_name and name != "ensemble" else name,
            level,
            *(_cell(answer, member) for answer in found.answers),
            note_of(found, member),
        ]
        shown_name = name


def text_table(found: Assessment) -> str:
    """The table for a terminal."""
    rows = [["assumption", "level", *heads(found), ""], *rows_of(found)]
    for row in rows:
        row[-1] = row[-1] if len(row[-1]) <= WIDEST else row[-1][: WIDEST - 3] + "..."
    return plain(rows, range(2, len(rows[0]) - 1))


FILES = files_of("assess")
PAGE = "assess.html"
CAPTION = (
    "Each bar spans an answer from its smallest to its largest value when one assumption is varied and all others are kept; dots are the "
    "levels. The grey band and the marks in the first row are runs of the same scene whose amplitudes differ by 1e-9: their spread is "
    "chance. A full bar is longer than chance makes it in 19 of 20 cases, and longer than 5 % of the base case; a hollow bar is not. A "
    "white diamond is the case that the levels of an assumption are compared with, where that is not the base case."
)
SHARES = (
    "All properties of the structure varied together, each over the range of its levels. A full bar is the share of the variance of an "
    "answer that a property explains alone; a hollow bar adds its interactions with the others. Whiskers are 95 % bands, which "
    "include what the surrogate does not explain."
)
READ = (
    "The base case is the scene as it is. Chance is judged by the studentised range of as many runs as a "
    f"bar has (Tukey's test), and a difference of less than {100 * FELT:.0f} % of the base case is ignored. Assumptions are ranked "
    "by the share of the range of each answer that their bars cover."
)


def index_rows(found: Assessment) -> list[dict[str, Any]]:
    """Sobol indices with their bands and the error of the surrogate, a row per answer and property."""
    rows = []
    for answer, one in found.indices.items():
        for k, unknown in enumerate(found.unknowns):
            row: dict[str, Any] = {"answer": answer.key, "property": unknown.name, "varied": unknown.span}
            for name, values, (low, high) in (("first", one.first, one.first_band), ("total", one.total, one.total_band)):
                row |= {name: values[k], f"{name}_low": low[k], f"{name}_high": high[k]}
            rows.append(row | {"surrogate_error": one.error, "runs": one.runs, "refused": one.refused})
    return rows


def _index_cells(found: Assessment) -> list[list[str]]:
    """The rows of a table of indices for people; of an answer without any, why."""
    rows = []
    for answer, one in found.indices.items():
        for k, unknown in enumerate(found.unknowns):
            bands = ((one.first, one.first_band), (one.total, one.total_band))
            cells = [f"{values[k]:z.2f} ({low[k]:z.2f} to {high[k]:z.2f})" for values, (low, high) in bands]
            rows += [[answer.name if k == 0 else "", unknown.name, unknown.span, *cells, f"{100 * one.error:.0f} %" if k == 0 else ""]] * (
                not one.refused
            )
        rows += [[answer.name, one.refused, "", "", "", ""]] * bool(one.refused)
    return rows


def write_assessment(folder: Path) -> Assessment:
    """Write all that the runs of an assessment allow; a base case that has no result allows no picture.

    Raises:
        InputError: the folder holds no assessment, or cannot be written.
    """
    found = read_assessment(folder)
    own_files.begin(folder, FILES, lambda _: True)  # which assess.json proves, read above
    own_files.remove(folder, (PICTURE, INDICES))
    drawn = []
    write_table(found, folder / CSV)
    if found.base.row.done:
        draw_tornado(found, folder / PICTURE)
        drawn = [folder / PICTURE]
        drawn += [folder / INDICES] if draw_indices(found, folder / INDICES) else []
    write_page(found, drawn, folder / PAGE)
    write_json(folder / FILE, {"found": facts_of(found)} | found.as_dict(), DIGITS)
    return found


def facts_of(found: Assessment) -> dict[str, Any]:
    """Return the findings from the runs, for assess.json."""
    whole = on_the_whole(found).as_dict()
    if not found.base.row.done:
        return {"verdict": None, "on_the_whole": whole, "lines": lines_of(found), "warnings": warnings_of(found)}
    return {
        "verdict": verdict(found),
        "on_the_whole": whole,
        "pin_down": [one.name for one in to_pin_down(found)],
        "deciding": [one.name for one in found.deciding],
        "chance": {answer.key: list(found.chance(answer)) for answer in found.answers},
        "range": {answer.key: list(found.range(answer)) for answer in found.answers},
        "bars": found.bars(),
        **({"indices": index_rows(found)} if found.sampled else {}),
        "lines": lines_of(found),
        "warnings": warnings_of(found),
    }


def write_page(found: Assessment, drawn: Sequence[Path], path: Path) -> None:
    """Write assess.html."""
    title = f"{found.title}: what the answer depends on"
    write_document(
        path,
        "assess.html",
        title=title,
        page=Head(
            found.title,
            ["Results, with the assumption to determine first at the top", *lines_of(found)[1:]],
            warnings_of(found),
            _tiles(found),
            rows_of_many(
                found.scene,
                found.program,
                f"{', '.join(one.name for one in found.assumptions)}; one at a time{', and all together' if found.sampled else ''}",
            ),
            on_the_whole(found),
        ),
        drawn=pictures({path: CAPTION if path.name == PICTURE else SHARES for path in drawn}),
        indices=_index_cells(found),
        samples=len(found.sampled),
        limit=f"{100 * LARGEST_ERROR:.0f} %",
        columns=("assumption", "level", *heads(found), "remark"),
        rows=[*rows_of(found)],
        assumed=_assumed(found),
    )


def _tiles(found: Assessment) -> list[tuple[str, object, str]]:
    """The numbers at the head."""
    out: list[tuple[str, object, str]] = [("runs", len({one.run for one in (*found.members, *found.sampled) if one.row.done}), "")]
    for answer in found.answers:
        low, high = found.range(answer)
        out.append((f"{answer.name}, base case", f"{shown(answer, found.base.of(answer)) or 'none'} {answer.unit}".strip(), ""))
        if answer in (GRADE, DISPLACEMENT):
            out.append((f"{answer.name}, all runs", between(answer, low, high), ""))
    return out


def _assumed(found: Assessment) -> list[tuple[str, str]]:
    """Return the assumptions that were varied, and those that were not."""
    rows = [("scene", found.scene)]
    rows += [(one.name, f"{one.base}; varied: {', '.join(one.levels)}") for one in found.ranked]
    rows += [(name, f"not varied: {why}") for name, why in found.left_out]
    rows += [("how it is judged", READ)]
    failed = [place_of(one) for one in found.members if one.row.status and not one.row.done]
    rows += [("no data", ", ".join(failed))] if failed else []
    return rows
