# SPDX-License-Identifier: GPL-3.0-or-later
r"""Artificial accelerograms whose response spectrum is that of a code or of a table.

White noise under an envelope e(t) is brought to the target spectrum by turns in frequency and in time: with S_k the response spectrum of
a_k, every Fourier amplitude is multiplied by what the oscillator of its period lacks,

    A_k+1(f) = A_k(f) * S_target(1/f) / S_k(1/f),        phases kept,

after Gasparini & Vanmarcke (SIMQKE, MIT R76-4, 1976), who start from a sum of sines with random phases. Phases carry the envelope, so
it is kept too. Each turn ends with a correction of the baseline, so that what is compared is what will shake the base. The
best of the turns counts; where none comes within the tolerance another noise is drawn, ``DRAWS`` times.

The envelope (Jennings, Housner & Tsai, 1968): (t/rise)^2, then 1 over ``level`` seconds, then exp(-3 x), x from 0 to 1 at the end.
EN 1998-1, 3.2.3.1.2, asks for at least 10 s of it level, and for no value below 90 % of the target from 0.2 T1 to 2 T1; the tolerance here
holds on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from loads.kinds.record import sample
from loads.motion import DirectionKey, LoadAction, LoadKind, RunGrid, describe, smooth_step
from loads.signal.accelerogram import Processed, between
from loads.signal.baseline import ORDERS, GroundHistory, correct, integrate
from loads.signal.code_spectrum import SiteSpectrum
from loads.signal.intensity import in_words, reached
from loads.signal.response import Oscillators, response_spectrum
from loads.signal.spectra.kind import SpectrumName
from loads.signal.spectra.shape import USUAL_DAMPING, ElasticSpectrum
from loads.signal.spectra.table import beyond
from loads.supports import ShakingTable
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Span
from masonry_cd.foundation.units import Unit

STEP = 0.005  # [s] of the accelerogram
PERIODS = 200  # of the oscillators that are matched
FINE = 700  # of those by which the match is judged: within 1 % of a period a spectrum may change by 5 %
TURNS = 60
DRAWS = 6
MARGIN = 0.95  # of the tolerance, at those periods
SHORTEST, LONGEST = 0.03, 3.0  # [s] matched at least, so that no period outside the requested range stands out
FADE = 0.5  # [s] at both ends
LONGEST_MOTION = 600.0  # [s]: drawing 100 s takes 8 s


class SpectrumMatch(SiteSpectrum):
    """The keys that say which accelerogram is drawn, and where it acts."""

    direction: DirectionKey
    """Axis ("x", "-y" ...), vector or level angle from x to y along which the base moves."""
    spectrum: SpectrumName
    """Spectrum of EN 1998-1:2004 or 1998-1-1:2024, NTC 2018, ASCE 7 or NZS 1170.5, or a table of ordinates."""
    vertical: bool = False
    """Match the vertical spectrum."""
    period: Span | None = None
    """T1 of the structure: the spectrum is met from 0.2 to 2 T1."""
    periods: Annotated[tuple[float, float] | None, Unit("s"), between("seconds", 0.0199, 4.0)] = None
    """Range of periods in which it is met, [from, to]; 0.15 to 2 when not given."""
    tolerance: Annotated[float, Field(ge=0.03, le=0.5)] = 0.10
    """Tolerance of the ratio of the spectrum to its target."""
    rise: Span = 2.0
    """Rise of the envelope, to its full value."""
    level: Span = 10.0
    """Duration of the level of the envelope, at its full value."""
    duration: Annotated[float, Unit("s"), Field(gt=0.0, le=LONGEST_MOTION)] = 25.0
    """Duration of the whole motion."""
    seed: Annotated[int, Field(ge=0)] = 0
    """Seed of the noise from which it is made."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.period is not None and self.periods is not None:
            raise ValueError("give period or periods, not both")
        if self.period is not None and not 0.1 <= self.period <= 2.0:
            raise ValueError("period: must lie between 0.1 and 2 s")
        if self.vertical and not self.of_kind.vertical:
            raise ValueError(f"vertical: does not apply to a spectrum of {self.spectrum}")
        if self.duration < self.rise + self.level + 2.0 * FADE:
            raise ValueError(f"duration: {self.duration:g} s leave less than {2.0 * FADE:g} s after rise and level for the decay")
        return self

    @property
    def range(self) -> tuple[float, float]:
        """Where the spectrum is to be matched [s]."""
        if self.period is not None:
            return 0.2 * self.period, 2.0 * self.period
        return self.periods or (0.15, 2.0)

    @property
    def target(self) -> ElasticSpectrum:
        """The spectrum, of keys that are read."""
        return self.spectrum_of_site(self.vertical)

    fade: ClassVar[float] = 0.0  # it ends at rest

    def ready(self, grid: RunGrid, where: str) -> Processed:
        """The motion, drawn."""
        motion = drawn(self.read(grid.folder, where), where)
        return Processed(motion, motion, 0.0, "artificial", "")

    def lines(self, processed: Processed, how: str, where: str) -> list[str]:
        """On the motion, which acts in a way said by ``how``."""
        ground = f", ground {self.ground}" if self.of_kind.grounds else ""
        numbers, origin = processed.numbers()["after"], f"{self.spectrum} spectrum{ground}, seed {self.seed}"
        return [f"{where} artificial, {origin} {how}: {describe(numbers)}", f"{where}   {in_words(numbers)}"]

    def doubts(self, processed: Processed, where: str) -> list[str]:
        """None: the motion is as requested."""
        return []


