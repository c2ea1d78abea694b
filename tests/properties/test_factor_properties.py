# SPDX-License-Identifier: GPL-3.0-or-later
"""The sparse block factors against dense linear algebra, on random graphs, whole and cut into subtrees."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_cd.mechanics.linalg import ordering
from masonry_cd.mechanics.linalg.elimination_tree import THIN
from masonry_cd.mechanics.linalg.factor import BlockFactor
from masonry_cd.mechanics.linalg.ordering import Pattern


class Matrix(NamedTuple):
    """A block matrix over a graph of N nodes, by nodes as the user numbers them, and a right-hand side."""

    edges: np.ndarray  # (E, 2), low end first, each once
    dense: np.ndarray  # (N, n, N, n)
    right: np.ndarray  # (N, n)

    @property
    def square(self) -> np.ndarray:
        """The matrix (N n, N n)."""
        return self.dense.reshape(self.right.size, self.right.size)


def solution(matrix: Matrix, symmetric: bool) -> np.ndarray | None:
    """x (N, n) by the block factors, None where the factorisation reports that there are none. All calls of linalg are here."""
    nodes, n = matrix.right.shape
    pattern = Pattern.of(nodes, matrix.edges[:, 0], matrix.edges[:, 1])
    symbolic, order = pattern.symbolic, pattern.order
    column = np.repeat(np.arange(nodes), np.diff(symbolic.column))
    diagonal = matrix.dense[order, :, order, :].copy()
    lower = matrix.dense[order[symbolic.row], :, order[column], :].copy()
    upper = matrix.dense[order[column], :, order[symbolic.row], :].transpose(0, 2, 1).copy()
    factor, x = BlockFactor.set(symbolic, (0,) * n, symmetric), matrix.right[order].copy()
    factor.update(diagonal, lower, None if symmetric else upper)
    if factor.factor() == 0.0:
        return None
    factor.solve(x)
    return x[pattern.place]


NODES, DENSITY = st.integers(1, 40), st.sampled_from([0.02, 0.1, 0.3, 1.0])


@st.composite
def matrices(
    draw: st.DrawFn,
    n: int,
    symmetric: bool,
    dominant: bool = True,
    nodes: st.SearchStrategy[int] = NODES,
    density: st.SearchStrategy[float] = DENSITY,
) -> Matrix:
    """Blocks of size n over a graph of 1 to 40 nodes, from loose to complete; diagonally dominant ones have factors without pivots."""
    count, share = draw(nodes), draw(density)
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    first, second = np.triu_indices(count, 1)
    on = random.random(len(first)) < share
    edges = np.column_stack([first[on], second[on]])
    dense = np.zeros((count, n, count, n))
    for i, j in edges:
        dense[i, :, j, :] = random.normal(size=(n, n))
        dense[j, :, i, :] = dense[i, :, j, :].T if symmetric else random.normal(size=(n, n))
    for i in range(count):
        own = random.normal(size=(n, n))
        dense[i, :, i, :] = own + own.T if symmetric else own
    square = dense.reshape(count * n, count * n)
    if dominant:
        square[np.diag_indices(count * n)] = 1.0 + np.maximum(np.abs(square).sum(axis=0), np.abs(square).sum(axis=1))
    scale = 10.0 ** draw(st.integers(-12, 12))
    return Matrix(edges, scale * dense, random.normal(size=(count, n)))


@pytest.mark.parametrize("n", [3, 6])
@pytest.mark.parametrize("symmetric", [True, False], ids=["cholesky", "ldu"])
@given(data=st.data())
def test_the_factors_solve(n: int, symmetric: bool, data: st.DataObject) -> None:
    matrix = data.draw(matrices(n, symmetric))
    x = solution(matrix, symmetric)
    assert x is not None
    left = matrix.square @ x.ravel() - matrix.right.ravel()
    assert np.abs(left).max() <= 1e-12 * np.abs(matrix.right).max()


@pytest.mark.parametrize("symmetric", [True, False], ids=["cholesky", "ldu"])
@pytest.mark.parametrize("limit", [1, 4, 15])
@given(data=st.data())
def test_subtrees_change_the_order_of_the_work_and_not_the_answer(limit: int, symmetric: bool, data: st.DataObject) -> None:
    matrix = data.draw(matrices(3, symmetric))
    whole = solution(matrix, symmetric)
    assert whole is not None
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ordering, "SUBTREE", limit)
        cut = solution(matrix, symmetric)
    assert cut is not None
    np.testing.assert_allclose(cut, whole, rtol=0.0, atol=1e-12 * np.abs(whole).max())


@pytest.mark.parametrize("n", [3, 6])
@pytest.mark.parametrize("graph", ["loose", "complete"])
@given(data=st.data())
def test_cholesky_takes_what_is_positive_definite_and_nothing_that_it_cannot_solve(n: int, graph: str, data: st.DataObject) -> None:
    """Dominant or not: the least eigenvalue is shifted to either side of zero. Indefinite ones are refused where there are supernodes; in
    loose graphs, whose columns stay alone, they may be factorised as L D L^T, and then the answer has to be right."""
    nodes, density = (st.integers(int(2 * THIN) + 2, 40), st.just(1.0)) if graph == "complete" else (NODES, DENSITY)
    matrix = data.draw(matrices(n, True, dominant=False, nodes=nodes, density=density))
    eigenvalues = np.linalg.eigvalsh(matrix.square)
    size = np.abs(eigenvalues).max()
    shift = data.draw(st.sampled_from([-1e-3, 1e-3])) * size
    matrix.square[np.diag_indices(matrix.right.size)] += shift - eigenvalues[0]
    x = solution(matrix, True)
    assert x is not None or shift < 0.0
    assert x is None or shift > 0.0 or graph == "loose"
    if x is not None:
        np.testing.assert_allclose(x.ravel(), np.linalg.solve(matrix.square, matrix.right.ravel()), rtol=0.0, atol=1e-6 * np.abs(x).max())


@pytest.mark.parametrize("n", [3, 6])
@pytest.mark.parametrize("symmetric", [True, False], ids=["cholesky", "ldu"])
@given(data=st.data())
def test_a_node_that_nothing_holds_is_reported(n: int, symmetric: bool, data: st.DataObject) -> None:
    """Its rows and columns are zero, all of them or one direction only."""
    matrix = data.draw(matrices(n, symmetric))
    node, directions = data.draw(st.integers(0, len(matrix.right) - 1)), data.draw(st.sampled_from([slice(None), slice(0, 1)]))
    matrix.dense[node, directions] = 0.0
    matrix.dense[:, :, node, directions] = 0.0
    assert solution(matrix, symmetric) is None
