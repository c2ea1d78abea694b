# SPDX-License-Identifier: GPL-3.0-or-later
"""Integration of an acceleration record, and the correction of its baseline.

Between samples a record is a straight line, so over one interval h, exactly,

    v' = v + h (a + a') / 2,        d' = d + h v + h^2 (2 a + a') / 6.

A small offset in a(t) makes v drift like t and d like t^2: a base driven by it carries the building away. The correction adds a polynomial
to the acceleration, of order 1 ("linear"), 2 ("quadratic") or 3 ("cubic"),

    a_c = a - sum_k c_k P_k(t),     such that   v_c(T) = 0  and  d_c(T) = 0,

with P_k the Legendre polynomials over the record. Both end conditions hold exactly. A linear polynomial has just the two
coefficients they fix; it is also the smallest change, in the sense of its integral of squares, that meets them (the stationary point
of int (a_c - a)^2 + lambda v_c(T) + nu d_c(T) is linear in t). Orders above have coefficients left over, which minimise the integral of
v_c^2 under the two conditions: least squares on the velocity, where drift shows (compare Boore, Bull. Seism. Soc. Am. 91(5), 2001, who
fits a polynomial to the velocity and takes its derivative from the acceleration), with the ends constrained. All of it is done on
samples with the two formulas above, so the corrected record is again straight between samples and its motion is exact.

"quadratic" is the default. Offsets put on the L'Aquila AQV record of 2009 (a step of 0.01 m/s2 at 8 s; a slow wave of 0.01 m/s2 and 60 s; a
random walk) left errors in displacement of 0.31, 0.58, 0.63 m after the linear correction, 0.07, 0.10, 0.16 m after the quadratic one and
0.02, 0.02, 0.05 m after the cubic one. But on a record that needs no correction the cubic one takes the most of the true motion away
(PGD of its NS component: 3.95 cm raw, 3.4 linear, 3.8 quadratic, 3.2 cubic). The quadratic one changes the acceleration of whole records by
less than 0.001 m/s2, and of windows of 12 s cut from the middle of the strong motion by less than 0.06 m/s2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ORDERS = {"none": 0, "linear": 1, "quadratic": 2, "cubic": 3}


@dataclass(frozen=True, eq=False)
class GroundHistory:
    """Acceleration, straight between n samples every h seconds, and its exact integrals from rest at the first sample."""

    step: float  # h [s]
    acceleration: np.ndarray  # (n,) [m/s2]
    velocity: np.ndarray  # (n,) [m/s]
    displacement: np.ndarray  # (n,) [m]

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return self.step * (len(self.acceleration) - 1)

    def scaled(self, factor: float) -> GroundHistory:
        """The motion times a factor."""
        return GroundHistory(self.step, factor * self.acceleration, factor * self.velocity, factor * self.displacement)

    def velocity_at(self, since: np.ndarray) -> np.ndarray:
        """Velocity at any times since the first sample (m,), exact, zero before and the last value after [m/s]."""
        since = np.clip(since, 0.0, self.duration)
        left = np.minimum((since / self.step).astype(int), len(self.acceleration) - 2)
        into = since - left * self.step
        slope = (self.acceleration[left + 1] - self.acceleration[left]) / self.step
        return self.velocity[left] + into * (self.acceleration[left] + 0.5 * into * slope)

    def numbers(self) -> dict[str, float]:
        """PGA [m/s2], PGV [m/s], PGD [m], end velocity [m/s] and end displacement [m], from the samples."""
        return {
            "pga": float(np.abs(self.acceleration).max()),
            "pgv": float(np.abs(self.velocity).max()),
            "pgd": float(np.abs(self.displacement).max()),
            "end_velocity": float(self.velocity[-1]),
            "end_displacement": float(self.displacement[-1]),
        }


def integrate(acceleration: np.ndarray, step: float) -> GroundHistory:
    """Integrate an acceleration (n,) that is straight between its samples, from rest.

    Args:
        acceleration: at least two samples [m/s2].
        step: [s].
    """
    a, b = acceleration[:-1], acceleration[1:]
    velocity = np.concatenate([[0.0], np.cumsum(0.5 * step * (a + b))])
    displacement = np.concatenate([[0.0], np.cumsum(step * velocity[:-1] + step * step / 6.0 * (2.0 * a + b))])
    return GroundHistory(step, acceleration, velocity, displacement)


def correct(raw: GroundHistory, order: int) -> GroundHistory:
    """Take a polynomial of the given order from the acceleration so that velocity and displacement end at zero.

    Args:
        raw: at least ``order + 1`` samples.
        order: 0 for no correction, 1, 2, 3 as in ``ORDERS``.
    """
    if order == 0:
        return raw
    at = np.linspace(-1.0, 1.0, len(raw.acceleration))
    shapes = [integrate(np.polynomial.legendre.Legendre.basis(k)(at), raw.step) for k in range(order + 1)]
    velocity = np.stack([shape.velocity for shape in shapes], axis=1)
    # rows: end velocity, and end displacement over the duration, so that both are velocities and weigh alike
    ends = np.array([velocity[-1], [shape.displacement[-1] / raw.duration for shape in shapes]])
    wanted = np.array([raw.velocity[-1], raw.displacement[-1] / raw.duration])
    # least squares under two conditions: the smallest square of raw.velocity - velocity c, with ends c = wanted and multipliers for both
    size = len(raw.velocity)
    products = np.einsum("nk,nl->kl", velocity, velocity) / size
    system = np.block([[products, ends.T], [ends, np.zeros((2, 2))]])
    coefficients = _solved(system, np.concatenate([np.einsum("nk,n->k", velocity, raw.velocity) / size, wanted]))[: order + 1]
    polynomial = sum(c * shape.acceleration for c, shape in zip(coefficients, shapes, strict=True))
    return integrate(raw.acceleration - polynomial, raw.step)


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x of matrix x = right for a regular (n, n), by Gauss and Jordan with pivoting.

    LAPACK would round otherwise on another processor, and a kernel would have to be compiled for each n.
    """
    rows = np.column_stack([matrix, right])
    for k in range(len(rows)):
        best = k + int(np.argmax(np.abs(rows[k:, k])))
        rows[[k, best]] = rows[[best, k]]
        rows[k] /= rows[k, k]
        factor = rows[:, k].copy()
        factor[k] = 0.0
        rows -= factor[:, None] * rows[k]
    return np.asarray(rows[:, -1])
