# SPDX-License-Identifier: GPL-3.0-or-later
r"""Results of a push by displacement: force against displacement, and the numbers that laboratories take from it.

Of the side on which the push began, the envelope is made of the points at which a displacement was reached for the first time, of means
over WINDOW of the run. From it come the peak F_max, the stiffness between 10 and 40 % of it, the displacement u_u after the peak at which
80 % are left, and the bilinear idealisation of codes (C8.7.1 of the Italian Circolare 2019, EN 1998-1 annex B in its kind): it begins with
the secant k through 60 % of the peak, and ends at u_u with the area A of the envelope,

    F_y = k (u_u - sqrt(u_u^2 - 2 A / k)),       u_y = F_y / k.

**Cycles** go from one passage through zero in the direction of the first push to the next. One dissipates E = sum F du, and has the
equivalent viscous damping xi = E / (4 pi E_s), E_s = (F+ u+ + F- u-) / 4 the mean of the triangles of its largest forces and displacements.

**Inertia** is the rate of momentum of all blocks along the push; its share is the largest mean over WINDOW of the run, over the largest
force.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import counted, force, length
from masonry_cd.io.results import Results
from masonry_cd.io.summary_tables import Bilinear, Cycle, Push

WINDOW = 1 / 200  # of the run, over which means are taken
LOW, HIGH, LEFT, SECANT = 0.1, 0.4, 0.8, 0.6  # shares of the peak
BACK = 1e-3  # share of the largest displacement at which a push counts as back at zero: it ends there but for what the steps round
MEANT = 0.01  # share of inertia up to which nothing is said


@dataclass(frozen=True, eq=False)
class PushCurve:
    """A guided group of blocks over the N steps of a run."""

    name: str
    kind: str  # push or prop
    direction: tuple[float, ...]
    time: np.ndarray  # (N,) [s]
    displacement: np.ndarray  # (N,) at the end of each step [m]
    force: np.ndarray  # (N,) on the blocks along the direction, mean over each step [N]
    moment: np.ndarray  # (N,) that holds them from turning [N m]
    inertia: np.ndarray  # (N,) rate of momentum of all blocks along the direction [N]

    @property
    def window(self) -> int:
        """Steps over which means are taken."""
        return max(1, round(WINDOW * len(self.time)))

    @cached_property
    def means(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Displacement [m], force and inertia [N], means over windows of the run."""
        count = len(self.time) // self.window
        cut = slice(len(self.time) - count * self.window, None)
        middle = 0.5 * (self.displacement + np.concatenate([[0.0], self.displacement[:-1]]))
        u, f, i = (values[cut].reshape(count, self.window).mean(axis=1) for values in (middle, self.force, self.inertia))
        return u, f, i

    @property
    def inertia_share(self) -> float:
        """Largest inertia over the largest force."""
        _, force, inertia = self.means
        most = float(np.abs(force).max(initial=0.0))
        return float(np.abs(inertia).max(initial=0.0)) / most if most else 0.0

    @property
    def energy(self) -> float:
        """Work put in [J]."""
        return float(np.sum(self.force * np.diff(self.displacement, prepend=0.0)))

    def envelope(self) -> tuple[np.ndarray, np.ndarray]:
        """Displacement [m] and force [N] of the first push, of growing size, both positive."""
        u, f, _ = self.means
        sign = self._side
        far = sign * u
        first = far > np.concatenate([[0.0], np.maximum.accumulate(far)[:-1]])
        first &= far > 0.0
        return far[first], sign * f[first]

    @property
    def _side(self) -> float:
        """The sign of the first way."""
        moved = np.flatnonzero(np.abs(self.displacement) > 0.01 * np.abs(self.displacement).max(initial=0.0))
        return float(np.sign(self.displacement[moved[0]])) if len(moved) else 1.0

    def cycles(self) -> tuple[Cycle, ...]:
        """Its whole cycles, see the head of this file."""
        u, sign = self.displacement * self._side, self._side
        near = BACK * float(np.abs(u).max(initial=0.0))
        before = np.concatenate([[0.0], u[:-1]])
        up = np.flatnonzero((before <= near) & (u > near) & _was_below(u, near))
        ends = [0, *up.tolist()]
        if len(u) and abs(u[-1]) <= near and (u[ends[-1] :] < -near).any():
            ends.append(len(u))
        return tuple(self._cycle(a, b, sign) for a, b in pairwise(ends))

    def _cycle(self, begin: int, end: int, sign: float) -> Cycle:
        u, f = sign * self.displacement[begin:end], sign * self.force[begin:end]
        way = np.diff(u, prepend=sign * self.displacement[begin - 1] if begin else 0.0)
        energy, high, low = float(np.sum(f * way)), float(u.max()), float(u.min())
        mean = np.convolve(f, np.full(min(self.window, len(f)), 1.0 / min(self.window, len(f))), "valid")
        most, least = float(mean.max()), float(mean.min())
        stored = 0.25 * (most * high + least * low)
        return Cycle(
            begin=float(self.time[begin]),
            end=float(self.time[end - 1]),
            displacement_max=high,
            displacement_min=low,
            force_max=most,
            force_min=least,
            dissipated=energy,
            damping=energy / (4.0 * math.pi * stored) if stored > 0.0 else math.nan,
        )

    def numbers(self) -> Push:
        """Return the numbers of a laboratory's table, for the summary."""
        u, f = self.envelope()
        of_peak: dict[str, Any] = {"peak_force": None}
        if len(f) and f.max() > 0.0:
            top = int(np.argmax(f))
            peak = float(f[top])
            ultimate = _falls_to(u, f, top, LEFT * peak)
            of_peak = {"peak_force": peak, "peak_displacement": float(u[top]), "stiffness": _secant(u, f, LOW * peak, HIGH * peak)}
            of_peak |= {"ultimate_displacement": ultimate, "bilinear": _bilinear(u, f, peak, ultimate)}
        return Push(
            name=self.name,
            direction=self.direction,
            energy=self.energy,
            inertia_share=self.inertia_share,
            cycles=self.cycles(),
            **of_peak,
        )


