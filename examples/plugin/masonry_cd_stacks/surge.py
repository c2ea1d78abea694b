# SPDX-License-Identifier: GPL-3.0-or-later
"""``[[loads]] kind = "surge"``: the base moves by a smooth surge of velocity along x, v(t) = A sin^2(pi t / T) up to T."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import Field

from loads.motion import LoadAction, LoadKind, LoadTable, RunGrid
from masonry_cd.foundation.units import Unit, Usual


class SurgeTable(LoadTable):
    """The keys; ``kind`` is among those of every load."""

    amplitude: Annotated[float, Unit("m/s"), Usual(0.01, 2.0, "the ground moves at 0.01 to 2 m/s", ("cm/s", "mm/s"))] = Field(gt=0.0)
    """A"""
    length: Annotated[float, Unit("s")] = Field(gt=0.0)
    """T"""


def surge(table: SurgeTable, grid: RunGrid, where: str) -> LoadAction:
    """Return the velocity of the base that it adds to a run, at times (n,), (n, 3) [m/s]."""

    def velocity(times: np.ndarray) -> np.ndarray:
        inside = (times >= 0.0) & (times <= table.length)
        along = [table.amplitude * math.sin(math.pi * t / table.length) ** 2 for t in times.tolist()]
        return np.outer(np.where(inside, along, 0.0), [1.0, 0.0, 0.0])

    summary = {"kind": table.kind, "amplitude": table.amplitude, "length": table.length}
    return LoadAction(motion=velocity, lines=(f"{where} surge of {table.amplitude:g} m/s over {table.length:g} s",), summary=summary)


SURGE = LoadKind(SurgeTable, surge)
