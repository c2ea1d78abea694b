# SPDX-License-Identifier: GPL-3.0-or-later
"""The courses of vaults: a barrel along y, and the webs and groins of two barrels of one profile that cross.

The voussoirs of the profile (:mod:`structures.courser.arch_profiles`) become courses that run along the vault, in running bond. Of a
crossing, the web towards +x fills x >= |y|: its courses end on the groins, the upright planes x = |y|. Seen from either web a groin is
the same line, so a stone on it has an arm in both webs, a compound block, and the four keystone courses end in one cross-shaped boss.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Shell
from structures.courser.arch_profiles import voussoirs
from structures.courser.bond import even
from structures.geometry.compound_block import compound_block
from structures.geometry.prism import between, prism_xz

LEAST = 0.35  # between a head joint and the groin, in blocks

Groins = dict[tuple[int, float, float], list[Shell]]  # by course and quadrant


def rows(length: float, unit: float, odd: bool) -> np.ndarray:
    """Ends of the blocks of one course (n + 1,) from 0 to the length: whole blocks, or starting with a half."""
    return np.array([0.0, *even(0.0, length, max(1, round(length / unit)), odd), length])


def barrel(
    intrados: np.ndarray,
    extrados: np.ndarray,
    ends: tuple[float, float],
    unit: float,
    density: float,
    bonded: bool = True,
    name: str = "v",
    group: str = "vault",
) -> list[Block]:
    """The blocks of a barrel vault, ``vCOURSE.NUMBER``.

    Args:
        intrados, extrados: ends of the joints (N + 1, 2) x, z [m].
        ends: where the vault begins and ends along y [m].
        unit: length of a block along y [m].
        bonded: False makes separate rings.
    """
    blocks = []
    for k, polygon in enumerate(voussoirs(intrados, extrados)):
        at = ends[0] + rows(ends[1] - ends[0], unit, odd=bonded and k % 2 == 1)
        for i in range(len(at) - 1):
            vertices, faces = prism_xz(polygon, at[i], at[i + 1])
            blocks.append(Block(f"{name}{k + 1}.{i + 1}", vertices, faces, density, group))
    return blocks


def crossing(intrados: np.ndarray, extrados: np.ndarray, end: float, unit: float, density: float) -> list[Block]:
    """The blocks of the webs and groins of a cross vault, without what carries it.

    Args:
        intrados, extrados: ends of the joints (N + 1, 2) x, z of its profile [m].
        end: distance from its middle at which each web ends [m].
        unit: length of a block along its web [m].
    """
    blocks = []
    groins: Groins = {}
    for k, profile in enumerate(voussoirs(intrados, extrados)):
        for web in WEBS:
            blocks += _course(k, len(intrados) - 1, profile, web, end, unit, groins, density)
    for number, parts in enumerate(groins.values(), start=1):
        blocks.append(compound_block(f"groin.{number}", parts, density, "groin"))
    return blocks


@dataclass(frozen=True)
class _Web:
    """One of the four barrels of a cross vault: the one towards +x, turned and mirrored."""

    name: str
    sign: float
    axis: int

    def place(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the web towards +x, put into this web."""
        along = points * [self.sign, 1.0, 1.0]
        return along if self.axis == 0 else along[:, [1, 0, 2]]


WEBS = (_Web("east", 1.0, 0), _Web("north", 1.0, 1), _Web("west", -1.0, 0), _Web("south", -1.0, 1))


def _course(k: int, count: int, profile: np.ndarray, web: _Web, end: float, unit: float, groins: Groins, density: float) -> list[Block]:
    """Course k of one web; its stone on the groin is entered among the parts of the groins."""
    reach = float(np.abs(profile[:, 0]).max())
    shift = 0.5 * (min(k, count - 1 - k) % 2)  # the same on both sides of the crown, so that the arms of a compound stone agree
    heads = math.floor((end - reach) / unit - LEAST - shift + 1e-9)
    ends = [end - (i + shift) * unit for i in range(heads, -1, -1) if i + shift > 0] + [end]
    across = 0.0 if 2 * k + 1 == count else math.copysign(1.0, 2 * k + 1 - count)
    place = (web.sign, across) if web.axis == 0 else (across, web.sign)
    groins.setdefault((min(k, count - 1 - k), *(place if across else (0.0, 0.0))), []).append(_part(profile, None, ends[0], web))
    return [
        Block(f"{web.name}.{k + 1}.{i + 1}", *_part(profile, low, high, web), density, f"web_{web.name}")
        for i, (low, high) in enumerate(pairwise(ends))
    ]


def _part(profile: np.ndarray, low: float | None, high: float, web: _Web) -> Shell:
    """A stretch of a course between two upright planes, or from the groin (None).

    Args:
        profile: (4, 2) y, z of its cross-section: intrados, intrados, extrados, extrados.
    """
    far = np.insert(profile, 0, high, axis=1)
    if low is not None or profile[0, 0] * profile[1, 0] >= 0:
        near = np.insert(profile, 0, np.abs(profile[:, 0]) if low is None else low, axis=1)
        return between(web.place(near), web.place(far))
    (y0, z0), (y1, z1), (y2, z2), (y3, z3) = profile  # a keystone course: its tip is the meeting of both groins
    lower = np.array([(0.0, 0.0, z0), (-y0, y0, z0), (high, y0, z0), (high, y1, z1), (y1, y1, z1)])
    upper = np.array([(0.0, 0.0, z3), (-y3, y3, z3), (high, y3, z3), (high, y2, z2), (y2, y2, z2)])
    return between(web.place(lower), web.place(upper))
