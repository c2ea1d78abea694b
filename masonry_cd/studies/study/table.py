# SPDX-License-Identifier: GPL-3.0-or-later
"""runs.csv and runs.parquet: one row per run in the order of the plan; ``seconds`` aside, the same for any number of workers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from masonry_cd.analysis.fragility.folder import FIRST
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.studies.study.numbers import QUANTITIES
from masonry_cd.studies.study.plan import Maker, Planned

CSV, PARQUET = "runs.csv", "runs.parquet"
OF_PART = ("grade_number", "drift")


def write_table(folder: Path, runs: Sequence[Planned], maker: Maker, rows: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Write both tables, of the runs that have ended.

    Args:
        folder: of the study.
        runs: in order.
        maker: knows what varies and the intensity measures.
        rows: of the runs that have ended, by name.

    Returns:
        the columns.
    """
    ended = [run for run in runs if run.name in rows]
    columns = _columns(ended, maker, rows)
    cells = [_row(run, maker, rows[run.name]) for run in ended]
    write_csv(folder / CSV, columns, ([_text(row.get(name)) for name in columns] for row in cells))
    _write_parquet(folder / PARQUET, {name: [row.get(name) for row in cells] for name in columns})
    return columns


def _columns(runs: Sequence[Planned], maker: Maker, rows: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Names of the columns: parts in the order in which runs bring them up."""
    measures = list(maker.measures(runs[0].asked)) if runs else []
    parts = dict.fromkeys(part for run in runs for part in rows[run.name].get("parts", {}))
    return [*FIRST, *maker.space.varied.columns, *measures, *QUANTITIES, *(f"{part}.{name}" for part in parts for name in OF_PART)]


def _row(run: Planned, maker: Maker, row: Mapping[str, Any]) -> dict[str, Any]:
    """The cells of a run."""
    asked = run.asked
    seed = asked.member if asked.member is not None else asked.values.get("run.seed", maker.study.scene.run.seed)
    found = {"run": run.name, "motion": asked.motion or None, "level": asked.level, "seed": seed}
    found |= {name: row.get(name) for name in ("status", "reason", "seconds", *QUANTITIES)}
    found |= dict(asked.values) | maker.measures(asked)
    for part, values in row.get("parts", {}).items():
        found |= {f"{part}.{name}": values[name] for name in OF_PART}
    return found


def _text(value: Any) -> str:
    """A cell: numbers so that they are read back as they were, nothing where there is none."""
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)


def _write_parquet(path: Path, columns: Mapping[str, list[Any]]) -> None:
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
