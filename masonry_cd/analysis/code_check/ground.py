# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion of the ground as a check takes it: elastic response spectra of a code or of a record."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from loads.signal.accelerogram import Processed, process
from loads.signal.code_spectrum import CodeSpectrum
from loads.signal.response import response_spectrum
from masonry_cd.analysis.code_check.table import CheckRecord, CheckTable
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError

PERIODS = 200  # at which the spectrum of a record is looked at
SHORTEST = 0.02  # [s]
NO_STEP = 0.0  # there is no run whose time step a record could be resampled to


class Ground(Protocol):
    """What a check asks of the motion of the ground."""

    @property
    def words(self) -> str:
        """What it is."""
        ...

    @property
    def clause(self) -> str:
        """Where a code gives it."""
        ...

    @property
    def peak(self) -> float:
        """Peak acceleration, ag S of a code [m/s2]."""
        ...

    def acceleration(self, period: float, damping: float = 0.05) -> float:
        """S_e [m/s2]."""
        ...

    def furthest(self, first: float, last: float, damping: float = 0.05) -> float:
        """Largest displacement of oscillators with periods from first to last [m]."""
        ...


@dataclass(frozen=True)
class CodeGround:
    """The spectrum of a code."""

    spectrum: CodeSpectrum

    words: str
    clause: str

    @property
    def peak(self) -> float:
        """Ag S [m/s2]."""
        return self.acceleration(0.0)

    def acceleration(self, period: float, damping: float = 0.05) -> float:
        """S_e [m/s2]."""
        return float(self.spectrum.at(np.array([period]), damping)[0])

    def furthest(self, first: float, last: float, damping: float = 0.05) -> float:
        """S_De at the last period, before T_E no shorter one has more [m]."""
        return float(self.spectrum.displacement(np.array([last]), damping)[0])


@dataclass(frozen=True, eq=False)
class RecordGround:
    """A record: spectra of its samples."""

    samples: np.ndarray  # [m/s2]
    step: float  # [s]
    words: str
    clause: str = "record"

    @property
    def peak(self) -> float:
        """PGA [m/s2]."""
        return float(np.abs(self.samples).max())

    def acceleration(self, period: float, damping: float = 0.05) -> float:
        """S_e [m/s2]."""
        return float(response_spectrum(self._longer(period), self.step, [period], damping).acceleration[0])

    def furthest(self, first: float, last: float, damping: float = 0.05) -> float:
        """The largest of the spectrum from the first period to the last [m]."""
        periods = libm.geometric(min(max(first, SHORTEST), last), last, PERIODS)
        return float(response_spectrum(self._longer(last), self.step, periods, damping).displacement.max())

    def _longer(self, period: float) -> np.ndarray:
        """The samples and a rest of one period, in which an oscillator goes on."""
        return np.append(self.samples, np.zeros(int(np.ceil(period / self.step)) + 1))


def ground_of(table: CheckTable, folder: Path) -> Ground:
    """The motion that a table names.

    Raises:
        InputError: a record that cannot be read.
    """
    if table.record is None:
        clause = "EN 1998-1, 3.2.2.2" if table.spectrum == "EC8" else "NTC 2018, 3.2.3.2"
        words = f"{table.spectrum} spectrum, ag {table.ag:g} m/s2, ground {table.ground}"
        return CodeGround(table.spectrum_of_site(), words, clause)
    done, factor = record_of(table.record, folder)
    return RecordGround(done.after.acceleration, done.after.step, f"record {table.record.path}, times {factor:.4g}")


def record_of(record: CheckRecord, folder: Path) -> tuple[Processed, float]:
    """The record of a check at its size, and the factor that gives it this size.

    Raises:
        InputError: one that cannot be read.
    """
    where = "limit.check.record"
    if record.resample == "run":
        raise InputError(f"{where}.resample", '"run" has no time step here; give one in seconds')
    done = process(record, folder, NO_STEP, where)
    factor = record.factor(done.after.numbers()["pga"])
    return done.scaled(factor), factor
