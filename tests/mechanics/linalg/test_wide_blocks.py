# SPDX-License-Identifier: GPL-3.0-or-later
"""Factors of wide blocks, of which nodes use as many rows as they have, against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_cd.mechanics.linalg.factor import BlockFactor
from masonry_cd.mechanics.linalg.ordering import Pattern

N = 20


def matrix(symmetric: bool, symbolic, width: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Blocks whose rows and columns beyond those of their nodes are those of the unit matrix."""
    random, nodes = np.random.default_rng(5), len(width)
    diagonal, lower = random.normal(size=(nodes, N, N)), random.normal(size=(len(symbolic.row), N, N))
    upper = lower if symmetric else random.normal(size=lower.shape)
    diagonal = diagonal + (diagonal.transpose(0, 2, 1) if symmetric else 0.0) + 8.0 * N * np.eye(N)
    diagonal[0, :4, :4] = np.eye(4)[::-1] + (0.0 if symmetric else 0.1)  # needs pivoting
    on = np.arange(N) < width[:, None]
    column = np.repeat(np.arange(nodes), np.diff(symbolic.column))
    diagonal = np.where(on[:, :, None] & on[:, None, :], diagonal, np.eye(N))
    both = on[symbolic.row][:, :, None] & on[column][:, None, :]
    return diagonal, np.where(both, lower, 0.0), np.where(both, upper, 0.0)


@pytest.mark.parametrize("symmetric", [True, False])
@pytest.mark.parametrize("full", [True, False])
def test_wide_blocks_are_factorised_as_dense_ones(symmetric: bool, full: bool) -> None:
    """A comb, whose columns stay alone, some nodes with all rows of a block and some with few."""
    back, tooth = 9, 5
    spine, teeth = np.arange(back), back + np.arange(back * tooth).reshape(back, tooth)
    chains = np.concatenate([spine[:, None], teeth], axis=1)
    first = np.concatenate([spine[:-1], chains[:, :-1].ravel()])
    second = np.concatenate([spine[1:], chains[:, 1:].ravel()])
    nodes = back * (tooth + 1)
    width = np.full(nodes, N) if full else 4 * (1 + np.arange(nodes) % 5)
    pattern = Pattern.of(nodes, first, second)
    assert pattern.has_single_columns
    symbolic = pattern.symbolic if full else pattern.with_width(width).symbolic
    own = width[pattern.order]
    diagonal, lower, upper = matrix(symmetric, symbolic, own)
    dense = np.zeros((nodes, N, nodes, N))
    dense[np.arange(nodes), :, np.arange(nodes), :] = diagonal
    column = np.repeat(np.arange(nodes), np.diff(symbolic.column))
    dense[symbolic.row, :, column, :] = lower
    dense[column, :, symbolic.row, :] = upper.transpose(0, 2, 1)
    whole, size = dense.reshape(nodes * N, nodes * N), np.zeros(N)
    right = np.where(np.arange(N) < own[:, None], np.random.default_rng(6).normal(size=(nodes, N)), 0.0)
    factor, x = BlockFactor.set(symbolic, size, symmetric), right.copy()
    factor.update(diagonal, lower, None if symmetric else upper)
    assert factor.factor() == np.linalg.slogdet(whole).sign
    if not symmetric:
        diagonal[1] *= -1.0
        diagonal[1, 0] *= -1.0
        whole = dense_with(dense, diagonal).reshape(nodes * N, nodes * N)
        factor.update(diagonal, lower, upper)
        assert factor.factor() == np.linalg.slogdet(whole).sign
    factor.solve(x)
    np.testing.assert_allclose(x.ravel(), np.linalg.solve(whole, right.ravel()), rtol=0.0, atol=1e-11 * np.abs(x).max())
    diagonal[3, :4, :4] = 0.0
    diagonal[3, 0] = 0.0
    diagonal[3, :, 0] = 0.0
    if not symmetric:
        factor.update(diagonal, np.zeros_like(lower), np.zeros_like(upper))
        assert factor.factor() == 0.0


def dense_with(dense: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
    """A matrix (N, n, N, n) with other diagonal blocks."""
    out = dense.copy()
    nodes = len(diagonal)
    out[np.arange(nodes), :, np.arange(nodes), :] = diagonal
    return out


def test_operations_count_the_rows_that_nodes_have() -> None:
    """A quarter of the rows in every node, a sixty-fourth of the operations."""
    pattern = Pattern.of(4, np.arange(3), np.arange(1, 4))
    assert pattern.with_width(np.full(4, 4)).operations(16) == pytest.approx(pattern.operations(16) / 64.0)
    assert pattern.with_width(np.full(4, 16)).operations(16) == pytest.approx(pattern.operations(16))
