# SPDX-License-Identifier: GPL-3.0-or-later
"""Floats in registers: what is loaded, added and stored is what entries one by one give, in both precisions and across them."""

from __future__ import annotations

import numpy as np
import pytest
from numba.core.errors import TypingError
from numpy.testing import assert_allclose, assert_array_equal

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.linalg.vectors import (
    add_six_times,
    add_times,
    fill_eight,
    fill_four,
    fill_six,
    gather,
    gather_six,
    load_eight,
    load_four,
    load_six,
    pack_six,
    root_of,
    scatter,
    scatter_six,
    store_lanes,
    store_six,
    sum_of,
    where_at_most,
)


@entry()
def four(a, factor, x, out):
    """Four entries of out from (1, 2) on: those of a from (2, 1) on and factor times those of x from (0, 3) on."""
    store_lanes(out, 1, 2, add_times(load_four(a, 2, 1), factor, load_four(x, 0, 3)))


@entry()
def eight(a, factor, x, out):
    """As :func:`four`, of eight."""
    store_lanes(out, 1, 2, add_times(load_eight(a, 2, 1), factor, load_eight(x, 0, 3)))


@entry()
def six(a, factor, x, out):
    """As :func:`four`, of six."""
    store_six(out, 1, 2, add_six_times(load_six(a, 2, 1), factor, load_six(x, 0, 3)))


@entry()
def filled(value, out):
    """Four, eight and six times a value into the first rows of out."""
    store_lanes(out, 0, 0, fill_four(value))
    store_lanes(out, 1, 0, fill_eight(value))
    store_six(out, 2, 0, fill_six(value))


@entry()
def packed(x, out):
    """The first six of x into out, backwards."""
    store_six(out, 0, 0, pack_six(x[5], x[4], x[3], x[2], x[1], x[0]))


@pytest.mark.parametrize("out_kind", [np.float64, np.float32])
@pytest.mark.parametrize("x_kind", [np.float64, np.float32])
@pytest.mark.parametrize("a_kind", [np.float64, np.float32])
@pytest.mark.parametrize(("kernel", "count"), [(four, 4), (six, 6), (eight, 8)])
def test_a_row_and_a_multiple_of_another_are_added_and_nothing_else_is_touched(kernel, count, a_kind, x_kind, out_kind):
    generator = np.random.default_rng(1)
    a, x = generator.normal(size=(3, 11)).astype(a_kind), generator.normal(size=(2, 11)).astype(x_kind)
    out, factor = np.full((3, 12), 7.0, dtype=out_kind), 0.7
    kernel(a, factor, x, out)
    expected = np.full((3, 12), 7.0)
    expected[1, 2 : 2 + count] = a[2, 1 : 1 + count] + 0.7 * x[0, 3 : 3 + count].astype(float)
    roughest = max(np.finfo(kind).eps for kind in (a_kind, out_kind))  # the sum is in the precision of a
    assert_allclose(out, expected, rtol=8 * roughest, atol=8 * roughest)
    untouched = np.ones(out.shape, dtype=bool)
    untouched[1, 2 : 2 + count] = False
    assert_array_equal(out[untouched], 7.0)


def test_a_value_fills_all_places():
    out = np.zeros((3, 9))
    filled(0.3, out)
    assert_array_equal(out, [[0.3] * 4 + [0.0] * 5, [0.3] * 8 + [0.0], [0.3] * 6 + [0.0] * 3])


def test_floats_are_packed_in_their_order():
    out = np.zeros((1, 7))
    packed(np.arange(1.0, 7.0), out)
    assert_array_equal(out, [[6.0, 5.0, 4.0, 3.0, 2.0, 1.0, 0.0]])


def test_rows_of_a_matrix_that_is_not_contiguous_are_refused():
    with pytest.raises(TypingError, match="load_four"):
        four(np.zeros((3, 24))[:, ::2], 1.0, np.zeros((2, 11)), np.zeros((3, 12)))


@entry()
def calculated(x, out):
    """Apply the operators to the rows of x (2, 4): sum, difference, product, quotient, twice, root, the smaller one, and a sum of all."""
    a, b = load_four(x, 0, 0), load_four(x, 1, 0)
    store_lanes(out, 0, 0, a + b)
    store_lanes(out, 1, 0, a - b)
    store_lanes(out, 2, 0, a * b)
    store_lanes(out, 3, 0, a / b)
    a += a
    store_lanes(out, 4, 0, 0.5 * a - 1.0)
    store_lanes(out, 5, 0, root_of(b))
    store_lanes(out, 6, 0, where_at_most(a, b, a, b))
    out[7, 0] = sum_of(a)


@entry()
def moved(matrix, rows, out):
    """Add to rows[0, 4:] of out the rows[0, :4] of a matrix, all six columns and then column 2 to column 1."""
    scatter_six(out, rows, 0, 4, gather_six(matrix, rows, 0, 0))
    scatter(out, rows, 0, 4, 1, gather(matrix, rows, 0, 0, 2))


def test_operators_work_place_by_place():
    a, b = np.array([1.0, -2.0, 3.0, 0.5]), np.array([4.0, 0.25, 3.0, 9.0])
    out = np.zeros((8, 4))
    calculated(np.array([a, b]), out)
    assert_array_equal(out[:7], [a + b, a - b, a * b, a / b, a - 1.0, np.sqrt(b), np.minimum(2.0 * a, b)])
    assert out[7, 0] == 2.0 * a.sum()


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_rows_are_gathered_and_added_to_others_which_may_be_the_same(kind):
    matrix, rows = np.random.default_rng(1).normal(size=(7, 6)).astype(kind), np.array([[6, 2, 0, 2, 1, 3, 3, 5]])
    out, expected = np.ones((6, 6)), np.ones((6, 6))
    moved(matrix, rows, out)
    np.add.at(expected, rows[0, 4:], matrix[rows[0, :4]])
    np.add.at(expected[:, 1], rows[0, 4:], matrix[rows[0, :4], 2])
    assert_allclose(out, expected, rtol=1e-15)
