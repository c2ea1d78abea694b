# SPDX-License-Identifier: GPL-3.0-or-later
"""The candidates of a selection, each with its spectrum, which is computed once; and the set that is made of some of them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from loads.signal.measures import spectrum
from loads.signal.spectra.table import beyond
from masonry_cd.analysis.accelerogram_rule import Rule, judge
from masonry_cd.app.result import Say
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.selection.catalogue import COLUMNS, Row, read_catalogue, why_not
from masonry_cd.studies.selection.tables import Selection, TargetTable
from masonry_cd.studies.study.records import RecordMotion, motions_of, paired, read_motion

COMPARED, JUDGED, DRAWN = 60, 100, 80  # periods
AROUND = 2.0  # what is drawn goes beyond what is compared by this factor


@dataclass(frozen=True, eq=False)
class Grid:
    """The periods at which spectra are computed, and the places of those that are compared and judged among them."""

    periods: np.ndarray  # (q,), ascending, the first of them zero [s]
    compared: np.ndarray  # (m,)
    judged: np.ndarray  # (j,), period zero first
    target: np.ndarray  # (q,) [m/s2]

    @classmethod
    def of(cls, selection: Selection) -> Grid:
        """The periods of a selection.

        Raises:
            InputError: the table of its target is none, or ends before the longest of them.
        """
        table = selection.tables.target.read(selection.path.parent, "target")
        known, (low, high), judged = table.spectrum_of_site(), table.band, table.judged
        longest = max(high, judged[1])
        if longest > known.longest:
            raise InputError("target.table", beyond(longest, known.longest))
        drawn = libm.geometric(min(low, judged[0]) / AROUND, min(AROUND * longest, known.longest), DRAWN)
        parts = [libm.geometric(low, high, COMPARED), np.append(0.0, libm.geometric(*judged, JUDGED)), drawn]
        periods = np.unique(np.concatenate(parts))
        compared, at_rule = (np.searchsorted(periods, part) for part in parts[:2])
        return cls(periods, compared, at_rule, known.at(periods))


@dataclass(frozen=True, eq=False)
class Candidate:
    """A motion that may be chosen."""

    name: str
    duration: float  # [s]
    row: Row  # what the catalogue says of it
    spectrum: np.ndarray  # (q,) Sa before any factor [m/s2]


@dataclass(frozen=True, eq=False)
class ChosenSet:
    """The set that was chosen."""

    grid: Grid
    members: list[Candidate]  # (n,) in the order of their names
    factors: np.ndarray  # (n,)
    lift: float  # which they have in common, so that the rule holds
    pool: int  # candidates

    @property
    def spectra(self) -> np.ndarray:
        """Sa of each record times its factor, (n, q) [m/s2]."""
        return self.factors[:, None] * np.array([one.spectrum for one in self.members])

    @property
    def differences(self) -> np.ndarray:
        """The logarithm of their ratio to the target, (n, q)."""
        return np.asarray(libm.log(self.spectra / self.grid.target))

    @property
    def rule(self) -> Rule:
        """How the set meets EN 1998-1."""
        at = self.grid.judged
        return judge(self.grid.periods[at], self.spectra[:, at], self.grid.target[at])

    def fit(self, target: TargetTable) -> dict[str, float | None]:
        """How near the mean and the standard deviation of ln Sa are to what is wanted, over the periods compared."""
        d, periods = self.differences[:, self.grid.compared], self.grid.periods[self.grid.compared]
        mean, deviation = d.mean(axis=0), d.std(axis=0, ddof=1) if len(d) > 1 else None
        worst, wanted = int(np.abs(mean).argmax()), target.deviations(periods)
        found: dict[str, float | None] = {"mean_rms": _rms(mean), "mean_largest": float(mean[worst]), "at_s": float(periods[worst])}
        found["sigma"] = None if deviation is None else float(deviation.mean())
        return found | {"sigma_rms": None if deviation is None or wanted is None else _rms(deviation - wanted)}

    def rows(self) -> Iterator[dict[str, Any]]:
        """A row for each record."""
        for one, factor, d, sa in zip(self.members, self.factors, self.differences[:, self.grid.compared], self.spectra, strict=True):
            row = {"motion": one.name, "factor": float(factor), "misfit": _rms(d), "pga_m_s2": float(sa[0]), "duration_s": one.duration}
            yield row | {column: one.row.get(column) for column in COLUMNS.values()}


def find(selection: Selection, grid: Grid, say: Say) -> tuple[list[Candidate], dict[str, str]]:
    """The candidates in the order of their names, and why each other motion is left out.

    Raises:
        InputError: no folder, no file that fits, a bad catalogue.
    """
    table, asked, folder = selection.tables.records, selection.tables.candidates, selection.path.parent
    rows, motions, found = read_catalogue(asked, folder), motions_of(table, folder), []
    left = {name: why for name in motions if (why := why_not(asked, rows.get(name, {})))}
    say(f"{len(motions) - len(left)} of {len(motions)} motions are read and measured")
    for name, files in motions.items():
        if name not in left:
            try:
                found.append(_measured(selection, grid, read_motion(paired(table, name, files), table, 0.0), rows.get(name, {})))
            except InputError as error:
                left[name] = error.lines[0]
    return found, left


def _measured(selection: Selection, grid: Grid, motion: RecordMotion, row: Row) -> Candidate:
    """A candidate with its spectrum.

    Raises:
        InputError: it is shorter than the longest period that is compared, or does not move.
    """
    target, longest = selection.tables.target, selection.tables.target.band[1]
    if motion.duration < longest:
        raise InputError("", f"lasts {motion.duration:g} s, less than the longest period that is compared, {longest:g} s")
    found = spectrum(motion.rotated(selection.tables.records.rotate), target.of, grid.periods)
    if not (found > 0.0).all():
        raise InputError("", "does not move")
    return Candidate(motion.name, motion.duration, row, found)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))
