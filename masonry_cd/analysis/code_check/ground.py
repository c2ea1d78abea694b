# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion of the ground as a check takes it: elastic response spectra of a code or of a record.

Each notes its quantities in a ``Working``, gives accelerations and displacements by period and damping, with the formula of the branch of
the spectrum in symbols, and the same motion of another size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from loads.motion import STANDARD_GRAVITY
from loads.signal.accelerogram import Processed, process
from loads.signal.code_spectrum import SiteSpectrum
from loads.signal.response import response_spectrum
from loads.signal.spectra.shape import PEAK, USUAL_DAMPING, CodeQuantity, ElasticSpectrum, common_rows, damping_factor
from loads.signal.spectra.table import beyond
from masonry_cd.analysis.code_check.steps import GROUND, Working
from masonry_cd.analysis.code_check.table import CheckRecord, CheckTable
from masonry_cd.analysis.hazard.curve import Hazard
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError

PERIODS = 200  # at which the spectrum of a record is looked at
SHORTEST = 0.02  # [s]
NO_STEP = 0.0  # there is no run whose time step a record could be resampled to
RECORD_ROWS = {
    "ag S": CodeQuantity("m/s2", "record", PEAK),
    "Se(T)": CodeQuantity("m/s2", "record", "response spectrum at that period"),
    "eta": common_rows("NTC 2018, 3.2.3.2")["eta"],
}


@dataclass(frozen=True, eq=False)
class CodeGround:
    """The spectrum of a code, or of a table, at a site."""

    site: SiteSpectrum
    gravity: float = STANDARD_GRAVITY  # of the formulas of a code; a check sets that of its mechanism
    hazard: Hazard | None = None  # of the site

    @cached_property
    def spectrum(self) -> ElasticSpectrum:
        """With its corners and factors."""
        return self.site.spectrum_of_site(gravity=self.gravity)

    @property
    def words(self) -> str:
        """Its kind, size and ground."""
        return f"{self.site.spectrum} spectrum{self.site.of_kind.words(self.site)}"

    @property
    def rows(self) -> Mapping[str, CodeQuantity]:
        """Those of the kind of spectrum."""
        return self.site.of_kind.rows

    @property
    def longest(self) -> float:
        """The period up to which it is known [s]."""
        return self.spectrum.longest

    @property
    def ag(self) -> float:
        """On rock, where the kind of spectrum knows rock [m/s2]."""
        return self.site.of_kind.size(self.site, self.spectrum)

    @property
    def peak(self) -> float:
        """Ag S [m/s2]."""
        return self.acceleration(0.0)

    def under(self, gravity: float) -> CodeGround:
        """The spectrum by formulas with that gravity [m/s2]."""
        return replace(self, gravity=gravity)

    def scaled(self, ag: float) -> CodeGround:
        """The spectrum of another ag [m/s2]; what depends on ag follows it, F0 and TC* of NTC where the hazard has them."""
        grown = self.site.of_kind.grown(self.site, self.ag, ag)
        return replace(self, site=grown.model_copy(update=self._shape(ag)))

    def _shape(self, ag: float) -> dict[str, float]:
        """F0 and TC* of the return period of an ag, as far as the hazard has them."""
        if self.hazard is None or self.site.spectrum != "NTC":
            return {}
        row = self.hazard.nearest(self.hazard.return_period(ag).years)
        return {key: value for key, value in (("f0", row.f0), ("tc_star", row.tc_star)) if value is not None}

    def put(self, made: Working) -> None:
        """Note ag, factors and corners."""
        made.part = GROUND
        for fact in self.site.of_kind.facts(self.site, self.spectrum):
            made.put(*fact)
        made.put("ag S", self.peak)

    def formula(self, period: float, of: str, damped: bool) -> str:
        """S_e of the branch of the spectrum on which a period lies, in symbols."""
        return self.spectrum.formula(period, of, damped)

    def displaced(self, made: Working, span: tuple[float, float], damping: float, of: str) -> tuple[float, str]:
        """S_De at the end of the span, S_e (T / 2 pi)^2 up to T_E."""
        last, damped, found = span[1], damping != USUAL_DAMPING, self.spectrum
        if found.scales_by_eta(damping):
            made.put("eta", damping_factor(damping))
        if found.long is not None and (falling := found.falling(last, of, damped)):
            made.put("TE", found.long[0])
            made.put("TF", found.long[1])
            return self.furthest(*span, damping), falling
        there = self.acceleration(last, damping)
        if made.known.get(f"Se({of})") != there:
            made.put(f"Se({of})", there, self.formula(last, of, damped), like="Se(T)")
        return self.furthest(*span, damping), f"Se({of}) {of}^2 / (4 pi^2)"

    def spectrum_at(self, periods: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray]:
        """Acceleration [m/s2] and displacement [m] at periods, (n,) each."""
        return self.spectrum.at(periods, damping), self.spectrum.displacement(periods, damping)

    def acceleration(self, period: float, damping: float = USUAL_DAMPING) -> float:
        """S_e [m/s2]."""
        return float(self.spectrum.at(np.array([period]), damping)[0])

    def furthest(self, first: float, last: float, damping: float = USUAL_DAMPING) -> float:
        """S_De at the last period, before T_E no shorter one has more [m]."""
        return float(self.spectrum.displacement(np.array([last]), damping)[0])


