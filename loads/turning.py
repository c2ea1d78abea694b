# SPDX-License-Identifier: GPL-3.0-or-later
r"""Supports that turn: by an angular velocity over time, or by a rotation vector, axis times angle in world axes; about a point or their
centres of mass.

In a step a block turns by exp(h w / 2) with the velocity of its beginning and again with that of its end. With the rotations H at the
middles of the steps,

    exp(h w_k) = H_k+1/2 H_k-1/2^T,

the orientation at t_k is therefore exp(-h w_k / 2) H_k+1/2, half-way between them, and a rotation that ends at rest ends where it should to
rounding. Of an angular velocity H follows by the same product. A run begins at rest, so that H_1/2 is one and w_0 moves nothing. A block
with its centre at r from the point about which it turns moves by

    v_k = (H_k+1/2 - H_k-1/2) r / h

in addition to what the point does, the trapezoidal rule of which gives r (H_k+1/2 + H_k-1/2) / 2: short of the circle by (h w)^2 / 8, and
not more as time goes on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError

MOST = 0.5  # rotation within a step [rad]: beyond, what stands on the support would be passed through


class Turned(NamedTuple):
    """A rotation on the N + 1 times of a run."""

    velocity: np.ndarray  # (N + 1, 3) w [rad/s]
    middles: np.ndarray  # (N + 2, 3, 3) H from half a step before the first time on

    def of_arm(self, arm: np.ndarray, dt: float) -> np.ndarray:
        """Linear velocity (N + 1, 3) of what is at an arm (3,) as built from the point about which all turns [m/s]."""
        return np.asarray(np.diff(np.sum(self.middles * arm, axis=2), axis=0) / dt)


def by_velocity(velocity: np.ndarray, dt: float, where: str) -> Turned:
    """The rotation by an angular velocity (N + 1, 3) at the times of a run [rad/s].

    Raises:
        InputError: more than MOST within a step.
    """
    _check(dt * velocity, dt, where)
    return Turned(velocity, _products(np.concatenate([_exponential(-dt * velocity[:1]), _exponential(dt * velocity)])))


def by_rotation(at: np.ndarray, dt: float, where: str) -> Turned:
    """The rotation by rotation vectors (N + 2, 3) [rad] at the middles of the steps, from half a step before the first time on.

    Raises:
        InputError: more than MOST within a step.
    """
    _check(np.diff(at, axis=0), dt, where)
    middles = _exponential(at)
    steps = _product(middles[1:], np.swapaxes(middles[:-1], 1, 2))
    skew = 0.5 * np.stack([steps[:, 2, 1] - steps[:, 1, 2], steps[:, 0, 2] - steps[:, 2, 0], steps[:, 1, 0] - steps[:, 0, 1]], axis=1)
    sine = np.sqrt(np.sum(skew * skew, axis=1))
    angle = libm.atan(sine / np.sqrt(np.maximum(1.0 - sine * sine, 1e-300)))
    return Turned(skew * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0)[:, None] / dt, middles)


def _check(steps: np.ndarray, dt: float, where: str) -> None:
    most = float(np.sqrt(np.sum(steps * steps, axis=1)).max(initial=0.0))
    if not most <= MOST:
        raise InputError(where, f"turns by up to {most:.3g} rad within a step of run.dt {dt:g} s, and at most {MOST:g} are followed")


def _exponential(vectors: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) by rotation vectors (n, 3) [rad], Rodrigues."""
    angle = np.sqrt(np.sum(vectors * vectors, axis=1))
    axis = vectors / np.where(angle > 0.0, angle, 1.0)[:, None]
    cosine, sine = libm.cos(angle)[:, None, None], libm.sin(angle)[:, None, None]
    cross = np.zeros((len(vectors), 3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        cross[:, j, i], cross[:, i, j] = axis[:, k], -axis[:, k]
    squared = axis[:, :, None] * axis[:, None, :] - np.eye(3)  # so that what lies along an axis of the world stays there to the bit
    return np.asarray(np.eye(3) + sine * cross + (1.0 - cosine) * squared)


def _product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products (n, 3, 3) of matrices (n, 3, 3)."""
    return np.sum(a[:, :, :, None] * b[:, None, :, :], axis=2)


def _products(factors: np.ndarray) -> np.ndarray:
    """Running products (n, 3, 3), each factor from the left, in log2(n) rounds."""
    out, shift = factors.copy(), 1
    while shift < len(out):
        out[shift:] = _product(out[shift:], out[:-shift])
        shift *= 2
    return out
