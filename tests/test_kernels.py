"""Kernels with and without an entry for Python."""

from __future__ import annotations

import pytest
from numba.core import caching

from masonry_cd.kernels import has_cache, kept, njit


@njit()
def _half(x):
    return 0.5 * x


@njit()
def quarter(x):
    return _half(_half(x))


@njit(entry=True)
def _eighth(x):
    return _half(quarter(x))


def third(x):
    return x / 3.0


def test_kernels_call_each_other_with_and_without_an_entry():
    assert quarter(8.0) == 2.0
    assert _eighth(8.0) == 1.0


def test_python_is_refused_where_there_is_no_entry_compiled_or_not():
    for argument in (8.0, 8):  # the first version was compiled for the kernels above
        with pytest.raises(TypeError, match="called by other kernels alone"):
            _half(argument)
    assert quarter(8) == 2.0


def test_kernels_do_without_a_folder_for_their_cache(monkeypatch):
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", [])
    kernel = njit(cache=True)(third)
    assert kernel(3.0) == 1.0
    assert not has_cache(kernel) and kept(kernel) == []
