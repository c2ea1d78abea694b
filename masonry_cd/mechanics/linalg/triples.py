# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors in space as three numbers, each a float or, side by side for several items, lanes of floats (vectors.py)."""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower


@borrower(forceinline=True, fastmath={"contract"})
def plus(a, b):
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@borrower(forceinline=True, fastmath={"contract"})
def minus(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@borrower(forceinline=True, fastmath={"contract"})
def scaled(x, a):
    """x a."""
    return x * a[0], x * a[1], x * a[2]


@borrower(forceinline=True, fastmath={"contract"})
def times(a, b):
    """Products of the components."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


@borrower(forceinline=True, fastmath={"contract"})
def inner(a, b):
    """a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@borrower(forceinline=True, fastmath={"contract"})
def cross(a, b):
    """a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@borrower(forceinline=True, fastmath={"contract"})
def in_axes(axes, a):
    """The components of a in three axes."""
    return inner(axes[0], a), inner(axes[1], a), inner(axes[2], a)


@borrower(forceinline=True, fastmath={"contract"})
def out_of_axes(axes, a):
    """The vector whose components in three axes are a."""
    return plus(plus(scaled(a[0], axes[0]), scaled(a[1], axes[1])), scaled(a[2], axes[2]))
