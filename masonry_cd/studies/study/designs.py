# SPDX-License-Identifier: GPL-3.0-or-later
r"""Designs: which runs a study has, and what these are chosen from: motions, levels, values of lists and draws of distributions.

    grid       all combinations of the lists and ranges that vary, the levels, and the motions
    sample     a Latin hypercube of all that varies: distributions by their quantiles, lists, levels and motions by their places
    stripes    every motion at every level of intensity (Jalayer & Cornell, 2009); what is random is drawn for each run
    cloud      every motion once, as it was recorded (Jalayer, 2003); what is random is drawn for each
    ensemble   the same scene under tiny perturbations, which show how far a chaotic run spreads; the first member is the scene itself
    ida        incremental dynamic analysis by hunt and fill (Vamvatsikos & Cornell, Earthq. Eng. Struct. Dyn. 31(3), 2002)

An IDA goes motion by motion:

    hunt      levels s_1 = start, s_k+1 = s_k + step + (k - 1) growth, up to the first collapse
    bracket   between the highest level without collapse below it, a, and the lowest with, b: at a + (b - a) / 3
              until b - a <= resolution b
    fill      halves the widest gap between levels below the collapse, ``fill`` times

Each level follows from the finished runs of its motion alone, so the runs are the same for any number of workers. A run that failed ends
the hunt of its motion: it has no result. What is random is drawn for each motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.records import RecordMotion, Records
from masonry_cd.studies.study.study_file import EnsembleTable, IdaTable, StudyTables
from masonry_cd.studies.study.varied import Varied, uniform_numbers

DIGITS = 12  # of a level, so that it reads well in the table


@dataclass(frozen=True, slots=True)
class DesignedRun:
    """A run as a design asks for it."""

    motion: str = ""
    level: float | None = None
    member: int | None = None  # of an ensemble
    change: float = 0.0  # relative, of what an ensemble perturbs
    values: Mapping[str, Any] = field(default_factory=dict)  # of the keys that vary


@dataclass(frozen=True, eq=False)
class Space:
    """The motions, levels and values from which a design chooses."""

    tables: StudyTables
    records: Records | None
    varied: Varied

    @property
    def motions(self) -> list[str]:
        """Names of the motions; one without a name where the scene has its own loads."""
        return [""] if self.records is None else [motion.name for motion in self.records.motions]

    @property
    def levels(self) -> list[float | None]:
        """The levels of intensity; None alone where nothing is scaled to one."""
        intensity = self.tables.intensity
        return [None] if intensity is None or intensity.levels is None else [*intensity.levels]

    def motion(self, name: str) -> RecordMotion:
        """A motion by its name."""
        assert self.records is not None
        return self.records.by_name[name]

    def combinations(self) -> Iterator[dict[str, Any]]:
        """A value for each key that varies by a list, in all combinations."""
        for values in product(*self.varied.lists.values()):
            yield dict(zip(self.varied.lists, values, strict=True))

    def draw(self, *words: object) -> dict[str, float]:
        """A value for each distribution, which the study's seed and some words decide alone: what else is in the design changes none."""
        keys = self.varied.keys
        return self.varied.draw(uniform_numbers(self.tables.seed, words, len(keys))) if keys else {}


def grid(space: Space) -> Iterator[DesignedRun]:
    """The runs.

    Raises:
        InputError: something varies by a distribution, of which a grid has no points.
    """
    for key in space.varied.keys:
        raise InputError(f'vary."{key}"', 'a grid takes lists and ranges; design = "sample" takes distributions')
    for motion in space.motions:
        for level in space.levels:
            for values in space.combinations():
                yield DesignedRun(motion, level, values=values)


def sample(space: Space) -> Iterator[DesignedRun]:
    """The runs; with another number of samples all of them are others."""
    from scipy.stats.qmc import LatinHypercube

    count = space.tables.samples
    assert count is not None
    places = LatinHypercube(d=len(space.varied.columns) + 2, rng=space.tables.seed).random(count)
    for u in places:
        yield placed(space, u)


