# SPDX-License-Identifier: GPL-3.0-or-later
"""The symbolic factor: where the blocks of a sparse matrix and of its factors are stored, and in which order they are computed.

A matrix such as M + H^T R H has one (n, n) block per body and one per pair of bodies that touch. It is factorised as A = L D U, in the
order that a minimum degree ordering gives (see ordering.py), looking left (George & Liu, Computer Solution of Large Sparse Positive
Definite Systems, 1981). D has a dense square block per supernode, kept as its inverse, L and D U one dense panel each, so that most of the
work is products of dense matrices with long inner loops. Panels are stored by columns of L: entry [k, i] belongs to column k of the
supernode and row i below it. A symmetric matrix has U = L^T and no panel of D U; it uses Cholesky, which needs no more memory than the
factors, in the precision of their arrays. Where there is hardly any fill-in (arches, towers, arcades) columns stay alone, their blocks one
after another in plain unrolled loops, which takes a quarter of the time there.

**Subtrees.** The elimination tree is cut into subtrees, and these into levels: subtrees of one level are independent of one another. What a
subtree adds to nodes of later subtrees goes to rows of its own, the ghost rows, which are added up when their node is reached. A subtree's
factors stay in the cache while an iteration substitutes backward into it, visits its contacts and substitutes forward again, which pays
with one thread too. They are stored in the order of backward substitution, when they have to be fetched.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.linalg.elimination_tree import fill_in, neighbours_below, supernodes
from masonry_cd.mechanics.linalg.small_blocks import copy_flat


class SymbolicFactor(NamedTuple):
    """Where the blocks of A and of its factors are, for N nodes in order of elimination and S supernodes."""

    column: np.ndarray  # (N + 1,) starts of the columns of A below the diagonal
    row: np.ndarray  # (B,) rows of its blocks, ascending in each column
    first: np.ndarray  # (S + 1,) first node of each supernode
    start: np.ndarray  # (S + 1,) starts of the rows below each supernode
    below: np.ndarray  # (R,) these rows, ascending in each supernode
    square: np.ndarray  # (S + 1,) starts of the squares of D, in blocks, and the end of all; see factor_storage for their order
    panel: np.ndarray  # (S + 1,) starts of the panels of L and D U likewise
    update_start: np.ndarray  # (S + 1,) starts of the earlier supernodes that update each supernode
    updater: np.ndarray  # (U,) these supernodes, ascending
    update_first: np.ndarray  # (U,) the first of their rows, in ``below``, that is in the updated supernode
    subtree: np.ndarray  # (K + 1,) first supernode of each subtree
    level: np.ndarray  # (Y + 1,) first subtree of each level
    target: np.ndarray  # (R,) row that stands for each of ``below``: the node itself, or a ghost row if the node is in a later subtree
    ghost_start: np.ndarray  # (K + 1,) starts of the ghosts of each subtree; ghost e is row N + 1 + e, after the nodes and the supports
    node_start: np.ndarray  # (N + 1,) starts of the ghosts of each node
    node_ghost: np.ndarray  # (E,) rows of these ghosts, by subtree
    width: np.ndarray  # (N,) rows that each node has, of the n of a block; (0,): n each. No part of the pattern: values, that may change


@kernel()
def pattern_below(start, neighbour):
    """Pattern of A by columns, below the diagonal: starts (N + 1,) and rows, ascending, from the neighbours k < i of each node i."""
    size = len(start) - 1
    column, row = np.zeros(size + 1, dtype=np.int64), np.empty(len(neighbour), dtype=np.int64)
    for k in neighbour:
        column[k + 1] += 1
    for i in range(size):
        column[i + 1] += column[i]
    at = column[:-1].copy()
    for i in range(size):
        for e in range(start[i], start[i + 1]):
            row[at[neighbour[e]]] = i
            at[neighbour[e]] += 1
    return column, row


@kernel()
def rows_below(first, filled, filled_row):
    """Rows of L below each supernode, starts (S + 1,) and rows: those of its last column, which has all that the others have.

    filled (N + 1,) and filled_row are the pattern of L by columns.
    """
    count = len(first) - 1
    start = np.zeros(count + 1, dtype=np.int64)
    for s in range(count):
        start[s + 1] = start[s] + filled[first[s + 1]] - filled[first[s + 1] - 1]
    below = np.empty(start[count], dtype=np.int64)
    for s in range(count):
        copy_flat(filled_row[filled[first[s + 1] - 1] : filled[first[s + 1]]], below[start[s] : start[s + 1]])
    return start, below


@kernel()
def factor_storage(first, start, subtree, size):
    """Starts (S + 1,) of the squares and of the panels, in blocks, and the ends of all.

    Single columns (see has_single_columns) are stored in order; supernodes in the order of backward substitution, the last of a subtree
    first.
    """
    count = len(first) - 1
    square, panel = np.zeros(count + 1, dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    in_order = count == size and len(subtree) == 2
    for q in range(len(subtree) - 1):
        for i in range(subtree[q], subtree[q + 1]):
            s = i if in_order else subtree[q] + subtree[q + 1] - 1 - i
            width = first[s + 1] - first[s]
            square[s], panel[s] = square[count], panel[count]
            square[count] += width * width
            panel[count] += width * (start[s + 1] - start[s])
    return square, panel


@kernel()
def updates_of(first, start, below):
    """For each supernode the earlier ones with a row in it: starts (S + 1,), these supernodes ascending, and the first of their rows."""
    count = len(first) - 1
    owner, update_start = np.empty(first[count], dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    for s in range(count):
        owner[first[s] : first[s + 1]] = s
    updater, update_first, at = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    for writing in range(2):
        for d in range(count):
            for t in range(start[d], start[d + 1]):
                s = owner[below[t]]
                if t > start[d] and owner[below[t - 1]] == s:
                    continue
                if writing:
                    updater[at[s]], update_first[at[s]] = d, t
                    at[s] += 1
                else:
                    update_start[s + 1] += 1
        if not writing:
            for s in range(count):
                update_start[s + 1] += update_start[s]
            updates = update_start[count]
            updater, update_first, at = np.empty(updates, dtype=np.int64), np.empty(updates, dtype=np.int64), update_start[:-1].copy()
    return update_start, updater, update_first


@kernel()
def ghosts_of(first, start, below, subtree, size):
    """The ghost rows: target, ghost_start, node_start and node_ghost, see :class:`SymbolicFactor`."""
    count = len(subtree) - 1
    target, ghost_start = below.copy(), np.zeros(count + 1, dtype=np.int64)
    mark, ghost = np.full(size, -1), np.empty(size, dtype=np.int64)  # by node: the last subtree that has a ghost of it, and its row
    node_start, node_ghost, at = np.zeros(size + 1, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    for writing in range(2):
        mark[:] = -1
        for q in range(count):
            ghost_start[q + 1] = ghost_start[q]
            for s in range(subtree[q], subtree[q + 1]):
                for t in range(start[s], start[s + 1]):
                    j = below[t]
                    if j < first[subtree[q + 1]]:
                        continue
                    if mark[j] != q:
                        mark[j], ghost[j] = q, size + 1 + ghost_start[q + 1]
                        ghost_start[q + 1] += 1
                        if writing:
                            node_ghost[at[j]] = ghost[j]
                            at[j] += 1
                        else:
                            node_start[j + 1] += 1
                    target[t] = ghost[j]
        if not writing:
            for j in range(size):
                node_start[j + 1] += node_start[j]
            node_ghost, at = np.empty(node_start[size], dtype=np.int64), node_start[:-1].copy()
    return target, ghost_start, node_start, node_ghost


@entry()
def analyse(one: np.ndarray, other: np.ndarray, size: int, subtree_node: np.ndarray, level: np.ndarray) -> SymbolicFactor:
    """The symbolic factor for a graph whose nodes are numbered in order of elimination.

    Args:
        one: one end (B,) of each edge, each edge once.
        other: the other end.
        size: number of nodes N.
        subtree_node: (K + 1,) first node of each subtree.
        level: (Y + 1,) first subtree of each level, both as :func:`partition_tree` gives them.
    """
    neighbour_start, neighbour = neighbours_below(one, other, size)
    column, row = pattern_below(neighbour_start, neighbour)
    filled, filled_row = fill_in(neighbour_start, neighbour)
    head = np.zeros(size + 1, dtype=np.bool_)
    for q in range(len(subtree_node)):
        head[subtree_node[q]] = True
    first = supernodes(filled, filled_row, head)
    subtree, q = np.zeros(len(subtree_node), dtype=np.int64), 0
    for s in range(len(first)):
        if first[s] == subtree_node[q]:
            subtree[q] = s
            q += 1
    start, below = rows_below(first, filled, filled_row)
    square, panel = factor_storage(first, start, subtree, size)
    update_start, updater, update_first = updates_of(first, start, below)
    target, ghost_start, node_start, node_ghost = ghosts_of(first, start, below, subtree, size)
    return SymbolicFactor(
        column, row, first, start, below, square, panel, update_start, updater, update_first, subtree, level, target, ghost_start,
        node_start, node_ghost, np.zeros(0, dtype=np.int64),
    )  # fmt: skip


@entry()
def locate(bodies, last, place, column, row, index, block):
    """Into index (C, 2) the places of the bodies of each contact (supports: N), into block (C,) the block that couples them, or -1.

    place (N,) is that of each body, column and row the pattern of A. Returns -1 if a pair of bodies has no block in it, 1 if the bodies are
    those (C, 2) of the ``last`` contacts, else 0.
    """
    size, same = len(place), len(bodies) == len(last)
    for c in range(len(bodies)):
        for side in range(2):
            index[c, side] = place[bodies[c, side]] if bodies[c, side] >= 0 else size
            same = same and bodies[c, side] == last[c, side]
        low, high = min(index[c, 0], index[c, 1]), max(index[c, 0], index[c, 1])
        block[c] = -1
        if high == size or low == high:
            continue
        block[c] = block_at(column, row, low, high)
        if block[c] < 0:
            return -1
    return 1 if same else 0


@borrower()
def block_at(column, row, low, high):
    """The block of A in row ``high`` and column ``low``, below the diagonal; -1 if there is none."""
    first, end = column[low], column[low + 1]
    while first < end:
        middle = (first + end) // 2
        if row[middle] < high:
            first = middle + 1
        else:
            end = middle
    return first if first < column[low + 1] and row[first] == high else -1