class ArtificialTable(SpectrumMatch, ShakingTable):
    """Keys of ``kind = "artificial"``."""

    kind: Literal["artificial"] = "artificial"


@dataclass(frozen=True, eq=False)
class Match:
    """An accelerogram and how well it meets its target."""

    motion: GroundHistory
    worst: float  # largest |S / S_target - 1| inside the range


def artificial(table: ArtificialTable, grid: RunGrid, where: str) -> LoadAction:
    """The base motion.

    Raises:
        InputError: no noise was found that meets the tolerance.
    """
    table = table.read(grid.folder, where)
    processed, target, (low, high) = table.ready(grid, where), table.target, table.range
    motion, numbers, periods = processed.after, processed.numbers()["after"], libm.geometric(low, high, 200)
    ratio = response_spectrum(motion.acceleration, STEP, periods, USUAL_DAMPING).acceleration / target.at(periods)
    at_rest = float(target.at(np.zeros(1))[0])
    met = (
        f"{where}   spectrum over target {ratio.min():.3f} to {ratio.max():.3f} from {low:g} to {high:g} s, "
        f"PGA over that of the target {numbers['pga'] / at_rest:.3f}"
    )
    summary = table.facts("spectrum", "direction", "seed") | {"time_step": STEP, "periods": [low, high], "after": numbers}
    summary["ratio"] = [float(ratio.min()), float(ratio.max())]
    return LoadAction(
        motion=lambda times: table.direction.along(sample(motion, times - table.start)),
        delay=table.delay_of_blocks(grid, where),
        lines=(*table.lines(processed, f"along {table.direction.label}, from {table.start:g} s of the run", where), met),
        summary=summary,
        acted=reached(where, [(table.start + table.latest(grid, where), motion)]),
    )


def drawn(table: SpectrumMatch, where: str) -> GroundHistory:
    """The accelerogram of a table, from rest to rest; equal seeds give equal samples.

    Raises:
        InputError: none of the draws came within the tolerance, or the spectrum ends before the range in which it is to be met.
    """
    if table.range[1] > table.target.longest:
        raise InputError(where, f"{beyond(table.range[1], table.target.longest)}; periods = [from, to] says where it is met")
    best: Match | None = None
    for draw in np.random.SeedSequence(table.seed).spawn(DRAWS):
        match = _brought_to_target(table, np.random.default_rng(draw))
        if best is None or match.worst < best.worst:
            best = match
        if best.worst <= MARGIN * table.tolerance:
            return best.motion
    assert best is not None
    found = f"no accelerogram within {table.tolerance:.0%} of the spectrum was found, the best is off by {best.worst:.1%}"
    raise InputError(where, f"{found}; allow more tolerance, a longer duration, or take another seed")


