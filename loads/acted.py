# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of a load has acted by a time: a run that ends before its loads begin says nothing of them.

Each kind of load measures itself by what it does to a structure: an accelerogram by its Arias intensity, a sine by its cycles, a vehicle
by its way over the bridge, a settlement by the displacement. The share goes from 0 to 1, and the verdict on a run judges it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.quantities import per_cent

WHOLE = 0.9995  # share from which on it is written as 100 %


class Acted(NamedTuple):
    """The share of a load that has acted by a time."""

    where: str  # the load's place in the scene, ``loads[0]``
    measure: str  # of which it is a share, ``Arias intensity``
    end: float  # when all of it has acted [s]; inf where nothing says so
    at: Callable[[float], float]  # time of the loads [s] -> share, 0 to 1

    def row(self, time: float) -> dict[str, Any]:
        """For summary.json, at a time of the loads [s]."""
        return {"load": self.where, "measure": self.measure, "share": min(1.0, max(0.0, float(self.at(time))))}

    def lines(self, time: float) -> list[str]:
        """A line where a run that ends at a time [s] leaves out a part of the load."""
        share = self.row(time)["share"]
        holds = f"; run.duration = {self.end:.6g} holds all of it" if np.isfinite(self.end) else ""
        acted = f"{self.where} the run ends at {time:g} s, when {per_cent(share)} of its {self.measure} has acted"
        return [f"{acted}{holds}"] if share < WHOLE else []


def over_time(where: str, measure: str, start: float, length: float, rises: Callable[[float], float] = lambda x: x) -> Acted:
    """Return the effect of a load that rises from 0 to 1 as x = (time - start) / length [s] does; a length of 0: at once."""

    def at(time: float) -> float:
        return rises(min(1.0, max(0.0, (time - start) / length))) if length > 0.0 else float(time >= start)

    return Acted(where, measure, start + length, at)


def growing(where: str, measure: str, start: float, initial: float, rate: float, most: float | None) -> Acted:
    """Return the effect of a load that grows from an initial value at a rate [1/s], up to ``most`` or else at once."""
    if most is None:
        begin = 0.0 if initial > 0.0 else start
        return Acted(where, measure, np.inf, lambda time: float(time > begin))
    begun = initial / most
    return over_time(where, measure, start, (most - initial) / rate, lambda x: begun + (1.0 - begun) * x)


def by_integral(where: str, measure: str, times: np.ndarray, values: np.ndarray) -> Acted:
    """Return the effect of a history, (N,) [s] and (N, k), straight between its times, by the integral of its size."""
    size = np.sqrt((values * values).sum(axis=1))
    built = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(times) * (size[1:] + size[:-1]))])
    return Acted(where, measure, float(times[-1]), lambda time: share_of(float(np.interp(time, times, built)), float(built[-1])))


def share_of(part: float, whole: float) -> float:
    """1 of nothing."""
    return part / whole if whole > 0.0 else 1.0
