# SPDX-License-Identifier: GPL-3.0-or-later
"""Histories that a run keeps in every step at its gauges: guided blocks, points, joints, cracks and supports.

What does not change of them is JSON in the attribute ``gauges`` of the result file, absent where there are none. Of N steps:

    /guides/{force, moment, displacement, momentum} (N, G)     pushes by displacement and props, see mechanics/dynamics/driving.py
    /gauges/points (N, P, 6)     displacement from where it was built and velocity, in the world [m, m/s]
    /gauges/base (N, 6)          likewise of the support to which displacements are relative; zeros without one
    /gauges/joints (N, Q, 8)     opening, sliding [m], normal force, shear force [N], moment about the joint's centre (3) [N m], compressed
                                 depth [m]
    /gauges/cracks (N, K, 3)     how the second point has moved relative to the first [m]
    /gauges/supports (N, S, 3)   forces that supports exert on what they carry, ties that end at them among it [N]
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import h5py

from masonry_cd.foundation.errors import InputError

ATTRIBUTE = "gauges"
JOINT_COLUMNS = ("opening", "sliding", "normal_force", "shear_force", "moment_x", "moment_y", "moment_z", "depth")
GUIDE_COLUMNS = ("force", "moment", "displacement", "momentum")
Vector = tuple[float, ...]


class GuideGauge(NamedTuple):
    """A push by displacement, or a prop."""

    name: str
    kind: str  # push or prop
    direction: Vector
    blocks: tuple[str, ...]


class PointGauge(NamedTuple):
    """A point of a block."""

    name: str
    block: int
    place: Vector  # as built [m]
    relative: bool


class JointGauge(NamedTuple):
    """A joint."""

    name: str
    joint: int


class CrackGauge(NamedTuple):
    """A gauge between two points."""

    name: str
    blocks: tuple[int, int]
    points: tuple[Vector, Vector]  # as built [m]


class SupportGauge(NamedTuple):
    """A fixed block."""

    name: str
    block: int


class Gauges(NamedTuple):
    """All of a run."""

    guides: tuple[GuideGauge, ...] = ()
    points: tuple[PointGauge, ...] = ()
    joints: tuple[JointGauge, ...] = ()
    cracks: tuple[CrackGauge, ...] = ()
    supports: tuple[SupportGauge, ...] = ()

    @property
    def any(self) -> bool:
        """Return True if there is one."""
        return any(self)

    def as_text(self) -> str:
        """As JSON."""
        return json.dumps({name: [one._asdict() for one in ones] for name, ones in self._asdict().items()}, allow_nan=False)


_KINDS: Mapping[str, Any] = {
    "guides": GuideGauge,
    "points": PointGauge,
    "joints": JointGauge,
    "cracks": CrackGauge,
    "supports": SupportGauge,
}


def read_gauges(file: h5py.File) -> Gauges:
    """Those of a result file; none where it has none.

    Raises:
        InputError: they are not what a run writes.
    """
    text = file.attrs.get(ATTRIBUTE)
    if text is None:
        return Gauges()
    try:
        rows = json.loads(str(text))
        return Gauges(
            **{name: tuple(kind(**{k: _tuple(v) for k, v in row.items()}) for row in rows[name]) for name, kind in _KINDS.items()}
        )
    except (ValueError, TypeError, KeyError, AttributeError):
        raise InputError(file.filename, "damaged: its gauges do not have the format of a run") from None


def _tuple(value: Any) -> Any:
    return tuple(map(_tuple, value)) if isinstance(value, list) else value
