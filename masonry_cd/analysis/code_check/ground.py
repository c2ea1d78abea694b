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
from loads.signal.code_spectrum import NTC_AMPLIFICATION, NTC_PERIOD, CodeSpectrum, SiteSpectrum, damping_factor
from loads.signal.response import response_spectrum
from masonry_cd.analysis.code_check.steps import GROUND, Quantity, Working
from masonry_cd.analysis.code_check.table import CheckRecord, CheckTable
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError

PERIODS = 200  # at which the spectrum of a record is looked at
SHORTEST = 0.02  # [s]
NO_STEP = 0.0  # there is no run whose time step a record could be resampled to
USUAL_DAMPING = 0.05
EC8, NTC = "EN 1998-1, 3.2.2.2", "NTC 2018, 3.2.3.2"
COMMON = {
    "Se(T)": Quantity("m/s2", "", "elastic spectrum at that period"),
    "eta": Quantity("", "", "what the damping makes of the spectrum", "max(0.55, sqrt(10 / (5 + 100 xi)))"),
    "TE": Quantity("s", "", "from which displacements fall"),
    "TF": Quantity("s", "", "from which they are that of the ground"),
}
PEAK = "peak acceleration of the ground"
EC8_ROWS = {
    "ag": Quantity("m/s2", EC8, "peak acceleration on rock"),
    "S": Quantity("", EC8, "soil factor, tables 3.2 and 3.3"),
    "TB": Quantity("s", EC8, "where the plateau begins"),
    "TC": Quantity("s", EC8, "where it ends"),
    "TD": Quantity("s", EC8, "where constant displacements begin"),
    "F0": Quantity("", EC8, "amplification of the plateau"),
    "ag S": Quantity("m/s2", EC8, PEAK, "S ag"),
} | {symbol: row._replace(clause=EC8) for symbol, row in COMMON.items()}
NTC_ROWS = {
    "ag": Quantity("m/s2", "NTC 2018, 3.2", "peak acceleration on rock, of site and limit state"),
    "F0": Quantity("", "NTC 2018, 3.2", "largest amplification, of site and limit state"),
    "TC*": Quantity("s", "NTC 2018, 3.2", "where constant velocities begin on rock, of site and limit state"),
    "SS": Quantity("", "NTC 2018, table 3.2.IV", "soil factor"),
    "ST": Quantity("", "NTC 2018, table 3.2.V", "factor of topography"),
    "S": Quantity("", NTC, "both", "SS ST"),
    "CC": Quantity("", "NTC 2018, table 3.2.IV", "by which the soil stretches TC*"),
    "TC": Quantity("s", NTC, "where the plateau ends", "CC TC*"),
    "TB": Quantity("s", NTC, "where it begins", "TC / 3"),
    "TD": Quantity("s", NTC, "where constant displacements begin", "4 ag / g + 1.6"),
    "ag S": Quantity("m/s2", NTC, PEAK, "S ag"),
} | {symbol: row._replace(clause=NTC) for symbol, row in COMMON.items()}
RECORD_ROWS = {
    "ag S": Quantity("m/s2", "record", PEAK),
    "Se(T)": Quantity("m/s2", "record", "response spectrum at that period"),
    "eta": COMMON["eta"]._replace(clause=NTC),
}


@dataclass(frozen=True, eq=False)
class CodeGround:
    """The spectrum of a code at a site."""

    site: SiteSpectrum
    gravity: float = STANDARD_GRAVITY  # of the formulas of NTC; a check sets that of its mechanism

    @cached_property
    def spectrum(self) -> CodeSpectrum:
        """With its corners and factors."""
        return self.site.spectrum_of_site(gravity=self.gravity)

    @property
    def words(self) -> str:
        """Code, ag and ground."""
        return f"{self.site.spectrum} spectrum, ag {self.site.ag:g} m/s2, ground {self.site.ground}"

    @property
    def rows(self) -> Mapping[str, Quantity]:
        """Those of the code of the spectrum."""
        return EC8_ROWS if self.site.spectrum == "EC8" else NTC_ROWS

    @property
    def ag(self) -> float:
        """On rock [m/s2]."""
        assert self.site.ag is not None
        return self.site.ag

    @property
    def peak(self) -> float:
        """Ag S [m/s2]."""
        return self.acceleration(0.0)

    def under(self, gravity: float) -> CodeGround:
        """The spectrum by formulas with that gravity [m/s2]."""
        return replace(self, gravity=gravity)

    def scaled(self, ag: float) -> CodeGround:
        """The spectrum of another ag [m/s2]; F0 and TC* stay, SS and TD follow ag."""
        return replace(self, site=self.site.model_copy(update={"ag": ag}))

    def put(self, made: Working) -> None:
        """Note ag, factors and corners."""
        made.part = GROUND
        found, (begin, end, far) = self.spectrum, self.spectrum.corners
        made.put("ag", self.ag)
        made.put("F0", found.plateau)
        if self.site.spectrum == "NTC":
            assert self.site.tc_star is not None
            base, slope, low, high = NTC_AMPLIFICATION[self.site.ground]
            factor, power = NTC_PERIOD[self.site.ground]
            made.put("TC*", self.site.tc_star)
            made.put("SS", found.soil, f"min(max({base:g} - {slope:g} F0 ag / g, {low:g}), {high:g})" if slope else "")
            made.put("ST", found.hill)
            made.put("S", found.soil * found.hill)
            made.put("CC", found.stretch, f"{factor:g} TC*^({power:g})" if power else "")
            made.put("TC", end)
            made.put("TB", begin)
        else:
            made.put("S", found.soil)
            made.put("TB", begin)
            made.put("TC", end)
        made.put("TD", far)
        made.put("ag S", self.peak)

    def formula(self, period: float, of: str, damped: bool) -> str:
        """S_e of the branch of the spectrum on which a period lies, in symbols."""
        (begin, end, far), top = self.spectrum.corners, "eta F0" if damped else "F0"
        if period < begin:
            return f"ag S (1 + ({top} - 1) {of} / TB)"
        if period < end:
            return f"ag S {top}"
        return f"ag S {top} TC / {of}" if period < far else f"ag S {top} TC TD / {of}^2"

    def displaced(self, made: Working, span: tuple[float, float], damping: float, of: str) -> tuple[float, str]:
        """S_De at the end of the span, S_e (T / 2 pi)^2 up to T_E."""
        last, damped = span[1], damping != USUAL_DAMPING
        if damped:
            made.put("eta", damping_factor(damping))
        if self.spectrum.long is not None and last > self.spectrum.long[0]:
            top = "eta F0" if damped else "F0"
            made.put("TE", self.spectrum.long[0])
            made.put("TF", self.spectrum.long[1])
            falls = f"({top} + (1 - {top}) min(({of} - TE) / (TF - TE), 1))"
            return self.furthest(*span, damping), f"0.025 ag S TC TD {falls}"
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
    rows: Mapping[str, Quantity] = field(default_factory=lambda: RECORD_ROWS)

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


def ground_of(table: CheckTable, folder: Path) -> Ground:
    """The motion that a table names.

    Raises:
        InputError: a record that cannot be read.
    """
    if table.record is None:
        return CodeGround(table)
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
