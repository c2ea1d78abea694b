# SPDX-License-Identifier: GPL-3.0-or-later
"""The sparse block factorisation against dense linear algebra."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_cd.mechanics.linalg import ordering
from masonry_cd.mechanics.linalg.elimination_tree import SUBTREE, partition_tree
from masonry_cd.mechanics.linalg.factor import BlockFactor
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.linalg.symbolic import analyse


def grid(columns: int, rows: int) -> tuple[int, np.ndarray, np.ndarray]:
    """Nodes of a grid with one diagonal per cell, as blocks of a wall touch, and the ends of its edges."""
    node = np.arange(columns * rows).reshape(rows, columns)
    ends = [(node[:, :-1], node[:, 1:]), (node[:-1], node[1:]), (node[:-1, :-1], node[1:, 1:])]
    first, second = (np.concatenate([pair[side].ravel() for pair in ends]) for side in range(2))
    return columns * rows, first, second


def comb(teeth: int, length: int) -> tuple[int, np.ndarray, np.ndarray]:
    """Nodes of a row of piers whose tops are linked, with one brace, as blocks of an arcade touch, and the ends of its edges."""
    node = np.arange(teeth * length).reshape(teeth, length)
    ends = [(node[:, :-1], node[:, 1:]), (node[:-1, -1], node[1:, -1]), (node[:1, 0], node[1:2, 1])]
    first, second = (np.concatenate([pair[side].ravel() for pair in ends]) for side in range(2))
    return teeth * length, first, second


def test_columns_of_a_thin_structure_stay_alone() -> None:
    nodes, first, second = comb(7, 5)
    symbolic = Pattern.of(nodes, first, second).symbolic
    np.testing.assert_array_equal(symbolic.first, np.arange(nodes + 1))
    assert len(symbolic.below) > len(symbolic.row)  # the brace closes a ring, so there is fill-in


def test_supernodes_hold_all_columns_in_order_with_the_rows_of_each() -> None:
    nodes, first, second = grid(13, 11)
    pattern = Pattern.of(nodes, first, second)
    symbolic, place = pattern.symbolic, pattern.place
    assert symbolic.first[0] == 0
    assert symbolic.first[-1] == nodes
    assert np.diff(symbolic.first).min() > 0
    assert np.diff(symbolic.first).max() > 1
    assert len(symbolic.row) == len(pattern.pairs)
    run = np.repeat(np.arange(len(symbolic.first) - 1), np.diff(symbolic.first))
    for low, high in np.sort(place[np.stack([first, second], axis=1)], axis=1):
        s = run[low]
        assert run[high] == s or high in symbolic.below[symbolic.start[s] : symbolic.start[s + 1]]


@pytest.mark.parametrize("limit", [30, 100, 10**6])
def test_subtrees_of_a_level_are_independent(limit: int) -> None:
    """No edge joins two subtrees of a level, and what a subtree adds to later ones has a ghost row for each of their nodes."""
    nodes, first, second = grid(13, 17)
    place = Pattern.of(nodes, first, second).place
    order, part, level = partition_tree(place[first], place[second], nodes, limit)
    assert sorted(order) == list(range(nodes))
    assert (len(level) > 3) == (limit < 10**6)
    at = np.argsort(order)
    symbolic = analyse(at[place[first]], at[place[second]], nodes, part, level)
    np.testing.assert_array_equal(symbolic.first[symbolic.subtree], part)
    own = np.repeat(np.arange(len(part) - 1), np.diff(part))
    its_level = np.repeat(np.arange(len(level) - 1), np.diff(level))[own]
    ends = np.sort(at[place[np.stack([first, second], axis=1)]], axis=1)
    low, high = own[ends[:, 0]], own[ends[:, 1]]
    assert ((low == high) | (its_level[ends[:, 0]] < its_level[ends[:, 1]])).all()
    # each ghost stands for one node, and belongs to one subtree
    stands_for = np.repeat(np.arange(nodes), np.diff(symbolic.node_start))[np.argsort(symbolic.node_ghost)]
    of_subtree = np.repeat(np.arange(len(part) - 1), np.diff(symbolic.ghost_start))
    assert len({*zip(stands_for, of_subtree, strict=True)}) == len(symbolic.node_ghost)
    run = np.repeat(np.arange(len(symbolic.first) - 1), np.diff(symbolic.start))
    mine = np.repeat(np.arange(len(part) - 1), np.diff(symbolic.subtree))[run]
    is_ghost = symbolic.target > nodes
    np.testing.assert_array_equal(is_ghost, own[symbolic.below] != mine)
    np.testing.assert_array_equal(stands_for[symbolic.target[is_ghost] - nodes - 1], symbolic.below[is_ghost])
    np.testing.assert_array_equal(of_subtree[symbolic.target[is_ghost] - nodes - 1], mine[is_ghost])


@pytest.mark.parametrize("n", [3, 6])
@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("part", [40, SUBTREE])
@pytest.mark.parametrize("graph", [grid(9, 14), comb(7, 9)], ids=["supernodes", "columns"])
def test_a_factorised_matrix_solves_as_a_dense_one_does(
    n: int, symmetric: bool, part: int, graph: tuple[int, np.ndarray, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ordering, "SUBTREE", part)
    nodes, first, second = graph
    symbolic = Pattern.of(nodes, first, second).symbolic
    random = np.random.default_rng(3)
    dense = np.zeros((nodes, n, nodes, n))
    diagonal, lower = random.normal(size=(nodes, n, n)), random.normal(size=(len(symbolic.row), n, n))
    diagonal = diagonal + diagonal.transpose(0, 2, 1) + 12.0 * n * np.eye(n)
    upper = lower if symmetric else random.normal(size=lower.shape)
    if not symmetric:
        diagonal += random.normal(size=diagonal.shape)
    dense[np.arange(nodes), :, np.arange(nodes), :] = diagonal
    column = np.repeat(np.arange(nodes), np.diff(symbolic.column))
    dense[symbolic.row, :, column, :] = lower
    dense[column, :, symbolic.row, :] = upper.transpose(0, 2, 1)
    matrix, right = dense.reshape(nodes * n, nodes * n), random.normal(size=(nodes, n))
    factor, x = BlockFactor.set(symbolic, (0,) * n, symmetric), right.copy()
    factor.update(diagonal, lower, None if symmetric else upper)
    assert factor.factor() == np.linalg.slogdet(matrix).sign
    if not symmetric:
        diagonal[0, 0] *= -1.0
        dense[np.arange(nodes), :, np.arange(nodes), :] = diagonal
        factor.update(diagonal, lower, upper)
        assert factor.factor() == np.linalg.slogdet(matrix).sign
    factor.solve(x)
    np.testing.assert_allclose(x.ravel(), np.linalg.solve(matrix, right.ravel()), rtol=0.0, atol=1e-12 * np.abs(x).max())


@pytest.mark.parametrize("graph", [grid(5, 5), comb(3, 3)], ids=["supernodes", "columns"])
def test_a_singular_block_is_reported(graph: tuple[int, np.ndarray, np.ndarray]) -> None:
    nodes, first, second = graph
    symbolic = Pattern.of(nodes, first, second).symbolic
    diagonal, lower = np.tile(np.eye(3), (nodes, 1, 1)), np.zeros((len(symbolic.row), 3, 3))
    diagonal[4] = 0.0
    for symmetric in (False, True):
        factor = BlockFactor.set(symbolic, (0, 0, 0), symmetric)
        factor.update(diagonal, lower, None if symmetric else lower)
        assert factor.factor() == 0.0
