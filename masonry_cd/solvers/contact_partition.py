"""Contacts by subtree of the elimination tree, and where their bodies stand in the order of elimination."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.jit import entry
from masonry_cd.linalg.symbolic import SymbolicFactor


class ContactPartition(NamedTuple):
    """The contacts part by part: each belongs to the part of the one of its two bodies that is eliminated first."""

    contact: np.ndarray  # (C,)
    start: np.ndarray  # (K + 1,) starts of the parts
    place: np.ndarray  # (C, 2) places of the bodies, in this order
    landing: np.ndarray  # (C, 2) rows that stand for them: themselves, or their copies in the part
    spot: np.ndarray  # (C,) blocks that couple them


@entry()
def partition_contacts(index: np.ndarray, spot: np.ndarray, symbolic: SymbolicFactor) -> ContactPartition:
    """Assign contacts, whose bodies are at the places index (C, 2), to the parts of a symbolic; those that meet no body go to the last."""
    contacts, count, size = len(index), len(symbolic.subtree) - 1, len(symbolic.column) - 1
    start, order = np.zeros(count + 1, dtype=np.int64), np.arange(contacts)
    start[count] = contacts
    if count == 1:
        return ContactPartition(order, start, index, index, spot)
    own, row = np.empty(size + 1, dtype=np.int64), np.arange(size + 1)
    for q in range(count):
        own[symbolic.first[symbolic.subtree[q]] : symbolic.first[symbolic.subtree[q + 1]]] = q
    own[size] = count - 1
    start[count] = 0
    for c in range(contacts):
        start[own[min(index[c, 0], index[c, 1])] + 1] += 1
    for q in range(count):
        start[q + 1] += start[q]
    at = start[:-1].copy()
    for c in range(contacts):
        q = own[min(index[c, 0], index[c, 1])]
        order[at[q]] = c
        at[q] += 1
    sorted_index, landing, sorted_spot = (
        np.empty((contacts, 2), dtype=np.int64),
        np.empty((contacts, 2), dtype=np.int64),
        np.empty_like(spot),
    )
    for q in range(count):
        for s in range(symbolic.subtree[q], symbolic.subtree[q + 1]):
            for t in range(symbolic.start[s], symbolic.start[s + 1]):
                row[symbolic.below[t]] = symbolic.target[t]
        for k in range(start[q], start[q + 1]):
            sorted_spot[k] = spot[order[k]]
            for side in range(2):
                b = index[order[k], side]
                sorted_index[k, side] = b
                landing[k, side] = row[b] if own[b] > q else b
    return ContactPartition(order, start, sorted_index, landing, sorted_spot)