@dataclass(frozen=True, eq=False)
class RecordGround:
    """A record: spectra of its samples, which grow as it does."""

    samples: np.ndarray  # [m/s2]
    step: float  # [s]
    words: str
    scale: float = 1.0  # of the samples
    known: dict[tuple[float, ...], float] = field(default_factory=dict)  # what spectra of the samples were found to be
    rows: Mapping[str, CodeQuantity] = field(default_factory=lambda: RECORD_ROWS)
    longest: float = math.inf  # period up to which its spectrum is known [s]

    @property
    def ag(self) -> float:
        """PGA [m/s2]."""
        return self.peak

    @property
    def peak(self) -> float:
        """PGA [m/s2]."""
        return self.scale * float(np.abs(self.samples).max())

    def under(self, gravity: float) -> RecordGround:
        """The record: samples are in m/s2 whatever gravity is."""
        return self

    def scaled(self, ag: float) -> RecordGround:
        """The record times a factor, by which all of its spectra grow."""
        return replace(self, scale=self.scale * ag / self.peak)

    def put(self, made: Working) -> None:
        """Note its peak."""
        made.part = GROUND
        made.put("ag S", self.peak)

    def formula(self, period: float, of: str, damped: bool) -> str:
        """None: the spectrum is computed."""
        return ""

    def displaced(self, made: Working, span: tuple[float, float], damping: float, of: str) -> tuple[float, str]:
        """The largest of the spectrum in the span."""
        return self.furthest(*span, damping), ""

    def spectrum_at(self, periods: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray]:
        """Acceleration [m/s2] and displacement [m] at periods, (n,) each."""
        found = response_spectrum(self._longer(float(periods.max())), self.step, periods, damping)
        return self.scale * found.acceleration, self.scale * found.displacement

    def acceleration(self, period: float, damping: float = USUAL_DAMPING) -> float:
        """S_e [m/s2]."""
        key = (period, damping)
        if key not in self.known:
            self.known[key] = float(response_spectrum(self._longer(period), self.step, [period], damping).acceleration[0])
        return self.scale * self.known[key]

    def furthest(self, first: float, last: float, damping: float = USUAL_DAMPING) -> float:
        """The largest of the spectrum from the first period to the last [m]."""
        key = (first, last, damping)
        if key not in self.known:
            periods = libm.geometric(min(max(first, SHORTEST), last), last, PERIODS)
            self.known[key] = float(response_spectrum(self._longer(last), self.step, periods, damping).displacement.max())
        return self.scale * self.known[key]

    def _longer(self, period: float) -> np.ndarray:
        """The samples and a rest of one period, in which an oscillator goes on."""
        return np.append(self.samples, np.zeros(math.ceil(period / self.step) + 1))


Ground = CodeGround | RecordGround  # what a check gets; both answer the same questions


def ground_of(table: CheckTable, folder: Path, hazard: Hazard | None = None) -> Ground:
    """The motion that a table names; the ``hazard`` of its site says how a spectrum changes with ag.

    Raises:
        InputError: a record or a table that cannot be read, or a key with a period that the table does not reach.
    """
    if table.record is None:
        ground = CodeGround(table.read(folder, "limit.check"), hazard=hazard)
        for key in ("building_period", "element_period"):
            period = getattr(table, key)
            if period is not None and period > ground.longest:
                raise InputError(f"limit.check.{key}", beyond(period, ground.longest))
        return ground
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
