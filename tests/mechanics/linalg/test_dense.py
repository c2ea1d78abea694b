# SPDX-License-Identifier: GPL-3.0-or-later
"""Dense kernels of a supernode: products of all sizes, whose sums are held in registers eight, four and one column at a time."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.linalg.dense import gemm


@entry()
def product(x, at, rows, inner, g, begin, end, out):
    """gemm, for Python."""
    gemm(x, at, rows, inner, g, begin, end, out)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize("length", [0, 1, 3, 4, 6, 8, 11, 12, 15, 16, 30])
@pytest.mark.parametrize("rows", [1, 2, 3, 4, 6, 8])
def test_a_product_of_parts_of_matrices_and_nothing_next_to_it(rows, length, kind):
    generator = np.random.default_rng(rows + 10 * length)
    x, g = generator.normal(size=(7, rows + 5)).astype(kind), generator.normal(size=(7, length + 3)).astype(kind)
    out = np.full((rows + 1, length + 2), 7.0, dtype=kind)
    product(x, 2, rows, 6, g, 1, 1 + length, out)
    expected = x[:6, 2 : 2 + rows].T.astype(float) @ g[:6, 1 : 1 + length].astype(float)
    assert_allclose(out[:rows, :length], expected, rtol=0, atol=20 * np.finfo(kind).eps)
    assert_array_equal(out[rows:], 7.0)
    assert_array_equal(out[:, length:], 7.0)
