# SPDX-License-Identifier: GPL-3.0-or-later
"""The fill-in of a sparse factor, its supernodes, and its elimination tree cut into subtrees.

Supernodes are neighbouring columns of L with nearly the same rows below the diagonal, factorised together as in CHOLMOD (Chen, Davis,
Hager & Rajamanickam, ACM Trans. Math. Softw. 35, 2008). Large trees are cut into subtrees of about SUBTREE blocks, which are independent of
one another, then what remains into subtrees of twice the size, and so on; those of a level can be worked on at the same time.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import entry, kernel
from masonry_cd.mechanics.linalg.small_blocks import copy_flat

SHORT = 2  # columns: supernodes up to this width may be padded much, see supernodes
WIDEST = 16  # columns that are factorised together
THIN = 4.0  # mean number of rows below a column of L up to which columns stay single: a third to a fifth of the time of factors with 3
SUBTREE = 4096  # blocks of L in a subtree of the first level


@entry()
def neighbours_below(first: np.ndarray, second: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Adjacency of a graph of given edges: for each node i its neighbours k < i, as starts (size + 1,) and neighbours."""
    start = np.zeros(size + 1, dtype=np.int64)
    for e in range(len(first)):
        start[max(first[e], second[e]) + 1] += 1
    for i in range(size):
        start[i + 1] += start[i]
    at = start[:-1].copy()
    neighbour = np.empty(len(first), dtype=np.int64)
    for e in range(len(first)):
        i = max(first[e], second[e])
        neighbour[at[i]] = min(first[e], second[e])
        at[i] += 1
    return start, neighbour


@entry()
def fill_in(start: np.ndarray, neighbour: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pattern of L by columns: starts (size + 1,) and rows below the diagonal, ascending, found along the elimination tree."""
    size = len(start) - 1
    column = np.zeros(size + 1, dtype=np.int64)
    parent, mark, at = np.full(size, -1), np.full(size, -1), np.zeros(size, dtype=np.int64)
    row = np.empty(0, dtype=np.int64)
    for writing in range(2):
        mark[:] = -1
        for i in range(size):
            mark[i] = i
            for e in range(start[i], start[i + 1]):
                k = neighbour[e]
                while mark[k] != i:
                    mark[k] = i
                    if writing:
                        row[at[k]] = i
                        at[k] += 1
                    else:
                        column[k + 1] += 1
                        if parent[k] < 0:
                            parent[k] = i
                    k = parent[k]
        if not writing:
            for i in range(size):
                column[i + 1] += column[i]
            copy_flat(column[:-1], at)
            row = np.empty(column[size], dtype=np.int64)
    return column, row


@entry()
def supernodes(column: np.ndarray, row: np.ndarray, head: np.ndarray) -> np.ndarray:
    """First columns of the supernodes, with the end appended: neighbouring columns of L with nearly the same rows below the diagonal.

    column (N + 1,) and row are the pattern of L. All columns stay single where L has few blocks to a column. ``head`` (N + 1,) marks the
    first columns of subtrees, across which no supernode reaches. A supernode takes in the one before it if that stores few zeros: at most
    these shares of its blocks, more where it is short.
    """
    size, count = len(column) - 1, 0
    if column[size] <= THIN * size:
        return np.arange(size + 1)
    first, zeros = np.empty(size + 1, dtype=np.int64), np.zeros(size + 1)
    for j in range(size):
        start, below, added = j, column[j + 1] - column[j], 0.0
        while count > 0 and not head[start] and column[start] > column[start - 1] and row[column[start - 1]] <= j:
            before = first[count - 1]
            width = j + 1 - before
            more = zeros[count - 1] + (start - before) * (j + 1 - start + below - (column[start] - column[start - 1]))
            share = 0.8 if width <= SHORT else (0.3 if width <= 4 * SHORT else 0.08)
            if width > WIDEST or added + more > share * width * (width + below):
                break
            start, added, count = before, added + more, count - 1
        first[count], zeros[count] = start, added
        count += 1
    first[count] = size
    return first[: count + 1]


@kernel()
def elimination_tree(column, row):
    """Parent of each node (N,), -1 for a root: the first row below the diagonal of its column of L."""
    size = len(column) - 1
    parent = np.full(size, -1)
    for j in range(size):
        if column[j + 1] > column[j]:
            parent[j] = row[column[j]]
    return parent


@kernel()
def postorder(parent):
    """Nodes of a forest (N,): children before parents, subtrees together."""
    size = len(parent)
    child, sibling = np.full(size, -1), np.full(size, -1)
    for j in range(size - 1, -1, -1):
        if parent[j] >= 0:
            sibling[j], child[parent[j]] = child[parent[j]], j
    order, count, stack = np.empty(size, dtype=np.int64), 0, np.empty(size, dtype=np.int64)
    for root in range(size):
        if parent[root] >= 0:
            continue
        depth, stack[0] = 1, root
        while depth > 0:
            j = stack[depth - 1]
            if child[j] >= 0:
                stack[depth], child[j] = child[j], sibling[child[j]]
                depth += 1
            else:
                order[count] = j
                count, depth = count + 1, depth - 1
    return order


@entry()
def partition_tree(first: np.ndarray, second: np.ndarray, size: int, limit: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cut the elimination tree of a graph of given edges, numbered in order of elimination, into subtrees of about ``limit`` blocks of L.

    Returns the nodes subtree by subtree, each in an order of elimination (N,), the starts of the subtrees among them (K + 1,), and the
    starts of the levels among the subtrees (Y + 1,). Where L has few blocks to a column there is one subtree.
    """
    start, neighbour = neighbours_below(first, second, size)
    column, row = fill_in(start, neighbour)
    if column[size] <= THIN * size:  # columns stay single, see supernodes
        limit = column[size] + size
    parent = elimination_tree(column, row)
    post = postorder(parent)
    order, subtree, level = np.empty(size, dtype=np.int64), np.zeros(size + 1, dtype=np.int64), np.zeros(size + 1, dtype=np.int64)
    placed, blocks = np.zeros(size, dtype=np.bool_), np.empty(size, dtype=np.int64)
    done, subtrees, levels = 0, 0, 0
    while done < size:
        for j in range(size):
            blocks[j] = 1 + column[j + 1] - column[j]
        for j in range(size):  # blocks of L in all that remains of the subtree under each node
            if not placed[j] and parent[j] >= 0:
                blocks[parent[j]] += blocks[j]
        filled, begun = 0, done
        for i in range(size):
            j = post[i]
            if placed[j] or blocks[j] > limit:
                continue
            order[done] = j
            done += 1
            if parent[j] < 0 or blocks[parent[j]] > limit:  # the root of a subtree; small ones are taken together
                filled += blocks[j]
                if filled > limit // 2:
                    subtrees, filled = subtrees + 1, 0
                    subtree[subtrees] = done
        if filled > 0:
            subtrees += 1
            subtree[subtrees] = done
        for i in range(begun, done):
            placed[order[i]] = True
        if done > begun:
            levels += 1
            level[levels] = subtrees
        limit *= 2
    if size == 0:  # one subtree all the same
        return order, np.zeros(2, dtype=np.int64), np.arange(2)
    return order, subtree[: subtrees + 1], level[: levels + 1]