def placed(space: Space, u: np.ndarray) -> DesignedRun:
    """The run at a point (d,) of the unit cube, whose coordinates are of the distributions, the lists, the motions and the levels."""
    lists, keys = space.varied.lists, space.varied.keys
    values: dict[str, Any] = space.varied.draw(u[: len(keys)])
    values |= {key: _at(u[len(keys) + i], lists[key]) for i, key in enumerate(lists)}
    ordered = {key: values[key] for key in space.varied.columns}
    return DesignedRun(_at(u[-2], space.motions), _at(u[-1], space.levels), values=ordered)


def _at(u: float, choices: Sequence[Any]) -> Any:
    """The choice at a share of a list."""
    return choices[min(int(u * len(choices)), len(choices) - 1)]


def stripes(space: Space) -> Iterator[DesignedRun]:
    """The runs; a draw follows from motion, level and the values of lists, so more of these change none that is there."""
    for motion in space.motions:
        for level in space.levels:
            for values in space.combinations():
                yield DesignedRun(motion, level, values=values | space.draw(motion, level, *values.items()))


def cloud(space: Space) -> Iterator[DesignedRun]:
    """A run for each motion."""
    for motion in space.motions:
        for values in space.combinations():
            yield DesignedRun(motion, values=values | space.draw(motion, *values.items()))


def ensemble(space: Space) -> Iterator[DesignedRun]:
    """The runs: as many members for each motion and each combination of what varies; a member's change is drawn by its number alone."""
    asked = space.tables.ensemble or EnsembleTable()
    for motion in space.motions:
        for values in space.combinations():
            drawn = values | space.draw(motion, *values.items())
            for member in range(asked.members):
                u = float(uniform_numbers(space.tables.seed, ("member", member), 1)[0])
                change = 0.0 if member == 0 else asked.size * (2.0 * u - 1.0)
                yield DesignedRun(motion, member=member, change=change, values=drawn)


def ida(space: Space) -> Iterator[DesignedRun]:
    """The first run of each motion."""
    assert space.tables.ida is not None
    for motion in space.motions:
        for values in space.combinations():
            yield DesignedRun(motion, space.tables.ida.start, values=values | space.draw(motion, *values.items()))


DESIGNS: Mapping[str, Callable[[Space], Iterator[DesignedRun]]] = {
    "grid": grid, "sample": sample, "stripes": stripes, "cloud": cloud, "ensemble": ensemble, "ida": ida,
}  # fmt: skip


def next_level(table: IdaTable, found: Mapping[float, bool | None]) -> float | None:
    """The next level of a motion; None where its analysis is over.

    Args:
        table: how to go on.
        found: whether the structure collapsed, by level; None for a run that has no result.
    """
    if len(found) >= table.runs or None in found.values():
        return None
    level = _bracketing(table, found)
    if level is not None:
        return level
    hunted = _before_filling(table, found)
    first = min(level for level in found if found[level])
    below = [0.0, *sorted(level for level in found if level < first)]
    if len(found) - hunted >= table.fill or len(below) < 2:
        return None
    gap = max(range(len(below) - 1), key=lambda i: below[i + 1] - below[i])
    return _rounded(0.5 * (below[gap] + below[gap + 1]))


def _bracketing(table: IdaTable, found: Mapping[float, bool | None]) -> float | None:
    """The next level of the hunt or of the bracket; None where the collapse is known well enough."""
    if not found:
        return table.start
    levels = sorted(found)
    collapsed = [level for level in levels if found[level]]
    if not collapsed:
        return _rounded(levels[-1] + table.step + (len(levels) - 1) * table.growth)
    above = collapsed[0]
    below = max((level for level in levels if level < above), default=0.0)
    return _rounded(below + (above - below) / 3.0) if above - below > table.resolution * above else None


def _before_filling(table: IdaTable, found: Mapping[float, bool | None]) -> int:
    """The number of runs that hunting and bracketing took: they are gone through again from the first."""
    replayed: dict[float, bool | None] = {}
    while (level := _bracketing(table, replayed)) is not None and level in found:
        replayed[level] = found[level]
    return len(replayed)


def _rounded(level: float) -> float:
    return float(f"{level:.{DIGITS}g}")
