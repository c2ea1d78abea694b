# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's folder as it is read: study.json says what was asked, runs.csv has one row per run, joints/ what each run did to the joints."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field

from masonry_cd.analysis.fragility.limits import LimitState, LimitStateTable, limit_states_of
from masonry_cd.analysis.run_row import STATES
from masonry_cd.foundation.csv_files import unguarded
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.fields import Table
from masonry_cd.foundation.files import read_bytes, read_text

FILE, TABLE = "study.json", "runs.csv"
FORMAT = 1
FIRST = ("run", "motion", "level", "seed", "status", "reason", "seconds")  # columns before what varied
RESULTS = "max_opening"  # the column with which the results begin; between what varied and it lie the intensity measures
TEXT = ("run", "motion", "status", "reason", "grade")  # columns of words; all others are of numbers where they can be


class StudyFacts(Table):
    """study.json: what was asked of a study."""

    model_config = ConfigDict(extra="ignore", frozen=True, use_attribute_docstrings=True)
    format: Annotated[int, Field(strict=True, ge=FORMAT, le=FORMAT)] = FORMAT
    """Format of these keys."""
    program: str = ""
    """Version that wrote it."""
    title: str
    """Title of pictures and closing lines."""
    design: str
    """Which runs there are."""
    seed: Annotated[int, Field(strict=True, ge=0)]
    """Seed of everything that is drawn."""
    scene: str
    """Name of its file."""
    measure: str | None
    """Intensity measure; None where there is none."""
    levels: list[float] | None
    """Levels of the intensity, where the design has some."""
    varied: list[str]
    """Keys of the scene."""
    limit_states: dict[str, LimitStateTable]
    """Limit states by name."""
    hazard: dict[str, Any] | None = None
    """Hazard of the site, where the scene has one: measure, intensity, frequency."""
    loss_ratios: dict[str, float] = Field(default_factory=dict)
    """Cost of repair over that of reconstruction, by the name of the limit state."""
    keep: str = "none"
    """Files that are kept of each run."""
    plan: str = ""
    """Digest of the runs' names."""
    runs: int | None
    """Planned; None as long as others may follow from them."""
    identity: dict[str, str] = Field(default_factory=dict)
    """Digests of the contents by which a study is recognised."""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return self.model_dump() | {"limit_states": {name: one.model_dump(exclude_none=True) for name, one in self.limit_states.items()}}


@dataclass(frozen=True, eq=False)
class StudyResults:
    """A study's folder.

    Attributes:
        folder: where it lies.
        asked: what study.json holds.
        limit_states: by name.
        columns: of runs.csv by name; (N,) floats, nan where a cell is empty, or a list of N texts.
        measures: names of the columns that are intensity measures.
    """

    folder: Path
    asked: StudyFacts
    limit_states: tuple[LimitState, ...]
    columns: Mapping[str, np.ndarray | list[str]]
    measures: tuple[str, ...]

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.text("run"))

    @cached_property
    def done(self) -> np.ndarray:
        """(N,) bool: runs that came to their end."""
        return np.array([word == "done" for word in self.text("status")], dtype=bool)

    @cached_property
    def collapsed(self) -> np.ndarray:
        """(N,) bool: runs in which blocks fell."""
        return self.numbers("collapsed_blocks") > 0

    @cached_property
    def motion(self) -> np.ndarray:
        """(N,) int: which record shook each run, -1 for none."""
        words = self.text("motion")
        names = {name: k for k, name in enumerate(self.motions)}
        return np.array([names.get(word, -1) for word in words], dtype=np.int64)

    @cached_property
    def motions(self) -> tuple[str, ...]:
        """The records, in the order of the table."""
        return tuple(dict.fromkeys(word for word in self.text("motion") if word))

    @cached_property
    def clusters(self) -> np.ndarray:
        """(N,) int: runs that are drawn together in the bootstrap, those of one record; a run without a record is one by itself."""
        alone = len(self.motions) + np.arange(self.count)
        return np.unique(np.where(self.motion >= 0, self.motion, alone), return_inverse=True)[1].reshape(-1)

    @property
    def varied(self) -> tuple[str, ...]:
        """Keys of the scene that vary."""
        return tuple(self.asked.varied)

    def text(self, name: str) -> list[str]:
        """A column of words."""
        column = self.columns[name]
        return column if isinstance(column, list) else [repr(float(value)) for value in column]

    def numbers(self, name: str) -> np.ndarray:
        """(N,) a column of numbers; nan where it has none, or is not there."""
        column = self.columns.get(name)
        return column if isinstance(column, np.ndarray) else np.full(self.count, np.nan)

    def is_number(self, name: str) -> bool:
        """Return True if a column is there and one of numbers."""
        return isinstance(self.columns.get(name), np.ndarray)

    def spread(self, names: Sequence[str]) -> list[str]:
        """Those of some columns that are numbers and differ between runs that are done."""
        found = []
        for name in names:
            values = self.numbers(name)[self.done]
            values = values[np.isfinite(values)]
            if len(values) > 2 and np.ptp(values) > 1e-9 * np.abs(values).max():
                found.append(name)
        return found


