"""Contacts by subtree of the elimination tree, and where their bodies stand in the order of elimination."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.ghost_rows import nodes_of
from masonry_cd.linalg.symbolic import SymbolicFactor


class ContactPartition(NamedTuple):
    """The contacts subtree by subtree: each belongs to that of the one of its two bodies that is eliminated first."""

    contact: np.ndarray  # (C,) number of each contact in the problem
    start: np.ndarray  # (K + 1,) first contact of each subtree
    place: np.ndarray  # (C, 2) places of the bodies in the order of elimination; supports: N
    target: np.ndarray  # (C, 2) rows that stand for them: the bodies themselves, or their ghosts in the subtree
    block: np.ndarray  # (C,) blocks of the matrix that couple them, or -1


@entry()
def partition_contacts(index: np.ndarray, block: np.ndarray, symbolic: SymbolicFactor) -> ContactPartition:
    """Assign contacts to subtrees; those between supports go to the last one.

    Args:
        index: (C, 2) places of their bodies.
        block: (C,) blocks that couple them.
        symbolic: of the matrix.
    """
    contacts, count, size = len(index), len(symbolic.subtree) - 1, len(symbolic.column) - 1
    if count == 1:
        start = np.zeros(2, dtype=np.int64)
        start[1] = contacts
        return ContactPartition(np.arange(contacts), start, index, index, block)
    subtree_of = np.empty(size + 1, dtype=np.int64)
    for q in range(count):
        first, end = nodes_of(symbolic, q)
        subtree_of[first:end] = q
    subtree_of[size] = count - 1
    contact, start = sort_by_subtree(index, subtree_of, count)
    place, target, own_block = np.empty((contacts, 2), dtype=np.int64), np.empty((contacts, 2), dtype=np.int64), np.empty_like(block)
    row = np.arange(size + 1)  # that stands for each place, seen from subtree q
    for q in range(count):
        for t in range(symbolic.start[symbolic.subtree[q]], symbolic.start[symbolic.subtree[q + 1]]):
            row[symbolic.below[t]] = symbolic.target[t]
        for c in range(start[q], start[q + 1]):
            own_block[c] = block[contact[c]]
            for side in range(2):
                b = index[contact[c], side]
                place[c, side] = b
                target[c, side] = row[b] if subtree_of[b] > q else b
    return ContactPartition(contact, start, place, target, own_block)


@kernel()
def sort_by_subtree(index, subtree_of, count):
    """Contacts (C,) sorted by the subtree of their first body, in order within each, and the starts (K + 1,) of the subtrees."""
    contacts, start = len(index), np.zeros(count + 1, dtype=np.int64)
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