def envelope(times: np.ndarray, rise: float, level: float, duration: float) -> np.ndarray:
    """e(t) of the head of this file, faded out over the last half second."""
    last = rise + level
    fall = libm.exp(-3.0 * np.clip((times - last) / (duration - last), 0.0, 1.0))
    return np.asarray(np.minimum(times / rise, 1.0) ** 2 * fall * smooth_step((duration - times) / FADE))


def _brought_to_target(table: SpectrumMatch, random: np.random.Generator) -> Match:
    """Turns of scaling in the frequency domain, until good enough; the best of them."""
    low, high = table.range
    count = round(table.duration / STEP) + 1
    times = STEP * np.arange(count)
    length = 1 << (2 * count - 1).bit_length()  # zeros behind, so that nothing comes round
    frequency = np.fft.rfftfreq(length, STEP)
    periods = libm.geometric(min(SHORTEST, low), min(max(LONGEST, 1.2 * high), table.target.longest), PERIODS)
    target, squares = table.target.at(periods), (2.0 * np.pi / periods) ** 2
    oscillators = Oscillators(periods, STEP, USUAL_DAMPING)
    inside = (periods >= low) & (periods <= high)
    fine = libm.geometric(*table.range, FINE)
    judges, of_target = Oscillators(fine, STEP, USUAL_DAMPING), (2.0 * np.pi / fine) ** 2 / table.target.at(fine)
    ends = smooth_step(times / FADE) * smooth_step((table.duration - times) / FADE)
    log_of, logs = -libm.log(np.maximum(frequency, 1e-3)), libm.log(periods)

    def shaped(values: np.ndarray, gain: np.ndarray) -> np.ndarray:
        return np.asarray(np.fft.irfft(_amplified(np.fft.rfft(values, length), gain), length)[:count])

    # noise with amplitudes S / sqrt(f), about those of a motion with a level spectrum, nothing slower than twice the longest period
    slow = 1.0 / (1.0 + (((0.5 / periods[-1] / np.maximum(frequency, 1e-3)) ** 2) ** 2) ** 2)
    gain = np.interp(log_of, logs, target) / np.sqrt(np.maximum(frequency, 0.1)) * slow
    a = shaped(random.standard_normal(count), gain) * envelope(times, table.rise, table.level, table.duration)
    best = Match(integrate(a, STEP), np.inf)
    for turn in range(TURNS):
        motion = correct(integrate(a, STEP), ORDERS["quadratic"])
        lacking = target / (squares * oscillators.peaks(motion.acceleration))
        if turn > 0:  # the first one only finds the size
            worst = float(np.abs(1.0 / lacking[inside] - 1.0).max())
            if worst <= min(best.worst, table.tolerance):
                worst = float(np.abs(of_target * judges.peaks(motion.acceleration) - 1.0).max())
            best = Match(motion, worst) if worst < best.worst else best
            if best.worst <= 0.8 * table.tolerance:
                break
        factor = lacking if turn > 0 else np.full(PERIODS, float(libm.exp(libm.log(lacking[inside]).mean())))
        a = shaped(motion.acceleration, np.interp(log_of, logs, factor)) * ends
    return best


def _amplified(numbers: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Complex numbers (n,) times real ones (n,), part by part: products of complex numbers round otherwise on another processor."""
    return np.asarray((numbers.view(float).reshape(-1, 2) * gain[:, None]).view(complex)[:, 0])


def _end(table: ArtificialTable, grid: RunGrid, where: str) -> float:
    """When the base stands still again [s]."""
    return table.start + table.duration + table.latest(grid, where)


KINDS = {
    "artificial": LoadKind(
        ArtificialTable, artificial, _end, starter={"direction": "x", "spectrum": "EC8", "ag": 2.5, "level": 3.0, "duration": 8.0}
    )
}
