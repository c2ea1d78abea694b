# SPDX-License-Identifier: GPL-3.0-or-later
"""What the folder of an assessment gets from the reports: table, tornado, page, and in assess.json what follows from the runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from masonry_cd.analysis.assessment.assessment import FILE, Assessment, Known, as_facts, read_assessment
from masonry_cd.analysis.assessment.verdict import lines_of, on_the_whole, to_pin_down, verdict, warnings_of
from masonry_cd.analysis.outputs.folders import files_of
from reports.assess.page import PAGE, write_page
from reports.assess.picture import PICTURE, tornado
from reports.assess.tables import CSV, write_table
from reports.study.tables import write_json

FILES = files_of("assess")


def write_assessment(folder: Path) -> Assessment:
    """Write all that the runs of an assessment allow; a base case that is no data allows no picture.

    Raises:
        InputError: the folder holds no assessment, or cannot be written.
    """
    found = read_assessment(folder)
    (folder / PICTURE).unlink(missing_ok=True)
    drawn = []
    write_table(found, folder / CSV)
    if found.base.done:
        tornado(found, folder / PICTURE)
        drawn = [folder / PICTURE]
    write_page(found, drawn, folder / PAGE)
    write_json(folder / FILE, as_facts(found) | {"found": facts_of(found)})
    return found


def facts_of(found: Assessment) -> dict[str, Any]:
    """What follows from the runs, for assess.json."""
    whole = on_the_whole(found).as_dict()
    if not found.base.done:
        return {"verdict": None, "on_the_whole": whole, "lines": lines_of(found), "warnings": warnings_of(found)}
    return {
        "verdict": verdict(found),
        "on_the_whole": whole,
        "pin_down": [one.name for one in to_pin_down(found)],
        "deciding": [one.name for one in found.deciding],
        "chance": {answer.key: list(found.chance(answer)) for answer in found.answers},
        "range": {answer.key: list(found.range(answer)) for answer in found.answers},
        "bars": {one.name: _bars(found, one) for one in found.ranked},
        "lines": lines_of(found),
        "warnings": warnings_of(found),
    }


def _bars(found: Assessment, one: Known) -> dict[str, Any]:
    """The bars of an assumption by answer."""
    out = {}
    for answer in found.answers:
        bar = found.bar(one, answer)
        chance = found.by_chance(answer, 1 + len(bar.values))
        out[answer.key] = {"low": bar.low, "high": bar.high, "reference": bar.reference, "by_chance": chance, "shows": bar.shows}
    return out
