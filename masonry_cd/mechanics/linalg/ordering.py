# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the blocks of M + H^T R H are, and in which order its factorisation eliminates the bodies.

Symbolic work only: it depends on which bodies touch, not on where, so it lasts while the contact graph stands. The order is an
approximate minimum degree ordering of the body graph (Amestoy, Davis & Duff, SIAM J. Matrix Anal. Appl. 17, 1996), from qdldl.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import qdldl
from scipy import sparse

from masonry_cd.mechanics.linalg.elimination_tree import SUBTREE, partition_tree
from masonry_cd.mechanics.linalg.small_blocks import FULL
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor, analyse, locate

FIELDS = ("pairs", "order", "place", *SymbolicFactor._fields[:-1])  # of a pattern, without the width


@dataclass(frozen=True, eq=False)
class Pattern:
    """Pattern of a block factorisation of N nodes."""

    pairs: np.ndarray  # (E,) pairs of nodes that are coupled, low * N + high, sorted
    order: np.ndarray  # (N,) node at each place
    place: np.ndarray  # (N,) place of each node
    symbolic: SymbolicFactor  # where the blocks are

    @classmethod
    def of(cls, nodes: int, first: np.ndarray, second: np.ndarray, kept: np.ndarray | None = None, in_subtrees: bool = True) -> Pattern:
        """Analyse a graph.

        Args:
            nodes: N.
            first: one end of each edge (E,), may repeat; -1 or equal ends: no edge.
            second: the other end (E,).
            kept: pairs of an earlier pattern to include.
            in_subtrees: whether the elimination tree of a large one is cut into subtrees.
        """
        on = (first >= 0) & (second >= 0) & (first != second)
        pairs = np.unique(np.minimum(first[on], second[on]) * nodes + np.maximum(first[on], second[on]))
        if kept is not None:
            pairs = np.union1d(pairs, kept)
        low, high = pairs // max(nodes, 1), pairs % max(nodes, 1)
        order = _minimum_degree(nodes, low, high)
        place = _places(order)
        regrouped, subtree, level = partition_tree(place[low], place[high], nodes, SUBTREE if in_subtrees else 2**62)
        order = order[regrouped]
        place = _places(order)
        return cls(pairs, order, place, analyse(place[low], place[high], nodes, subtree, level))

    @property
    def has_single_columns(self) -> bool:
        """Return True if each supernode is one node, all of them in one subtree: then the factors are made column by column."""
        return len(self.symbolic.first) == len(self.symbolic.column) and len(self.symbolic.subtree) == 2

    @property
    def nodes(self) -> int:
        """Number of nodes N."""
        return len(self.order)

    @classmethod
    def read(cls, arrays: tuple[np.ndarray, ...]) -> Pattern:
        """A pattern from what :meth:`arrays` gave."""
        pairs, order, place, *symbolic = arrays
        return cls(pairs, order, place, SymbolicFactor(*(*symbolic, FULL)))

    def arrays(self) -> tuple[np.ndarray, ...]:
        """The pattern for a checkpoint, in the order of ``FIELDS``."""
        return (self.pairs, self.order, self.place, *self.symbolic[:-1])

    def with_width(self, width: np.ndarray) -> Pattern:
        """The pattern of nodes with a given number of rows each (N,), in their own order; (0,): all that a block has."""
        return replace(self, symbolic=self.symbolic._replace(width=width[self.order])) if len(width) else self

    def operations(self, n: int) -> float:
        """Operations of an unsymmetric factorisation, for n unknowns per node."""
        nodes, rows = self.symbolic.first, self.symbolic.start
        if len(self.symbolic.width):
            own, other = (np.concatenate([[0.0], np.cumsum(of)]) for of in (self.symbolic.width, self.symbolic.width[self.symbolic.below]))
            width, below = np.diff(own[nodes]), np.diff(other[rows])
        else:
            width, below = n * np.diff(nodes).astype(float), n * np.diff(rows).astype(float)
        return float(4.0 * np.sum(width * (width * width / 2 + width * below + below * below)))

    def locate(self, bodies: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool] | None:
        """Places (C, 2) of the bodies of each contact, the block (C,) that couples them, and whether they are those of the last contacts.

        None if a pair of bodies has no block in the pattern.
        """
        index, block = np.empty((len(bodies), 2), dtype=np.int64), np.empty(len(bodies), dtype=np.int64)
        found = locate(bodies, last, self.place, self.symbolic.column, self.symbolic.row, index, block)
        return None if found < 0 else (index, block, found == 1)


def _places(order: np.ndarray) -> np.ndarray:
    """Place of each node of an order."""
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    return place


def _minimum_degree(nodes: int, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Order of elimination (N,): that in which qdldl factorises the graph's Laplacian plus the identity, which is positive definite."""
    if len(low) == 0:
        return np.arange(nodes)
    ends, all_nodes = np.concatenate([low, high]), np.arange(nodes)
    rows, columns = np.concatenate([all_nodes, low]), np.concatenate([all_nodes, high])
    values = np.concatenate([1.0 + np.bincount(ends, minlength=nodes), np.full(len(low), -1.0)])
    _, _, order = qdldl.Solver(sparse.csc_matrix((values, (rows, columns)), shape=(nodes, nodes)), upper=True).factors()
    return np.asarray(order, dtype=np.int64)
