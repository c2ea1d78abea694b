# SPDX-License-Identifier: GPL-3.0-or-later
"""runs.csv and runs.parquet: one row per run in the order of the plan; ``seconds`` aside, the same for any number of workers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from masonry_cd.analysis.fragility.folder import FIRST, TABLE
from masonry_cd.analysis.outputs import STUDY, numbers_in
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.studies.study.plan import Maker, Planned, StudyPlan

CSV, PARQUET = TABLE, "runs.parquet"
QUANTITIES = tuple(numbers_in(STUDY))
OF_PART = ("grade_number", "drift")

Rows = Mapping[str, RunRow]  # of the runs that have ended, by name


def write_table(folder: Path, plan: StudyPlan, rows: Rows) -> None:
    """Write both tables, of the runs that have ended, in the order of the plan."""
    ended, maker = [run for run in plan.ordered() if run.name in rows], plan.maker
    columns = _columns(ended, maker, rows)
    cells = [_row(run, maker, rows[run.name]) for run in ended]
    write_csv(folder / CSV, columns, ([row.get(name) for name in columns] for row in cells))
    write_parquet(folder / PARQUET, {name: [row.get(name) for row in cells] for name in columns})


def _columns(runs: Sequence[Planned], maker: Maker, rows: Rows) -> list[str]:
    """Names of the columns: parts in the order in which runs bring them up."""
    measures = list(maker.measures(runs[0].asked)) if runs else []
    parts = dict.fromkeys(part for run in runs for part in rows[run.name].parts)
    return [*FIRST, *maker.space.varied.columns, *measures, *QUANTITIES, *(f"{part}.{name}" for part in parts for name in OF_PART)]


def _row(run: Planned, maker: Maker, row: RunRow) -> dict[str, Any]:
    """The cells of a run."""
    asked = run.asked
    seed = asked.member if asked.member is not None else asked.values.get("run.seed", maker.study.scene.run.seed)
    found = {"run": run.name, "motion": asked.motion or None, "level": asked.level, "seed": seed}
    found |= {"status": row.status, "reason": row.reason, "seconds": row.seconds, **row.numbers}
    found |= {f"{part}.{name}": values[name] for part, values in row.parts.items() for name in OF_PART}
    return found | dict(asked.values) | maker.measures(asked)


def write_parquet(path: Path, columns: Mapping[str, list[Any]]) -> None:
    """Write columns as Parquet; one of several kinds of values as text."""
    import pyarrow
    from pyarrow import parquet

    arrays = {}
    for name, values in columns.items():
        kinds = {type(value) for value in values if value is not None}
        if kinds == {int, float}:
            values = [None if value is None else float(value) for value in values]
        elif len(kinds) > 1 or kinds & {list, dict}:
            values = [None if value is None else str(value) for value in values]
        arrays[name] = pyarrow.array(values)
    with replacing(path) as part:
        parquet.write_table(pyarrow.table(arrays), part)
