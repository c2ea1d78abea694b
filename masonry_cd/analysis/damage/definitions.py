# SPDX-License-Identifier: GPL-3.0-or-later
r"""Definitions of opened, slid, separated, fallen and lost, for all outputs: text, tables, pictures, page and summary.

A joint has an opening (the widest gap of its corners), a sliding (of the corners that touch) and a contact area. At any time it

- is **open** when its opening is ``opened`` or more, 0.1 mm by default,
- is **slid** when its sliding is ``slid`` or more, 0.1 mm,
- is **separated** when less than ``lost`` (1 %) of its area is in contact and the blocks cannot find back: either every corner of the
  interface is open by ``apart * sqrt(area)`` or more, ``apart`` 0.1, or the blocks have slid off each other by that much. A
  hinge, which touches along an edge, is not separated, however wide it gapes.

Over a run a joint gets one word, its *state*, by the first rule that holds: *separated* at the end; *opened* or *slid*, when its largest
opening or sliding over all time steps reached the threshold; *intact*. Where it opened and slid, the measure that went
further beyond its threshold names it (a hinge that slipped a little has opened), and such joints are counted apart as "opened and slid".

A free block has **fallen** when, relative to the base, its centre of mass has dropped by more than ``drop`` (half) of its height, or it is
turned by more than ``tilt`` (45 degrees), or all of its joints are separated. A block that has fallen is **lost** to its part, with its
volume; its joints are no cracks any more. A sphere is fill: it rolls and settles without harm. It has
fallen when it has dropped by more than ``drop`` of its height and lies outside the plan of the structure, the rectangle around all of its
free blocks as built: what runs out of a wall does, what is poured into a box does not.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.pauses import DROP, TILT, outside
from masonry_cd.mechanics.model.joints import Joints

STATES = ("intact", "opened", "slid", "separated")
INTACT, OPENED, SLID, SEPARATED = range(4)


@dataclass(frozen=True)
class Thresholds:
    """Where damage begins. The defaults suit buildings; set them for models at another scale.

    Attributes:
        opened: smallest opening of an opened joint [m]. 0.1 mm is a hairline crack, the smallest seen by eye (Burland, Broms & de
            Mello, Behaviour of foundations and structures, 1977), and a hundred times what a converged run leaves as gap.
        slid: smallest sliding of a slid joint [m]. 0.1 mm likewise: dry joints without stiffness do not slip elastically.
        apart: distance of a separated joint as a share of the square root of its area.
        lost: share of the area below which a contact counts as wholly lost.
        drop: drop of a fallen block's centre as a share of its height.
        tilt: turn of a fallen block [degrees].
    """

    opened: float = 1e-4
    slid: float = 1e-4
    apart: float = 0.1
    lost: float = 0.01
    drop: float = DROP
    tilt: float = TILT

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not (np.isfinite(value) and value > 0):
                raise InputError(f"thresholds.{item.name}", f"must be positive, got {value!r}")

    def in_words(self) -> str:
        """The thresholds that count joints and blocks, in a sentence."""
        return (
            f"Opened: by {1e3 * self.opened:.3g} mm or more; slid: by {1e3 * self.slid:.3g} mm or more, at any time step. "
            f"Separated: no contact left at the end. Fallen: dropped by {100 * self.drop:.3g} % of its height, turned by "
            f"{self.tilt:g} degrees, or all joints separated."
        )


def is_open(opening: np.ndarray, thresholds: Thresholds) -> np.ndarray:
    """True where an opening [m] counts."""
    return np.asarray(opening >= thresholds.opened)


def is_slid(sliding: np.ndarray, thresholds: Thresholds) -> np.ndarray:
    """True where a sliding [m] counts."""
    return np.asarray(sliding >= thresholds.slid)


def classify(opening: np.ndarray, sliding: np.ndarray, separated: np.ndarray, thresholds: Thresholds) -> np.ndarray:
    """Index into STATES of each joint, (J,), by its largest opening and sliding over the run [m] and whether it is separated in the end."""
    codes = np.where(opening / thresholds.opened >= sliding / thresholds.slid, OPENED, SLID)
    codes[~(is_open(opening, thresholds) | is_slid(sliding, thresholds))] = INTACT
    codes[separated] = SEPARATED
    return codes


def parted(joints: Joints, gap: np.ndarray, sliding: np.ndarray, contact_area: np.ndarray, thresholds: Thresholds) -> np.ndarray:
    """(J,) True where a joint with a smallest gap [m], sliding [m] and contact area [m2], (J,) each, is separated."""
    limit = thresholds.apart * np.sqrt(joints.area)
    return np.asarray((contact_area <= thresholds.lost * joints.area) & ((gap >= limit) | (sliding >= limit)))


def fallen_in(joints: Joints, solids: Solids, pose: Pose, separated: np.ndarray, thresholds: Thresholds) -> np.ndarray:
    """(B,) True where a free block has fallen in a pose whose separated joints (J,) are known."""
    dropped = -pose.displacement(solids)[:, 2] > thresholds.drop * solids.sizes[:, 2]
    turn = np.degrees(np.arccos(np.clip((np.trace(pose.rotation, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0)))
    ends = np.concatenate([joints.block_a, joints.block_b]).astype(np.int64)
    owned = np.bincount(ends, minlength=len(solids.centre))
    loose = (owned > 0) & (np.bincount(ends, np.tile(separated, 2).astype(float), minlength=len(solids.centre)) == owned)
    down = dropped | (turn > thresholds.tilt) | loose
    if solids.round is not None and solids.plan is not None:
        down = np.where(solids.round, dropped & outside(solids.plan, pose.position), down)
    return np.asarray(~solids.fixed & down)
