# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the joints of an assembly: the contact points at rest of each pair of parts, where they span an area.

Structures from files are inexact: their blocks leave gaps and overlaps of micrometres. Such a joint was made without a gap; taken at its
word it would carry only where its blocks have sunk onto one another, on three corners here and one there, and so would the whole structure.
Gaps and overlaps as built up to INEXACT of the smallest width, and MOST_INEXACT, are therefore taken for none (:func:`built_gap`), and
blocks in each other by no more are sound (:mod:`structures.geometry.checks`).
"""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import loop_area
from masonry_cd.mechanics.model.state import State, rotation_matrices

INEXACT = 1e-4  # gaps and overlaps of joints as built, up to this share of the smallest width, are inexact coordinates
MOST_INEXACT = 2e-5  # and no more than this [m]: a fifth of a hairline crack
GAPES = 5e-3  # between faces that look as if they had a joint [m]; floors have 10 mm of play next to walls
SPANS = 1e-2  # of the mean area of joints: what faces another over less looks like no joint


def find_joints(assembly: Assembly) -> Joints:
    """The joints of an assembly as built: every pair of parts whose contact points at rest span an area."""
    contacts, pieces, _ = _touching(assembly)
    corners = [contacts.point[piece] for piece in pieces]
    first = np.array([piece[0] for piece in pieces], dtype=np.int64)
    return Joints(
        block_a=contacts.bodies[first, 1].copy(),  # the normal points from the antagonist to the candidate
        block_b=contacts.bodies[first, 0].copy(),
        area=np.array([loop_area(loop) for loop in corners]),
        normal=contacts.normal[first].copy(),
        polygon_start=np.cumsum([0, *(len(piece) for piece in pieces)]),
        polygon=np.concatenate(corners) if corners else np.zeros((0, 3)),
    )


def joint_parts(assembly: Assembly) -> np.ndarray:
    """The two convex parts (J, 2) of each joint, in the order of :func:`find_joints`: compound blocks share several joints."""
    contacts, pieces, pairs = _touching(assembly)
    return pairs[contacts.pair[[piece[0] for piece in pieces]]].reshape(-1, 2)


def touching_points(assembly: Assembly) -> tuple[ContactSet, np.ndarray]:
    """The contacts at rest (C), also along lines and in points, and the two parts (C, 2) of each."""
    contacts, _, pairs = _touching(assembly)
    return contacts, pairs[contacts.pair]


def loose_contacts(assembly: Assembly) -> int:
    """Pairs of parts that touch along a line or in a point: no joint, though a run has contacts there."""
    contacts, pieces, _ = _touching(assembly)
    return len(np.unique(contacts.pair)) - len(pieces)


def inexactness(width: float) -> float:
    """Gaps and overlaps as built that are inexact coordinates [m], by the smallest width of a free block [m]."""
    return min(INEXACT * width, MOST_INEXACT)


def built_gap(assembly: Assembly) -> float:
    """The largest gap or overlap, as built, of joints that were meant to have none [m]; 0 where coordinates are exact."""
    contacts, pieces, _ = _touching(assembly)
    gaps = np.abs(contacts.gap[np.concatenate(pieces)]) if pieces else np.zeros(0)
    return float(gaps[gaps <= inexactness(assembly.width)].max(initial=0.0))


def gaping(assembly: Assembly, joined: Joints) -> tuple[np.ndarray, np.ndarray]:
    """Blocks (G, 2) that face one another over an area, at most GAPES apart, and share none of its joints; their distances (G,) [m]."""
    near, pieces, _ = _touching(assembly, GAPES)
    width = int(assembly.count)
    known = np.union1d(joined.block_a * width + joined.block_b, joined.block_b * width + joined.block_a)
    least = SPANS * float(joined.area.mean()) if joined.count else 0.0
    found: dict[tuple[int, int], float] = {}
    for piece in pieces:
        a, b = (int(body) for body in near.bodies[piece[0]])
        if a * width + b not in known and loop_area(near.point[piece]) > least:
            found[a, b] = max(found.get((a, b), 0.0), float(near.gap[piece].max()))
    return np.array([*found], dtype=np.int64).reshape(-1, 2), np.array([*found.values()])


def _touching(assembly: Assembly, apart: float = 0.0) -> tuple[ContactSet, list[np.ndarray], np.ndarray]:
    """The contacts at rest, the contacts of each pair of parts that spans an area, and the pairs of parts (P, 2).

    Parts that are ``apart`` by so much [m] count as well.
    """
    state, detector = State.at_rest(assembly), Detector(assembly, corners_only=True)
    still = np.zeros((assembly.count, 6))
    contacts = detector.detect(state.position, rotation_matrices(state.orientation), still, 0.0, apart, np.zeros(3))
    starts = np.flatnonzero(np.diff(contacts.pair, prepend=-1))
    pieces = np.split(np.arange(len(contacts.gap)), starts[1:]) if len(contacts.gap) else []
    return contacts, [piece for piece in pieces if len(piece) >= 3], detector.pairs
