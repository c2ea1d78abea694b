"""Contacts by subtree of the elimination tree and by joint, and where their bodies stand in the order of elimination."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry, kernel
from masonry_cd.mechanics.friction.joint_twists import NUMBERS, JointTwists, fill_frame, find_arm
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.linalg.ghost_rows import nodes_of
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor


class ContactPartition(NamedTuple):
    """The contacts subtree by subtree: each belongs to that of the one of its two bodies that is eliminated first."""

    contact: np.ndarray  # (C,) number of each contact in the problem
    start: np.ndarray  # (K + 1,) first contact of each subtree
    joint: np.ndarray  # (K + 1,) first joint of each subtree
    place: np.ndarray  # (J, 2) places of the bodies of each joint in the order of elimination; supports: N
    target: np.ndarray  # (J, 2) rows that stand for them: the bodies themselves, or their ghosts in the subtree
    block: np.ndarray  # (J,) blocks of the matrix that couple them, or -1
    joints: JointTwists


@entry()
def partition_contacts(
    given: ProblemArrays, index: np.ndarray, block: np.ndarray, symbolic: SymbolicFactor, size_s: tuple[int, ...]
) -> ContactPartition:
    """Assign contacts to subtrees, and in these to joints; contacts between supports go to the last subtree.

    Args:
        given: the problem.
        index: (C, 2) places of the bodies of the contacts.
        block: (C,) blocks that couple them.
        symbolic: of the matrix.
        size_s: as many zeros as a twist has components.
    """
    contact, start = sort_by_subtree(index, symbolic)
    joints = split_into_joints(given, index, contact, start, size_s)
    first, count = joints.start, len(joints.start) - 1
    place = np.empty((count, 2), dtype=np.int64)
    target, own_block = np.empty((count, 2), dtype=np.int64), np.empty(count, dtype=np.int64)
    joint = np.zeros(len(start), dtype=np.int64)
    row = np.arange(len(symbolic.column))  # that stands for each place, seen from subtree q
    g = 0
    for q in range(len(start) - 1):
        _, end = nodes_of(symbolic, q)
        for t in range(symbolic.start[symbolic.subtree[q]], symbolic.start[symbolic.subtree[q + 1]]):
            row[symbolic.below[t]] = symbolic.target[t]
        while g < count and first[g] < start[q + 1]:
            c = contact[first[g]]
            own_block[g] = block[c]
            for side in range(2):
                b = index[c, side]
                place[g, side] = b
                target[g, side] = row[b] if b >= end else b
            g += 1
        joint[q + 1] = g
    return ContactPartition(contact, start, joint, place, target, own_block, joints)


@kernel()
def split_into_joints(given, index, contact, start, size_s):
    """The :class:`JointTwists` of contacts in the order of ``contact`` (C,), which no joint leaves at the starts of subtrees."""
    contacts, bodies, m, shared = len(contact), len(given.v_free), len(given.m), len(size_s) > len(given.m)
    if not shared:
        rows = given.jacobian
        if len(start) > 2:  # of one subtree they are in this order
            rows = np.empty((contacts, 2, m, len(given.n)))
            for c in range(contacts):
                copy_flat(given.jacobian[contact[c]], rows[c])
        return JointTwists(np.arange(contacts + 1), np.empty((0, NUMBERS)), np.empty((0, 3)), rows, size_s)
    first, frame, arm = np.empty(contacts + 1, dtype=np.int64), np.empty((contacts, NUMBERS)), np.empty((contacts, 3))
    joints, q = 0, 0
    for c in range(contacts):
        begins = c == start[q]
        while c == start[q]:
            q += 1
        own, last = contact[c], joints - 1
        if not begins and find_arm(given.jacobian, index, bodies, contact[first[last]], own, frame[last], arm[c]):
            continue
        fill_frame(given.jacobian, index, bodies, own, frame[joints])
        arm[c] = 0.0
        first[joints] = c
        joints += 1
    first[joints] = contacts
    return JointTwists(first[: joints + 1], frame[:joints], arm, np.empty((0, 2, m, len(given.n))), size_s)


@kernel()
def sort_by_subtree(index, symbolic):
    """Contacts (C,) sorted by the subtree of their first body, in order within each, and the starts (K + 1,) of the subtrees."""
    contacts, count, size = len(index), len(symbolic.subtree) - 1, len(symbolic.column) - 1
    start = np.zeros(count + 1, dtype=np.int64)
    start[count] = contacts
    if count == 1:
        return np.arange(contacts), start
    start[count] = 0
    subtree_of = np.empty(size + 1, dtype=np.int64)
    for q in range(count):
        first, end = nodes_of(symbolic, q)
        subtree_of[first:end] = q
    subtree_of[size] = count - 1
    for c in range(contacts):
        start[subtree_of[min(index[c, 0], index[c, 1])] + 1] += 1
    for q in range(count):
        start[q + 1] += start[q]
    at, contact = start[:-1].copy(), np.empty(contacts, dtype=np.int64)
    for c in range(contacts):
        q = subtree_of[min(index[c, 0], index[c, 1])]
        contact[at[q]] = c
        at[q] += 1
    return contact, start
