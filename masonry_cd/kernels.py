"""numba's njit for kernels, without what costs a new user time to compile and is never called.

numba gives each function two more entries, each compiled and optimised with all that it calls: one for Python, one for C. No kernel is
called from C, and most are called by other kernels alone; without these entries a first run compiles a quarter faster.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def njit(entry: bool | None = None, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as ``numba.njit(**options)`` does.

    Args:
        entry: whether Python calls it; not given, it does unless the name begins with an underscore. Kernels call it in any case; without
            an entry, Python gets a TypeError.
        options: those of ``numba.njit``.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        called = not function.__name__.startswith("_") if entry is None else entry
        kernel = numba.njit(no_cfunc_wrapper=True, no_cpython_wrapper=not called, **options)(function)
        if not called:
            kernel._insert = _nothing  # numba would list an entry that is not there, and Python jump to it
            kernel._compile_for_args = _refused
        return kernel

    return decorate


def _nothing(*_: Any) -> None:
    """Stand in for what is not to be done."""


def _refused(*_: Any, **__: Any) -> None:
    raise TypeError("this kernel is called by other kernels alone; entry=True lets Python call it too")
