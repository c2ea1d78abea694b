"""The symbolic factor: where the blocks of a sparse matrix and of its factors are stored, and in which order they are made.

A matrix such as M + H^T R H has one (n, n) block per body and one per pair of bodies that touch. It is factorised as A = L D U, in the
order that a minimum degree ordering gives (see ordering.py), looking left (George & Liu, Computer Solution of Large Sparse Positive
Definite Systems, 1981). D has a dense square block per supernode, kept as its inverse, L and D U one dense panel each, so that most of the
work is products of dense matrices with long inner loops. Panels are stored by columns of L: entry [k, i] belongs to column k of the
supernode and row i below it. A symmetric matrix has U = L^T and no panel of D U; it goes by Cholesky, which needs no more room than the
factors, in the precision of their arrays. Where there is hardly any fill-in (arches, towers, arcades) columns stay alone, their blocks one
after another in plain unrolled loops, which takes a quarter of the time there.

**Subtrees.** What a subtree leaves to nodes of later subtrees goes to rows of its own, the ghost rows, which are added up when their node's
turn comes. A subtree's factors stay in the cache while an iteration substitutes backward into it, meets its contacts and substitutes
forward again, which pays with one thread too. They are stored in the order of backward substitution, when they have to be fetched.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.elimination_tree import fill_in, neighbours_below, supernodes
from masonry_cd.linalg.small_blocks import copy_flat


class SymbolicFactor(NamedTuple):
    """Where the blocks of A and of its factors are, for N nodes in order of elimination and S runs of them."""

    column: np.ndarray  # (N + 1,) starts of the columns of A below the diagonal
    row: np.ndarray  # (E,) rows of its blocks, ascending in each column
    first: np.ndarray  # (S + 1,) first node of each run
    start: np.ndarray  # (S + 1,) starts of the rows below each run
    below: np.ndarray  # (R,) these rows, ascending in each run
    square: np.ndarray  # (S + 1,) starts of the squares of D, in blocks, and the end of all; see make_plan for their order
    panel: np.ndarray  # (S + 1,) starts of the panels of L and D U likewise
    pull: np.ndarray  # (S + 1,) starts of the earlier runs that leave something to each run
    puller: np.ndarray  # (U,) these runs, ascending
    entry: np.ndarray  # (U,) the first of their rows that is in the run
    part: np.ndarray  # (K + 1,) starts of the parts, in runs
    level: np.ndarray  # (Y + 1,) starts of the levels, in parts
    target: np.ndarray  # (R,) row that stands for each of ``below``: the node itself, or its copy if it is in a later part
    border: np.ndarray  # (K + 1,) starts of the copies of each part; copy e is row N + 1 + e, after the nodes and the supports' row
    spread: np.ndarray  # (N + 1,) starts of the copies of each node
    copies: np.ndarray  # (E,) rows of these copies, by part


@kernel()
def updates_of(run, begin, below):
    """For each run the earlier ones with a row in it: starts, these runs ascending, and the first of their rows there."""
    count = len(run) - 1
    owner, pull = np.empty(run[count], dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    for s in range(count):
        owner[run[s] : run[s + 1]] = s
    puller, entry, at = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    for writing in range(2):
        for d in range(count):
            for t in range(begin[d], begin[d + 1]):
                s = owner[below[t]]
                if t > begin[d] and owner[below[t - 1]] == s:
                    continue
                if writing:
                    puller[at[s]], entry[at[s]] = d, t
                    at[s] += 1
                else:
                    pull[s + 1] += 1
        if not writing:
            for s in range(count):
                pull[s + 1] += pull[s]
            puller, entry, at = np.empty(pull[count], dtype=np.int64), np.empty(pull[count], dtype=np.int64), pull[:-1].copy()
    return pull, puller, entry


@kernel()
def ghosts_of(run, begin, below, part, size):
    """The copies of a plan: target, border, spread and copies, see :class:`SymbolicFactor`."""
    count = len(part) - 1
    target, border, mark, slot = below.copy(), np.zeros(count + 1, dtype=np.int64), np.full(size, -1), np.empty(size, dtype=np.int64)
    spread, copies, at = np.zeros(size + 1, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    for writing in range(2):
        mark[:] = -1
        for q in range(count):
            border[q + 1] = border[q]
            for s in range(part[q], part[q + 1]):
                for t in range(begin[s], begin[s + 1]):
                    j = below[t]
                    if j < run[part[q + 1]]:
                        continue
                    if mark[j] != q:
                        mark[j], slot[j] = q, size + 1 + border[q + 1]
                        border[q + 1] += 1
                        if writing:
                            copies[at[j]] = slot[j]
                            at[j] += 1
                        else:
                            spread[j + 1] += 1
                    target[t] = slot[j]
        if not writing:
            for j in range(size):
                spread[j + 1] += spread[j]
            copies, at = np.empty(spread[size], dtype=np.int64), spread[:-1].copy()
    return target, border, spread, copies


@entry()
def analyse(first: np.ndarray, second: np.ndarray, size: int, part: np.ndarray, level: np.ndarray) -> SymbolicFactor:
    """The plan for a graph of given edges, each once, whose nodes are numbered in order of elimination.

    part and level are the starts of the parts among the nodes and of the levels among the parts, as :func:`cut` gives them.
    """
    start, neighbour = neighbours_below(first, second, size)
    column, at = np.zeros(size + 1, dtype=np.int64), np.zeros(size, dtype=np.int64)
    row = np.empty(len(neighbour), dtype=np.int64)
    for k in neighbour:
        column[k + 1] += 1
    for i in range(size):
        column[i + 1] += column[i]
        at[i] = column[i]
    for i in range(size):
        for e in range(start[i], start[i + 1]):
            row[at[neighbour[e]]] = i
            at[neighbour[e]] += 1
    filled, its_row = fill_in(start, neighbour)
    head = np.zeros(size + 1, dtype=np.bool_)
    for q in range(len(part)):
        head[part[q]] = True
    run = supernodes(filled, its_row, head)
    count = len(run) - 1
    part_of_runs, q = np.zeros(len(part), dtype=np.int64), 0
    for s in range(count + 1):
        if run[s] == part[q]:
            part_of_runs[q] = s
            q += 1
    begin, square, panel = np.zeros(count + 1, dtype=np.int64), np.zeros(count + 1, dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    for s in range(count):
        begin[s + 1] = begin[s] + filled[run[s + 1]] - filled[run[s + 1] - 1]
    alone = count == size and len(part) == 2  # see has_single_columns; else in the order in which a solve comes down
    for q in range(len(part) - 1):
        for i in range(part_of_runs[q], part_of_runs[q + 1]):
            s = i if alone else part_of_runs[q] + part_of_runs[q + 1] - 1 - i
            width = run[s + 1] - run[s]
            square[s], panel[s] = square[count], panel[count]
            square[count] += width * width
            panel[count] += width * (begin[s + 1] - begin[s])
    below = np.empty(begin[count], dtype=np.int64)
    for s in range(count):  # those of the last column, which has all that the others have
        copy_flat(its_row[filled[run[s + 1] - 1] : filled[run[s + 1]]], below[begin[s] : begin[s + 1]])
    pull, puller, entry = updates_of(run, begin, below)
    target, border, spread, copies = ghosts_of(run, begin, below, part_of_runs, size)
    return SymbolicFactor(
        column, row, run, begin, below, square, panel, pull, puller, entry, part_of_runs, level, target, border, spread, copies
    )


@entry()
def locate(bodies, last, place, column, row, index, spot):
    """Places of the bodies of each contact (supports: one past the last) and the block that couples them, -1 for none.

    Returns -1 if a pair of bodies has no block in the pattern, 1 if the bodies are those of the ``last`` contacts, else 0.
    """
    size, same = len(place), len(bodies) == len(last)
    for c in range(len(bodies)):
        for side in range(2):
            index[c, side] = place[bodies[c, side]] if bodies[c, side] >= 0 else size
            same = same and bodies[c, side] == last[c, side]
        low, high = min(index[c, 0], index[c, 1]), max(index[c, 0], index[c, 1])
        spot[c] = -1
        if high == size or low == high:
            continue
        first, end = column[low], column[low + 1]
        while first < end:
            middle = (first + end) // 2
            if row[middle] < high:
                first = middle + 1
            else:
                end = middle
        if first == column[low + 1] or row[first] != high:
            return -1
        spot[c] = first
    return 1 if same else 0
