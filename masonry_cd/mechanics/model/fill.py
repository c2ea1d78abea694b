# SPDX-License-Identifier: GPL-3.0-or-later
"""The fill of a bridge: loose material between the masonry and the road, as what it does to the blocks that it touches.

It is not made of blocks. Its weight rides on the blocks below it (blocks.CarriedLoad), it presses on what
stands next to it, it resists what moves into it, and it spreads the wheels on the road. Structures make it, loads ask it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from masonry_cd.foundation import libm

FaceKind = Literal["extrados", "top", "back", "wall"]
COVERED = ("extrados", "top")  # faces on which fill lies, and rides
ACTIVE_AT = (
    0.002  # movement over height of a wall at which sand of medium density is active (Clough & Duncan 1991; dense 0.001, loose 0.004)
)
BARS = "fill of "  # begins the names of the bars by which fill resists: what lists or draws the ties of a structure leaves them out


class FillFace(NamedTuple):
    """A face of a block that the fill touches."""

    block: str
    kind: FaceKind  # extrados of an arch; level top of a pier or an abutment; back of an abutment; inner face of a wall
    corners: np.ndarray  # (n, 3) of a convex polygon, counter-clockwise seen from the fill [m]

    @property
    def area(self) -> np.ndarray:
        """The area vector (3,), which points into the fill [m2]."""
        spokes = self.corners[1:] - self.corners[0]
        return np.asarray(0.5 * np.cross(spokes[:-1], spokes[1:]).sum(axis=0))

    def pressed(self, level: float) -> tuple[float, np.ndarray]:
        """The mean depth below a level (), and the centre of a pressure that grows with depth (3,) [m].

        The integrals of 1, depth and depth times place over triangles, exact by the midpoints of their sides.
        """
        c = self.corners
        whole, moment, size = 0.0, np.zeros(3), 0.0
        for k in range(1, len(c) - 1):
            corner = np.stack([c[0], c[k], c[k + 1]])
            area = 0.5 * float(np.sqrt((np.cross(corner[1] - corner[0], corner[2] - corner[0]) ** 2).sum()))
            middle = 0.5 * (corner + np.roll(corner, -1, axis=0))
            depth = level - middle[:, 2]
            whole, size = whole + area * float(depth.mean()), size + area
            moment = moment + area * (depth[:, None] * middle).mean(axis=0)
        return whole / size, moment / whole if whole else c.mean(axis=0)


@dataclass(frozen=True, eq=False)
class Fill:
    """The fill of one bridge, below a level road."""

    where: str  # the table that describes it
    level: float  # of the road [m]
    density: float  # [kg/m3]
    friction_angle: float  # [degrees]
    spread: Literal["2:1", "boussinesq"]  # of wheels
    pressure: Literal["at_rest", "active", "none"]  # on walls and backs
    passive: float  # share of K_p that is mobilised at most
    passive_shaken: float  # and under an earthquake
    mobilised_at: float  # displacement at which it is [m]
    deck: tuple[float, float]  # first and last place of the road, along it from the origin [m]
    clear: tuple[float, float]  # across it, between the walls [m]
    faces: tuple[FillFace, ...]
    active_at: float = ACTIVE_AT  # movement of a face away over its depth, at which the pressure at rest has fallen to the active one
    gone_at: float | None = None  # over which nothing presses any more; None: by the slope of repose
    slant: float = 0.0  # tangent of the skew
    origin: np.ndarray | None = None  # (3,) of the coordinates along and across [m]; that of the world when None
    turn: np.ndarray | None = None  # (3, 3) from the axes of the bridge to those of the world

    @cached_property
    def coefficients(self) -> dict[str, float]:
        """K_0 (Jaky), K_a and K_p (Rankine)."""
        sine = self._sine
        return {"at_rest": 1.0 - sine, "active": (1.0 - sine) / (1.0 + sine), "passive": (1.0 + sine) / (1.0 - sine), "none": 0.0}

    @cached_property
    def reach(self) -> float:
        """Movement of a face away over its depth, at which nothing presses any more: ``gone_at``, or by the slope of repose.

        Fill next to a wall of height H that moves away by d slumps to slopes of phi; as its volume stays, it reaches up to
        H - sqrt(2 d H tan(phi)) of it, and its pressure, which goes with that height squared, does the work of one that falls evenly to
        nothing over H / (6 tan(phi)). Below 9.5 degrees that would be more than H, which is the most.
        """
        if self.gone_at is not None:
            return self.gone_at
        sine = self._sine
        return 1.0 / max(6.0 * sine / math.sqrt(1.0 - sine * sine), 1.0)

    def shaken(self, factor: float) -> tuple[float, float]:
        """K_AE and K_PE of Mononobe and Okabe: of an upright face without friction, under level fill shaken by ``factor`` times gravity.

        With theta = arctan(factor), towards a face that moves away and away from one that moves in, both of which it hurts,

            K = cos^2(phi - theta) / (cos^2(theta) (1 +- sqrt(sin(phi) sin(phi - theta) / cos(theta)))^2),

        + in K_AE and - in K_PE. Above tan(phi) the fill slides by itself, and K is that at tan(phi), 1 / cos^2(phi), of both.
        """
        sine = self._sine
        cosine = math.sqrt(1.0 - sine * sine)
        x = min(factor, sine / cosine)
        between = sine - x * cosine  # sin(phi - theta) / cos(theta)
        top, root = (cosine + x * sine) ** 2, math.sqrt(sine * between)
        return top / (1.0 + root) ** 2, top / (1.0 - root) ** 2

    @property
    def slides_at(self) -> float:
        """The level acceleration over gravity above which the fill slides by itself, tan(phi)."""
        return self._sine / math.sqrt(1.0 - self._sine**2)

    @property
    def _sine(self) -> float:
        return float(libm.sin(np.radians(np.array([self.friction_angle])))[0])

    def along(self, points: np.ndarray) -> np.ndarray:
        """Coordinates along and across the road, and heights, of points (n, 3) [m]."""
        own = points - (0.0 if self.origin is None else self.origin)
        return np.array(own) if self.turn is None else np.einsum("ni,ij->nj", own, self.turn)

    def in_world(self, point: np.ndarray) -> np.ndarray:
        """The point (3,) at coordinates along and across the road and a height [m]."""
        turned = point if self.turn is None else np.einsum("i,ji->j", point, self.turn)
        return np.asarray(turned + (0.0 if self.origin is None else self.origin))

    def placed(self, name: str, turn: np.ndarray, at: np.ndarray, points: Callable[[np.ndarray], np.ndarray]) -> Fill:
        """The fill of a bridge that is one of several structures, each named and put in its place."""
        faces = tuple(FillFace(f"{name}.{face.block}", face.kind, points(face.corners)) for face in self.faces)
        return replace(self, level=self.level + float(at[2]), faces=faces, origin=np.array([at[0], at[1], 0.0]), turn=turn)


class CoveredFaces(NamedTuple):
    """The G faces of blocks on which fill lies, up to a level."""

    block: np.ndarray  # (G,) number of each
    level: np.ndarray  # (G,) of the road [m]
    start: np.ndarray  # (G + 1,) where its corners begin, and where the last end
    corners: np.ndarray  # (n, 3) at rest, counter-clockwise seen from above [m]

    @property
    def owner(self) -> np.ndarray:
        """The block (n,) of each corner."""
        return np.repeat(self.block, np.diff(self.start))

    @classmethod
    def of(cls, fills: Sequence[Fill], names: Sequence[str]) -> CoveredFaces | None:
        """Those of the fills of a structure, whose blocks have names; None where fill lies on no block."""
        number = {name: k for k, name in enumerate(names)}
        faces = [(number[face.block], fill.level, face.corners) for fill in fills for face in fill.faces if face.kind in COVERED]
        if not faces:
            return None
        corners = [own for *_, own in faces]
        block, level = (np.array([face[k] for face in faces], dtype=kind) for k, kind in ((0, np.int64), (1, float)))
        return cls(block, level, np.cumsum([0, *map(len, corners)]), np.concatenate(corners))
