# SPDX-License-Identifier: GPL-3.0-or-later
r"""Intensity measures by name: "PGA", "Sa(0.5)", "AvgSA(0.1, 1.0)", "FIV3(0.5)", for one component or both, "Sa(0.5):rotd50".

    PGA, PGV, PGD                   largest |a| [m/s2], |v| [m/s], |d| [m] at the samples
    Arias, CAV, D5-95               ``loads.signal.intensity`` [m/s], [m/s], [s]
    Sa(T, damping)                  pseudo-acceleration w^2 max |x| [m/s2], ``loads.signal.response``
    AvgSA(from, to, count, damping) geometric mean of Sa [m/s2] at ``count`` periods evenly spaced between two, both included, not in their
                                    logarithms: ( prod_i Sa(T_i) )^(1/n) (Eads, Miranda & Lignos, Earthq. Eng. Struct. Dyn. 44(12), 2015);
                                    ten unless said otherwise (Kohrangi, Bazzurro, Vamvatsikos & Spillatura, EESD 46(10), 2017)
    Housner(damping)                int Sv dT from 0.1 to 2.5 s [m] (Housner, 1952), Sv = w Sd, by the trapezoidal rule every 0.05 s
    FIV3(T, alpha, beta)            filtered incremental velocity [m/s], ``loads.signal.incremental_velocity``

Damping is 0.05 unless given. After a colon comes what is made of several components, see ``loads.signal.directions``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from loads.signal.baseline import GroundHistory
from loads.signal.directions import ANGLES, AXES, PAIRS, ROTATED, RULES, Components, component, horizontal, rotated
from loads.signal.incremental_velocity import ALPHA, BETA, fiv3
from loads.signal.intensity import arias, cumulative_absolute_velocity, significant_duration
from loads.signal.response import Oscillators, response_spectrum
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import finite_number

DAMPING = 0.05
PERIODS = 10  # of AvgSA
MOST_PERIODS = 1000
SHOWN = (0.1, 0.2, 0.5, 1.0, 2.0)  # periods of Sa where no measures are named [s]
HOUSNER = np.linspace(0.1, 2.5, 49)  # [s]


@dataclass(frozen=True)
class Single:
    """One number of an accelerogram."""

    function: Callable[[GroundHistory], float]

    def ordinates(self, history: GroundHistory) -> np.ndarray:
        """(1,): the number."""
        return np.array([self.function(history)])

    def around(self, x: GroundHistory, y: GroundHistory) -> np.ndarray:
        """(1, angles): that of each direction."""
        return np.array([[self.function(rotated(x, y, angle)) for angle in ANGLES]])

    def combined(self, ordinates: np.ndarray) -> float:
        """The number itself."""
        return float(ordinates[0])


@dataclass(frozen=True, eq=False)
class Spectral:
    """A number of the pseudo-accelerations at k periods."""

    periods: np.ndarray  # (k,) zero or more [s]
    damping: float
    combine: Callable[[np.ndarray], float]

    def ordinates(self, history: GroundHistory) -> np.ndarray:
        """Sa, (k,) [m/s2]."""
        return response_spectrum(history.acceleration, history.step, self.periods, self.damping).acceleration

    def around(self, x: GroundHistory, y: GroundHistory) -> np.ndarray:
        """Sa in each direction, (k, angles) [m/s2]: the two responses are rotated, which is the response to the rotated motion."""
        out = np.zeros((len(self.periods), len(ANGLES)))
        moving = self.periods > 0.0
        if not moving.all():
            out[~moving] = [np.abs(rotated(x, y, angle).acceleration).max() for angle in ANGLES]
        at = Oscillators(self.periods[moving], x.step, self.damping)
        out[moving] = ((2.0 * np.pi / self.periods[moving]) ** 2)[:, None] * at.rotated_peaks(x.acceleration, y.acceleration, ANGLES)
        return out

    def combined(self, ordinates: np.ndarray) -> float:
        """The measure of Sa (k,)."""
        return self.combine(ordinates)


@dataclass(frozen=True)
class Measure:
    """An intensity measure of a motion."""

    name: str  # as it would be parsed
    unit: str
    order: int  # the measure grows with this power of the motion; 0: not at all
    quantity: Single | Spectral  # k numbers of an accelerogram, of which one is made
    rule: str  # of the components, see loads.signal.directions

    def value(self, motion: Components) -> float:
        """The measure of a motion, in ``unit``.

        Raises:
            InputError: a component that it takes is missing, or the two horizontal ones differ in their sampling.
        """
        if self.rule in AXES:
            return self._of(component(motion, self.rule, self.name))
        x, y = horizontal(motion, self.name)
        if self.rule in PAIRS:
            return PAIRS[self.rule](self._of(x), self._of(y))
        return self.quantity.combined(ROTATED[self.rule](self.quantity.around(x, y)))

    def factor(self, level: float, motion: Components) -> float:
        """Return the factor for a motion by which the measure becomes ``level``, in ``unit``, above zero.

        Raises:
            InputError: it does not grow with the motion, or the motion is zero.
        """
        if self.order == 0:
            raise InputError(self.name, "no factor scales a motion to it, since it does not grow with the motion")
        value = self.value(motion)
        if not value > 0.0:
            raise InputError(self.name, f"it is {value:g} for this motion, which no factor scales to {level:g} {self.unit}")
        return level / value if self.order == 1 else math.sqrt(level / value)

    def _of(self, history: GroundHistory) -> float:
        return self.quantity.combined(self.quantity.ordinates(history))


def _peak(history: GroundHistory, of: str) -> float:
    return float(np.abs(getattr(history, of)).max())


def _arias(history: GroundHistory) -> float:
    return float(arias(history)[-1])


def _first(ordinates: np.ndarray) -> float:
    return float(ordinates[0])


def _geometric_mean(ordinates: np.ndarray) -> float:
    if (ordinates == 0.0).any():
        return 0.0
    return math.exp(math.fsum(libm.log(ordinates)) / len(ordinates))


def _velocity_spectrum_intensity(ordinates: np.ndarray) -> float:
    """int Sa / w dT over the periods of HOUSNER [m]."""
    velocity = HOUSNER / (2.0 * np.pi) * ordinates
    return math.fsum(0.5 * np.diff(HOUSNER) * (velocity[:-1] + velocity[1:]))


def _sa(period: float, damping: float = DAMPING) -> Spectral:
    _check(period >= 0.0, "T must not be negative")
    return Spectral(np.array([period]), _ratio(damping), _first)


def _average(begin: float, end: float, count: float = PERIODS, damping: float = DAMPING) -> Spectral:
    _check(0.0 < begin < end, "the periods must be from < to, above zero")
    _check(count == int(count) and 2 <= count <= MOST_PERIODS, f"count must be a whole number from 2 to {MOST_PERIODS}")
    return Spectral(np.linspace(begin, end, int(count)), _ratio(damping), _geometric_mean)


def _housner(damping: float = DAMPING) -> Spectral:
    return Spectral(HOUSNER, _ratio(damping), _velocity_spectrum_intensity)


def _fiv3(period: float, alpha: float = ALPHA, beta: float = BETA) -> Single:
    _check(min(period, alpha, beta) > 0.0, "its numbers must be above zero")
    return Single(partial(fiv3, period=period, alpha=alpha, beta=beta))


def _ratio(damping: float) -> float:
    _check(0.0 <= damping < 1.0, "the damping ratio must be at least 0 and below 1")
    return damping


def _check(holds: bool, otherwise: str) -> None:
    if not holds:
        raise ValueError(otherwise)


@dataclass(frozen=True)
class MeasureFamily:
    """Measures of one name, which differ by numbers in brackets."""

    unit: str
    order: int
    make: Callable[..., Single | Spectral]  # raises ValueError with a word on numbers out of range
    numbers: tuple[str, ...] = ()
    needed: int = 0  # of these numbers

    def usage(self, name: str) -> str:
        """How it is written; brackets around what may be left out."""
        needed = ", ".join(self.numbers[: self.needed])
        rest = ", ".join(self.numbers[self.needed :])
        if not needed:
            return f"{name}[({rest})]" if rest else name
        return f"{name}({needed}[, {rest}])" if rest else f"{name}({needed})"


FAMILIES = {
    "PGA": MeasureFamily("m/s2", 1, lambda: Single(partial(_peak, of="acceleration"))),
    "PGV": MeasureFamily("m/s", 1, lambda: Single(partial(_peak, of="velocity"))),
    "PGD": MeasureFamily("m", 1, lambda: Single(partial(_peak, of="displacement"))),
    "Arias": MeasureFamily("m/s", 2, lambda: Single(_arias)),
    "CAV": MeasureFamily("m/s", 1, lambda: Single(cumulative_absolute_velocity)),
    "D5-95": MeasureFamily("s", 0, lambda: Single(significant_duration)),
    "Sa": MeasureFamily("m/s2", 1, _sa, ("T", "damping"), 1),
    "AvgSA": MeasureFamily("m/s2", 1, _average, ("from", "to", "count", "damping"), 2),
    "Housner": MeasureFamily("m", 1, _housner, ("damping",)),
    "FIV3": MeasureFamily("m/s", 1, _fiv3, ("T", "alpha", "beta"), 1),
}
WRITTEN = re.compile(r"\s*(?P<name>[^():]*?)\s*(?:\((?P<numbers>[^()]*)\))?\s*(?::\s*(?P<rule>.*?))?\s*")


def parse(text: str, where: str = "measure", rule: str = "x") -> Measure:
    """The measure that a text asks for, such as "PGA", "Sa(0.5)" or "AvgSA(0.1, 1.0):rotd50".

    Args:
        text: name, numbers in brackets, a colon and a rule of components.
        where: the key or option it comes from, for messages.
        rule: of components where the text has none.

    Raises:
        InputError: an unknown name or rule, or numbers that are missing, too many, or out of range.
    """
    parts = WRITTEN.fullmatch(text)
    name = parts["name"] if parts else text
    if parts is None or name not in FAMILIES:
        known = ", ".join(family.usage(word) for word, family in FAMILIES.items())
        raise InputError(where, f'unknown intensity measure "{text}"{suggest(name, FAMILIES)}; known: {known}')
    family, chosen = FAMILIES[name], rule if parts["rule"] is None else parts["rule"]
    if chosen not in RULES:
        raise InputError(where, f'unknown rule of components "{chosen}" of "{text}"{suggest(chosen, RULES)}; known: {", ".join(RULES)}')
    numbers = _numbers(parts["numbers"], text, where)
    if not family.needed <= len(numbers) <= len(family.numbers):
        raise InputError(where, f'"{text}" must be {family.usage(name)}')
    try:
        quantity = family.make(*numbers)
    except ValueError as failure:
        raise InputError(where, f'"{text}": {failure}') from None
    inside = f"({','.join(f'{number:.15g}' for number in numbers)})" if numbers else ""
    return Measure(f"{name}{inside}:{chosen}", family.unit, family.order, quantity, chosen)


def spectrum(motion: Components, rule: str, periods: np.ndarray) -> np.ndarray:
    """Sa of a motion at periods (k,) of zero or more, for 5 % damping [m/s2].

    Args:
        motion: its components by axis.
        rule: of the components, see :mod:`loads.signal.directions`.
        periods: [s].

    Raises:
        InputError: see :meth:`Measure.value`.
    """
    quantity = Spectral(periods, DAMPING, _first)
    if rule in AXES:
        return quantity.ordinates(component(motion, rule, "Sa"))
    x, y = horizontal(motion, "Sa")
    if rule in PAIRS:
        return np.array([*map(PAIRS[rule], quantity.ordinates(x), quantity.ordinates(y))])
    return ROTATED[rule](quantity.around(x, y))


def of_one_component(texts: Sequence[str] | None, where: str) -> list[Measure]:
    """The measures that texts ask for, of a motion whose only component is x; Sa at five periods where there are none.

    Raises:
        InputError: see :func:`parse`; or a measure of several components.
    """
    found = [parse(text, where) for text in texts or (f"Sa({period:g})" for period in SHOWN)]
    for measure in found:
        if measure.rule != "x":
            raise InputError(where, f'{measure.name}: one record has no "{measure.rule}"; leave it out')
    return found


def in_words(measures: Sequence[Measure], motion: Components) -> str:
    """Measures of a motion, for a line to the user."""
    return ", ".join(f"{measure.name.removesuffix(':x')} {measure.value(motion):.4g} {measure.unit}" for measure in measures)


def _numbers(inside: str | None, text: str, where: str) -> list[float]:
    """The numbers between the brackets."""
    found = []
    for word in inside.split(",") if inside and inside.strip() else ():
        number = finite_number(word)
        if number is None:
            raise InputError(where, f'"{word.strip()}" of "{text}" is not a number')
        found.append(number)
    return found
