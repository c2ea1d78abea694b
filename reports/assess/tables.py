# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of an assessment as a table: for the terminal, for assess.csv, for the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from masonry_cd.analysis.assessment.assessment import BASE, ENSEMBLE, Answer, Assessment, Member
from masonry_cd.analysis.assessment.verdict import between, heading, shown
from masonry_cd.analysis.outputs import ANSWER, ASSESS, numbers_in
from masonry_cd.foundation.csv_files import plain, write_csv
from masonry_cd.foundation.quantities import counted

CSV = "assess.csv"
NUMBERS = (*numbers_in(ASSESS), "remark", "seconds")
COLUMNS = ("status", "reason", *NUMBERS)
SHORT = {key: number.short or number.name for key, number in numbers_in(ANSWER).items()}
NO_GRADE = "none"
MISSED, WAITS = "*", "not run yet"
WIDEST = 44  # characters of a reason in the terminal


def write_table(found: Assessment, path: Path) -> None:
    """Write assess.csv: a row per run, SI units, all digits."""
    rows = ([*heading(one), *cells_of(one), one.run] for one in found.members)
    write_csv(path, ["assumption", "level", *COLUMNS, "run"], rows)


def cells_of(member: Member) -> list[Any]:
    """The cells of a run in the COLUMNS."""
    row = member.row
    ended = {"remark": row.remark or None, "seconds": row.seconds if row.status else None}
    return [row.status or WAITS, row.reason or row.limit_reason, *(ended.get(name, row.number(name)) for name in NUMBERS)]


def heads(found: Assessment) -> list[str]:
    """Headings of the answers, with their units."""
    return [f"{SHORT[one.key]}{f' [{one.unit}]' if one.unit else ''}" for one in found.answers]


def _cell(answer: Answer, member: Member) -> str:
    """An answer: ``D2``, ``none`` for a run that is not graded."""
    if answer.key == "grade_number" and member.row.done and member.row.number("grade_number") is None:
        return NO_GRADE
    return shown(answer, member.of(answer))


def note_of(found: Assessment, member: Member) -> str:
    """What to know of a run: why it is no data, that steps missed the tolerance, that it alone was cut off."""
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
