# SPDX-License-Identifier: GPL-3.0-or-later
"""What the folder of an assessment gets from the reports: table, tornado, page, and in assess.json what follows from the runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from masonry_cd.analysis.assessment.assessment import DISPLACEMENT, FELT, FILE, GRADE, Assessment, read_assessment
from masonry_cd.analysis.assessment.verdict import between, lines_of, on_the_whole, place_of, shown, to_pin_down, verdict, warnings_of
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.foundation import own_files
from masonry_cd.foundation.json_files import write_json
from reports.assess.picture import PICTURE, tornado
from reports.assess.tables import CSV, heads, rows_of, write_table
from reports.page.document import Head, pictures, rows_of_many, write_document
from reports.study.tables import DIGITS

FILES = files_of("assess")
PAGE = "assess.html"
CAPTION = (
    "Each bar runs from the least to the largest value of an answer when one assumption is changed and all else stays; dots are levels. "
    "The grey band and the marks in the first row are runs of the same scene that differ by a billionth of the amplitude: their spread is "
    "chance. A full bar is longer than chance makes it in 19 of 20 cases, and than a twentieth of the base case; a hollow one is not. A "
    "white diamond is the case that the levels of an assumption are compared with where that is not the base case."
)
READ = (
    "The base case is the scene as it is. Chance is judged by the studentised range of as many runs as a "
    f"bar has (Tukey's test), and a difference under {100 * FELT:.0f} % of the base case counts as none. Assumptions are ranked by the "
    "share of the range of each answer that their bars take."
)


def write_assessment(folder: Path) -> Assessment:
    """Write all that the runs of an assessment allow; a base case that is no data allows no picture.

    Raises:
        InputError: the folder holds no assessment, or cannot be written.
    """
    found = read_assessment(folder)
    own_files.begin(folder, FILES, lambda _: True)  # which assess.json proves, read above
    own_files.remove(folder, (PICTURE,))
    drawn = []
    write_table(found, folder / CSV)
    if found.base.row.done:
        tornado(found, folder / PICTURE)
        drawn = [folder / PICTURE]
    write_page(found, drawn, folder / PAGE)
    write_json(folder / FILE, {"found": facts_of(found)} | found.as_dict(), DIGITS)
    return found


def facts_of(found: Assessment) -> dict[str, Any]:
    """What follows from the runs, for assess.json."""
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
        "lines": lines_of(found),
        "warnings": warnings_of(found),
    }


def write_page(found: Assessment, drawn: Sequence[Path], path: Path) -> None:
    """Write assess.html."""
    title = f"{found.title}: what the answer rests on"
    write_document(
        path,
        "assess.html",
        title=title,
        page=Head(
            found.title,
            ["What was found, the assumption to pin down first at the top", *lines_of(found)[1:]],
            warnings_of(found),
            _tiles(found),
            rows_of_many(found.scene, found.program, f"{', '.join(one.name for one in found.assumptions)}; one at a time"),
            on_the_whole(found),
        ),
        drawn=pictures(dict.fromkeys(drawn, CAPTION)),
        columns=("assumption", "level", *heads(found), "remark"),
        rows=[*rows_of(found)],
        assumed=_assumed(found),
    )


def _tiles(found: Assessment) -> list[tuple[str, object, str]]:
    """The numbers at the head."""
    out: list[tuple[str, object, str]] = [("runs", len({one.run for one in found.members if one.row.done}), "")]
    for answer in found.answers:
        low, high = found.range(answer)
        out.append((f"{answer.name}, base case", f"{shown(answer, found.base.of(answer)) or 'none'} {answer.unit}".strip(), ""))
        if answer in (GRADE, DISPLACEMENT):
            out.append((f"{answer.name}, all runs", between(answer, low, high), ""))
    return out


def _assumed(found: Assessment) -> list[tuple[str, str]]:
    """What was varied, and what was not."""
    rows = [("scene", found.scene)]
    rows += [(one.name, f"{one.base}; varied: {', '.join(one.levels)}") for one in found.ranked]
    rows += [(name, f"not varied: {why}") for name, why in found.left_out]
    rows += [("how it is judged", READ)]
    failed = [place_of(one) for one in found.members if one.row.status and not one.row.done]
    rows += [("no data", ", ".join(failed))] if failed else []
    return rows
