# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of an assessment as a table: for the terminal, for assess.csv, for the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from masonry_cd.analysis.assessment.assessment import BASE, ENSEMBLE, Answer, Assessment, Member
from masonry_cd.analysis.assessment.verdict import between, heading, shown
from masonry_cd.analysis.outputs import ANSWER, ASSESS, numbers_in
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.quantities import counted

CSV = "assess.csv"
NUMBERS = (*numbers_in(ASSESS), "remark", "seconds")
SHORT = {key: number.short or number.name for key, number in numbers_in(ANSWER).items()}
NO_GRADE = "none"
MISSED, WAITS = "*", "not run yet"
WIDEST = 44  # characters of a reason in the terminal


def write_table(found: Assessment, path: Path) -> None:
    """Write assess.csv: a row per run, SI units, all digits."""
    columns = ["assumption", "level", "status", "reason", *NUMBERS, "run"]
    write_csv(path, columns, (_row(one) for one in found.members))


def _row(member: Member) -> list[str]:
    """The cells of a run."""
    row = member.row
    cells = [
        row.get("status", WAITS),
        row.get("reason") or row.get("limit_reason", ""),
        *(row.get(name) for name in NUMBERS),
        row.get("run"),
    ]
    return [*heading(member), *("" if cell is None else repr(cell) if isinstance(cell, float) else str(cell) for cell in cells)]


def heads(found: Assessment) -> list[str]:
    """Headings of the answers, with their units."""
    return [f"{SHORT[one.key]}{f' [{one.unit}]' if one.unit else ''}" for one in found.answers]


def _cell(answer: Answer, member: Member) -> str:
    """An answer: ``D2``, ``none`` for a run that is not graded."""
    if answer.key == "grade_number" and member.done and member.row.get("grade_number") is None:
        return NO_GRADE
    return shown(answer, member.of(answer))


def note_of(found: Assessment, member: Member) -> str:
    """What to know of a run: why it is no data, that steps missed the tolerance, that it alone was cut off."""
    if not member.row:
        return WAITS
    if not member.done:
        return f"{member.row.get('status')}: {member.row.get('reason')}"
    cut = "provisional" if member.row.get("provisional") and not found.base.row.get("provisional") else ""
    missed = f"{MISSED} {counted(member.row['steps_missed'], 'step')} missed" if member.missed else ""
    return ", ".join(filter(None, [missed, member.row.get("remark"), cut]))


def rows_of(found: Assessment) -> Iterator[list[str]]:
    """The rows of a table for people: the base case, the range of the ensemble, the levels, the pairs."""
    shown_name = ""
    for member in found.members:
        if member.kind == ENSEMBLE:
            if shown_name != "ensemble" and all(not one.row or one.done for one in found.ensemble):
                chance = [between(answer, *found.chance(answer)).removesuffix(f" {answer.unit}") for answer in found.answers]
                missed, waiting = sum(one.missed for one in found.ensemble), sum(not one.row for one in found.ensemble)
                notes = [f"{MISSED} {missed} members missed steps"] * bool(missed) + [f"{waiting} {WAITS}"] * bool(waiting)
                yield ["ensemble", f"{sum(one.done for one in found.ensemble)} members", *chance, ", ".join(notes)]
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
    wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = []
    for row in rows:
        cells = [cell.ljust(wide[k]) if k < 2 or k == len(row) - 1 else cell.rjust(wide[k]) for k, cell in enumerate(row)]
        lines.append("  ".join(cells).rstrip())
    return "\n".join([lines[0], "-" * max(map(len, lines)), *lines[1:]])
