# SPDX-License-Identifier: GPL-3.0-or-later
"""Contacts by subtree of the elimination tree, by joint, and by groups of four joints, and where their bodies stand in the order of
elimination."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import entry, kernel
from masonry_cd.mechanics.friction.contact_geometry import shares_faces
from masonry_cd.mechanics.friction.contact_groups import FIELDS, NUMBERS, ContactGroups
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.linalg.ghost_rows import nodes_of
from masonry_cd.mechanics.linalg.sorting import sorted_by
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.vectors import LANES


@entry()
def group_contacts(
    given: ProblemArrays, index: np.ndarray, block: np.ndarray, symbolic: SymbolicFactor, size_s: tuple[int, ...]
) -> ContactGroups:
    """Assign contacts to groups of joints, within subtrees; contacts between supports go to the last subtree.

    The frames and the table are to be filled by :func:`masonry_cd.mechanics.friction.contact_groups.fill_group`.

    Args:
        given: the problem.
        index: (C, 2) places of the bodies of the contacts.
        block: (C,) blocks that couple them.
        symbolic: of the matrix.
        size_s: as many zeros as a twist has components.
    """
    (contact, begin), s, size = sort_by_subtree(index, symbolic), len(size_s), len(symbolic.column) - 1
    shared = s > len(given.m)
    first, joint = split_into_joints(given, contact, begin, shared)
    order, subtree, start = group_joints(first, joint)
    groups, rows = len(start) - 1, start[-1]
    contact_of, block_of = np.full((rows, LANES), -1, dtype=np.int64), np.full((groups, LANES), len(symbolic.row), dtype=np.int64)
    place, target = np.full((groups, 2 * LANES), size, dtype=np.int64), np.full((groups, 2 * LANES), size, dtype=np.int64)
    row = np.arange(size + 1)  # that stands for each place, seen from subtree q
    for q in range(len(begin) - 1):
        _, end = nodes_of(symbolic, q)
        for t in range(symbolic.start[symbolic.subtree[q]], symbolic.start[symbolic.subtree[q + 1]]):
            row[symbolic.below[t]] = symbolic.target[t]
        for k in range(joint[q], joint[q + 1]):
            g, lane, j = subtree[q] + (k - joint[q]) // LANES, (k - joint[q]) % LANES, order[k]
            for t in range(first[j + 1] - first[j]):
                contact_of[start[g] + t, lane] = contact[first[j] + t]
            c = contact[first[j]]
            block_of[g, lane] = block[c] if block[c] >= 0 else len(symbolic.row)
            for side in range(2):
                b = index[c, side]
                place[g, LANES * side + lane] = b
                target[g, LANES * side + lane] = row[b] if b >= end else b
    of_h = 0 if shared else groups
    return ContactGroups(
        subtree, start, contact_of, place, target, block_of, np.empty((groups - of_h, NUMBERS * LANES)),
        np.empty((of_h, 2 * s * len(given.n) * LANES)), np.empty((rows, FIELDS * LANES)), size_s,
    )  # fmt: skip


@kernel()
def split_into_joints(given, contact, begin, shared):
    """First contact (J + 1,) of each joint, of contacts in the order of ``contact`` (C,), and the first joint (K + 1,) of each subtree.

    Each contact is a joint of its own if they are not ``shared``.
    """
    contacts, bodies = len(contact), given.bodies
    first, joint, joints = np.empty(contacts + 1, dtype=np.int64), np.empty(len(begin), dtype=np.int64), 0
    for q in range(len(begin) - 1):
        joint[q] = joints
        for c in range(begin[q], begin[q + 1]):
            if not shared or c == begin[q] or not shares_faces(given.geometry, bodies, contact[first[joints - 1]], contact[c]):
                first[joints] = c
                joints += 1
    first[joints] = contacts
    joint[-1] = joints
    return first[: joints + 1], joint


@kernel()
def group_joints(first, joint):
    """Joints (J,) subtree by subtree, those of most contacts first, and ``subtree`` and ``start`` of the groups that fours of them make."""
    key, subtree, groups, most = np.empty(len(first) - 1, dtype=np.int64), np.zeros(len(joint), dtype=np.int64), 0, 0
    for j in range(len(key)):
        most = max(most, first[j + 1] - first[j])
    for q in range(len(joint) - 1):
        subtree[q + 1] = subtree[q] + (joint[q + 1] - joint[q] + LANES - 1) // LANES
        for j in range(joint[q], joint[q + 1]):
            key[j] = (q + 1) * most - (first[j + 1] - first[j])
    order, _ = sorted_by(key, (len(joint) - 1) * most)
    start = np.zeros(subtree[-1] + 1, dtype=np.int64)
    for q in range(len(joint) - 1):
        for k in range(joint[q], joint[q + 1], LANES):
            start[groups + 1] = start[groups] + first[order[k] + 1] - first[order[k]]
            groups += 1
    return order, subtree, start


@kernel()
def sort_by_subtree(index, symbolic):
    """Contacts (C,) sorted by the subtree of their first body, in order within each, and the starts (K + 1,) of the subtrees."""
    count, size = len(symbolic.subtree) - 1, len(symbolic.column) - 1
    subtree_of, own = np.full(size + 1, count - 1, dtype=np.int64), np.zeros(len(index), dtype=np.int64)
    for q in range(count):
        first, end = nodes_of(symbolic, q)
        subtree_of[first:end] = q
    for c in range(len(index) if count > 1 else 0):
        own[c] = subtree_of[min(index[c, 0], index[c, 1])]
    return sorted_by(own, count)