def read_study(folder: Path) -> StudyResults:
    """Read a study's folder.

    Raises:
        InputError: study.json or runs.csv is missing, broken, or the two do not belong together.
    """
    asked = read_facts(folder)
    header, rows = _read_rows(folder / TABLE, asked)
    columns = {name: _column(name, [row[k] for row in rows]) for k, name in enumerate(header)}
    states = columns["status"]
    for k, word in enumerate(states):
        if word not in STATES:
            raise InputError(f"{folder / TABLE}, line {k + 2}", f'status: "{word}" is none of {", ".join(STATES)}')
    measures = tuple(header[len(FIRST) + len(asked.varied) : header.index(RESULTS)])
    if rows and asked.measure is not None and asked.measure not in measures:
        raise InputError(folder / FILE, f'measure: {TABLE} has no column "{asked.measure}"')
    try:
        limits = limit_states_of(asked.limit_states, header)
    except InputError as error:
        raise error.under(str(folder / FILE)) from None
    return StudyResults(folder, asked, limits, columns, measures)


def read_facts(folder: Path) -> StudyFacts:
    """Return the contents of study.json in a folder.

    Raises:
        InputError: it is not there, cut off, or not of the format that this version reads; names the key.
    """
    path = folder / FILE
    try:
        found = json.loads(read_text(path))
    except FileNotFoundError:
        raise InputError(folder, f"no study: it has no {FILE}") from None
    except (OSError, ValueError) as failure:
        raise InputError(path, f"cannot be read: {failure}") from None
    if not isinstance(found, dict):
        raise InputError(path, "not a study, or damaged")
    try:
        return parse_table(StudyFacts, found, "")
    except InputError as error:
        raise error.each(lambda fault: fault._replace(source=str(path))) from None


def _read_rows(path: Path, asked: StudyFacts) -> tuple[list[str], list[list[str]]]:
    """Header and rows of runs.csv."""
    try:
        lines = list(csv.reader(io.StringIO(read_bytes(path).decode("utf-8"), newline="")))
    except FileNotFoundError:
        raise InputError(path.parent, f"the study has no {path.name} yet") from None
    except (OSError, ValueError, csv.Error) as failure:
        raise InputError(path, f"cannot be read: {failure}") from None
    header, rows = (lines[0], lines[1:]) if lines else ([], [])
    wanted = [*FIRST, *asked.varied]
    if header[: len(wanted)] != wanted or RESULTS not in header or len(set(header)) < len(header):
        raise InputError(f"{path}, line 1", f"not the columns of this study: {', '.join(wanted)}, ..., {RESULTS}, ...")
    for k, row in enumerate(rows):
        if len(row) != len(header):
            raise InputError(f"{path}, line {k + 2}", f"{len(row)} cells, and {len(header)} columns")
    return header, rows


def _column(name: str, cells: list[str]) -> np.ndarray | list[str]:
    """A column: numbers where all cells are, empty ones nan; else words, without the guard of :mod:`masonry_cd.foundation.csv_files`."""
    if name not in TEXT and not name.endswith(".grade"):
        try:
            return np.array([float(cell) if cell else math.nan for cell in cells], dtype=float)
        except ValueError:
            pass
    return [unguarded(cell) for cell in cells]