def push_curves(results: Results) -> list[PushCurve]:
    """The guided groups of a run, in the order of its loads; none before its first step."""
    guides, time = results.gauges.guides, results.per_step("step_time")
    columns = {name: results.per_step(f"guides/{name}") for name in ("force", "moment", "displacement", "momentum")}
    count = min(len(time), *(len(values) for values in columns.values()))
    if not guides or not count:
        return []
    step = np.diff(time[:count], prepend=0.0)
    found = []
    for k, guide in enumerate(guides):
        force, moment, displacement, momentum = (np.asarray(values[:count, k], dtype=float) for values in columns.values())
        inertia = np.diff(momentum, prepend=0.0) / step
        found.append(PushCurve(guide.name, guide.kind, guide.direction, time[:count], displacement, force, moment, inertia))
    return found


def require_pushes(results: Results) -> list[PushCurve]:
    """The pushes of a run.

    Raises:
        InputError: there are none.
    """
    found = [curve for curve in push_curves(results) if curve.kind == "push"]
    if not found:
        raise InputError("force_displacement", 'the run has no push; a load of kind "push" with control = "displacement" records one')
    return found


def push_numbers(results: Results) -> tuple[Push, ...]:
    """The numbers of all pushes of a run, for the summary."""
    return tuple(curve.numbers() for curve in push_curves(results) if curve.kind == "push")


def _was_below(u: np.ndarray, near: float) -> np.ndarray:
    """(N,) whether the displacement has been below zero since it was last above."""
    out, below = np.zeros(len(u), dtype=bool), False
    for k, value in enumerate(u.tolist()):
        out[k] = below
        below = value < -near or (below and value <= near)
    return out


def _secant(u: np.ndarray, f: np.ndarray, low: float, high: float) -> float | None:
    """Stiffness between the first displacements at which two forces are reached [N/m]; None where the first point of the curve is beyond
    both, as that of rigid joints is."""
    if f[0] >= high:
        return None
    a, b = _reaches(u, f, low), _reaches(u, f, high)
    return (high - low) / (b - a) if b > a else None


def _reaches(u: np.ndarray, f: np.ndarray, level: float) -> float:
    """The first displacement at which a force is reached [m]; the curve begins at zero."""
    u, f = np.concatenate([[0.0], u]), np.concatenate([[0.0], f])
    k = int(np.argmax(f >= level))
    return float(u[k - 1] + (u[k] - u[k - 1]) * (level - f[k - 1]) / (f[k] - f[k - 1])) if k else 0.0


def _falls_to(u: np.ndarray, f: np.ndarray, top: int, level: float) -> float | None:
    """The displacement after the peak at which a force is left [m]; None where it does not fall so far."""
    below = np.flatnonzero(f[top:] < level)
    if not len(below):
        return None
    k = top + int(below[0])
    return float(u[k - 1] + (u[k] - u[k - 1]) * (f[k - 1] - level) / (f[k - 1] - f[k]))


def _bilinear(u: np.ndarray, f: np.ndarray, peak: float, ultimate: float | None) -> Bilinear | None:
    """Stiffness, yield force and displacement, ultimate displacement and ductility; to the end where none is reached.

    None where the first point of the curve is beyond the secant, as that of rigid joints is, which have no stiffness.
    """
    if f[0] >= SECANT * peak:
        return None
    end = float(u[-1]) if ultimate is None else ultimate
    until = u < end
    x, y = np.concatenate([[0.0], u[until], [end]]), np.concatenate([[0.0], f[until], [float(np.interp(end, u, f))]])
    area, at = float(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x))), _reaches(u, f, SECANT * peak)
    if not at > 0.0:
        return None
    k = SECANT * peak / at
    inside = end * end - 2.0 * area / k
    if not inside > 0.0:
        return None
    force = k * (end - math.sqrt(inside))
    return Bilinear(
        stiffness=k, yield_force=force, yield_displacement=force / k, ultimate_displacement=end, ductility=end * k / force
    )  # fmt: skip


def push_line(push: Push) -> str:
    """A push of a summary as text."""
    if push.peak_force is None:
        return f'push "{push.name}": it has met no force'
    parts = [f"{force(push.peak_force)} at {length(push.peak_displacement)}"]
    parts += [f"stiffness {push.stiffness / 1e6:.3g} kN/mm"] if push.stiffness else []
    parts += [f"80 % of it at {length(push.ultimate_displacement)}"] if push.ultimate_displacement else []
    parts += [counted(len(push.cycles), "cycle")] if push.cycles else []
    return f'push "{push.name}": at most {", ".join(parts)}, inertia up to {100.0 * push.inertia_share:.2g} % of the force'


def push_warnings(pushes: Iterable[Push]) -> list[str]:
    """Pushes whose force is inertia by more than is intended."""
    return [
        f'push "{push.name}": inertia is up to {100.0 * push.inertia_share:.2g} % of the force recorded, above {100.0 * MEANT:g} %: '
        "a smaller speed, or damping where joints swing, makes it less"
        for push in pushes
        if push.inertia_share > MEANT
    ]
