# SPDX-License-Identifier: GPL-3.0-or-later
r"""Incremental dynamic analysis by hunt and fill (Vamvatsikos & Cornell, Earthq. Eng. Struct. Dyn. 31(3), 2002), motion by motion.

    hunt      levels s_1 = start, s_k+1 = s_k + step + (k - 1) growth, up to the first collapse
    bracket   between the highest level without collapse below it, a, and the lowest with, b: at a + (b - a) / 3
              until b - a <= resolution b
    fill      halves the widest gap between levels below the collapse, ``fill`` times

Each level follows from the finished runs of its motion alone, so the runs are the same for any number of workers. A run that failed ends
the hunt of its motion: it is no data. What is random is drawn for each motion.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from masonry_cd.studies.study.space import Asked, Space
from masonry_cd.studies.study.study_file import IdaTable

DIGITS = 12  # of a level, so that it reads well in the table


def runs(space: Space) -> Iterator[Asked]:
    """The first run of each motion."""
    assert space.tables.ida is not None
    for motion in space.motions:
        for values in space.combinations():
            yield Asked(motion, space.tables.ida.start, values=values | space.draw(motion, *values.items()))


def next_level(table: IdaTable, found: Mapping[float, bool | None]) -> float | None:
    """The next level of a motion; None where its analysis is over.

    Args:
        table: how to go on.
        found: whether the structure collapsed, by level; None for a run that is no data.
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
    """How many runs hunting and bracketing took: they are gone through again from the first."""
    replayed: dict[float, bool | None] = {}
    while (level := _bracketing(table, replayed)) is not None and level in found:
        replayed[level] = found[level]
    return len(replayed)


def _rounded(level: float) -> float:
    return float(f"{level:.{DIGITS}g}")
