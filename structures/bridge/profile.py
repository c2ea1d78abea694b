# SPDX-License-Identifier: GPL-3.0-or-later
r"""The rings of one span: where its joints begin and end in the x-z plane of the road.

The intrados is a circle by span s and rise f, R = (s^2/4 + f^2) / (2 f), two circles that meet in a point, or half an ellipse
(2 x / s)^2 + (z / f)^2 = 1. Joints are normal to it. With the unit normal n_k at the k-th of N + 1 joints and the thickness t_k, which
grows linearly from the crown to the springings, line r of n rings is intrados_k + (r / n) t_k n_k.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation import libm
from structures.bridge.table import SpanTable
from structures.courser.arch_profiles import RingTable, joints_of, mirrored

FINE = 2000  # pieces into which half an ellipse is cut to measure its length
LEAST_CHORD = 0.2  # of a voussoir by default [m]
CHORD = 0.6  # or this share of the thickness of its ring


@dataclass(frozen=True, eq=False)
class SpanProfile:
    """A span in its place: L = rings + 1 lines with N + 1 points each."""

    lines: np.ndarray  # (L, N + 1, 2) x, z from the intrados outwards, from left to right [m]

    @property
    def intrados(self) -> np.ndarray:
        """(N + 1, 2) [m]."""
        return np.asarray(self.lines[0])

    @property
    def extrados(self) -> np.ndarray:
        """(N + 1, 2) [m]."""
        return np.asarray(self.lines[-1])

    @property
    def axis(self) -> float:
        """x of its middle [m]."""
        return 0.5 * float(self.intrados[0, 0] + self.intrados[-1, 0])

    @property
    def crown(self) -> float:
        """Height of the highest point of the extrados [m]."""
        return float(self.extrados[:, 1].max())


def rise_of(span: SpanTable) -> float:
    """The rise of the intrados [m]; of a semicircle half the span, of others where it is given."""
    return 0.5 * span.span if span.rise is None else span.rise


def voussoirs_of(span: SpanTable) -> int:
    """How many voussoirs a ring has: as given, or an odd number, of a pointed arch an even one."""
    if span.voussoirs is not None:
        return span.voussoirs
    chord = max(LEAST_CHORD, CHORD * span.thickness / span.rings)
    rise = rise_of(span)
    length = math.hypot(span.span, 4.0 / math.sqrt(3.0) * rise)  # of a flat arc; of a semicircle 3 % too short
    half = max(4, round(0.5 * length / chord))
    return min(2 * half, 400, 2 * _most_to_the_apex(span)) if span.shape == "pointed" else min(2 * half + 1, 399)


def _most_to_the_apex(span: SpanTable) -> int:
    """How many voussoirs half a pointed arch may have, the last intrados, which the upright joint cuts short, half as long as others."""
    radius = (0.25 * span.span**2 + rise_of(span) ** 2) / span.span
    offset = radius - 0.5 * span.span
    middle, inner = (math.acos(offset / r) for r in (radius + 0.5 * span.thickness, radius))
    return max(2, int(0.5 * middle / (middle - inner)))


def profile_of(span: SpanTable, left: float) -> SpanProfile:
    """The rings of a span whose keys are sound and whose left springing is at x = ``left`` [m]."""
    count = voussoirs_of(span)
    points, normals = _ellipse(span, count) if span.shape == "elliptical" else _circles(span, count)
    springing = span.thickness if span.thickness_springing is None else span.thickness_springing
    share = np.abs(2.0 * np.arange(count + 1) / count - 1.0)
    thickness = span.thickness + (springing - span.thickness) * share
    out = np.linspace(0.0, 1.0, span.rings + 1)[:, None] * thickness
    lines = points + out[:, :, None] * normals
    return SpanProfile(lines + [left + 0.5 * span.span, span.springing])


def _circles(span: SpanTable, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of the intrados and their outward normals (N + 1, 2) of a circle or a pointed arch about x = 0."""
    shape = "pointed" if span.shape == "pointed" else "circular"
    keys = {"shape": shape, "span": span.span, "rise": rise_of(span), "thickness": span.thickness, "voussoirs": count}
    inner, outer = joints_of(RingTable.model_validate(keys))
    return inner, (outer - inner) / span.thickness


def _ellipse(span: SpanTable, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points at even distances along half an ellipse, and its outward normals, (N + 1, 2)."""
    a, b = 0.5 * span.span, rise_of(span)
    angle = 0.5 * math.pi * np.arange(FINE + 1) / FINE  # from the springing up
    fine = np.stack([-a * libm.cos(angle), b * libm.sin(angle)], axis=1)
    length = np.concatenate([[0.0], np.cumsum(np.sqrt((np.diff(fine, axis=0) ** 2).sum(axis=1)))])
    wanted = 2.0 * length[-1] * np.arange(count // 2 + 1) / count
    angle = np.interp(wanted, length, angle)
    c, s = libm.cos(angle), libm.sin(angle)
    left, normal = np.stack([-a * c, b * s], axis=1), np.stack([-b * c, a * s], axis=1)
    normal /= np.sqrt((normal**2).sum(axis=1))[:, None]
    return mirrored(left, count), mirrored(normal, count)
