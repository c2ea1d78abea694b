# SPDX-License-Identifier: GPL-3.0-or-later
r"""The Italian class of seismic risk by the conventional method: Linee guida, D.M. 58/2017, annex A as replaced by D.M. 65/2017, 2.1.

    IS-V = PGA_C(SLV) / PGA_D(SLV),        lambda = 1 / T_rC of each limit state,        lambda(SLID) = 0.1

    PAM = sum_i (lambda_{i-1} - lambda_i) (CR_i + CR_{i-1}) / 2 + lambda(SLC) CR(SLR),        SLID, SLO, SLD, SLV, SLC

the area below the line through the points of lambda and the share CR of the cost of reconstruction (table 3). The class is the worse of
those of both (tables 1 and 2). SLV and SLD suffice: lambda(SLO) = 1.67 lambda(SLD), lambda(SLC) = 0.49 lambda(SLV) (note 3), and neither
SLO nor SLD is reached later than SLV (step 3, note 6).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

from masonry_cd.analysis.hazard.curve import GUIDELINE, Hazard, exponent

COST = {"SLID": 0.0, "SLO": 0.07, "SLD": 0.15, "SLV": 0.50, "SLC": 0.80}  # CR
ALL_OF_IT = 1.0  # CR of SLR, which is reached with SLC
FIRST_DAMAGE = 0.1  # lambda of SLID [1/year]; the method knows no return period below its 10 years
OFTEN, RARE = 1.67, 0.49  # lambda of SLO over that of SLD, of SLC over that of SLV
CLASSES = ("A+", "A", "B", "C", "D", "E", "F", "G")
LOSSES = (0.005, 0.010, 0.015, 0.025, 0.035, 0.045, 0.075)  # PAM up to which A+ to F reach; beyond is G
INDICES = (1.0, 0.80, 0.60, 0.45, 0.30, 0.15)  # IS-V above which A+ is, from which on A to E are; F is what is left


@dataclass(frozen=True)
class Capacity:
    """The acceleration on rock at which a limit state is reached, and how often a year it is exceeded."""

    state: str
    ag: float | None  # PGA_C [m/s2]; None where every ag is borne
    frequency: float  # lambda [1/year]
    how: str  # found
    at_most: bool = False  # the frequency is a bound: the rows of the hazard end before the capacity


@dataclass(frozen=True)
class Risk:
    """The class of risk of what is checked, None where it is not known, with what it follows from."""

    index: float | None  # IS-V; None where every ag is borne, and where the capacity at SLV is not known
    index_class: str | None
    capacities: tuple[Capacity, ...]
    loss: float | None  # PAM, share of the cost of reconstruction a year
    loss_class: str | None
    loss_at_most: bool  # PAM is a bound: a capacity lies beyond the rows of the hazard
    risk_class: str | None  # the worse of both
    assumed: tuple[str, ...]

    @property
    def words(self) -> str:
        """A line."""
        index = "IS-V without a bound" if self.index is None else f"IS-V = {100.0 * self.index:.3g} %"
        if self.loss is None:
            known = "" if self.index_class is None else f", {index} is of class {self.index_class}"
            return f"risk class not known{known}: it needs {'; '.join(self.assumed)}"
        bound = "<=" if self.loss_at_most else "="
        loss = f"PAM {bound} {100.0 * self.loss:.3g} % a year (class {self.loss_class})"
        return f"risk class {self.risk_class}, the worse of {index} (class {self.index_class}) and {loss}"

    @property
    def lines(self) -> list[str]:
        """The class, and what it assumes."""
        return [self.words, *([] if self.loss is None else [f"assumed: {'; '.join(self.assumed)}"])]

    def numbers(self) -> dict[str, Any]:
        """The numbers of it in check.json."""
        return asdict(self) | {"words": self.words, "source": GUIDELINE}


def capacity_of(state: str, ag: float | None, hazard: Hazard, site: float) -> Capacity:
    """How often the capacity of a limit state is exceeded.

    Below the first row the guideline's relation of accelerations and return periods goes on from it, for the ``site``'s ag at SLV [m/s2].
    """
    first, last = hazard.ends
    if ag is None or ag > hazard.intensity[-1]:
        return Capacity(state, ag, 1.0 / last, f"T_C >= {last:.4g} years, where the rows end", True)
    if ag >= hazard.intensity[0]:
        period = hazard.return_period(ag)
        return Capacity(state, ag, 1.0 / period.years, f"T_C = {period.words}, by the rows")
    years = first * (ag / float(hazard.intensity[0])) ** (1.0 / exponent(site))
    least = 1.0 / FIRST_DAMAGE
    if years < least:
        return Capacity(state, ag, FIRST_DAMAGE, f"T_C below {least:g} years, which are taken: the method knows none below")
    return Capacity(state, ag, 1.0 / years, f"T_C = {years:.4g} years, by the guideline's relation from the first row down (note 4)")


def frequencies(known: Mapping[str, float]) -> dict[str, float]:
    """lambda of all limit states [1/year] from those of SLV and SLD, and of SLC and SLO where they are known."""
    life = known["SLV"]
    damage = max(known["SLD"], life)
    working = min(max(known.get("SLO", OFTEN * damage), damage), FIRST_DAMAGE)
    return {"SLID": FIRST_DAMAGE, "SLO": working, "SLD": damage, "SLV": life, "SLC": min(known.get("SLC", RARE * life), life)}


def loss(known: Mapping[str, float]) -> float:
    """PAM by the lambda of all limit states [1/year]."""
    points = [(known[state], COST[state]) for state in COST]
    area = sum((often - rare) * 0.5 * (less + more) for (often, less), (rare, more) in pairwise(points))
    return area + known["SLC"] * ALL_OF_IT


def class_of_loss(value: float) -> str:
    """The class of a PAM, the upper bound of a class included."""
    return next((name for name, most in zip(CLASSES, LOSSES, strict=False) if value <= most), CLASSES[-1])


def class_of_index(value: float | None) -> str:
    """The class of an IS-V; 1 itself, which the guideline gives to no class, is A."""
    if value is None or value > INDICES[0]:
        return CLASSES[0]
    reached = [value >= least for least in INDICES[1:-1]] + [value > INDICES[-1]]
    return next((name for name, there in zip(CLASSES[1:], reached, strict=False) if there), CLASSES[6])


def risk_of(index: float | None, capacities: tuple[Capacity, ...], assumed: tuple[str, ...]) -> Risk:
    """The class of risk by IS-V and the capacities of the limit states that are known."""
    known = {one.state: one.frequency for one in capacities}
    by_index = class_of_index(index) if "SLV" in known else None
    if "SLD" not in known or "SLV" not in known:
        missing = " and ".join(state for state in ("SLD", "SLV") if state not in known)
        return Risk(index, by_index, capacities, None, None, False, None, (f"the capacity at {missing}", *assumed))
    value = loss(frequencies(known))
    by_loss = class_of_loss(value)
    worse = max(by_index or by_loss, by_loss, key=CLASSES.index)
    return Risk(index, by_index, capacities, value, by_loss, any(one.at_most for one in capacities), worse, assumed)
