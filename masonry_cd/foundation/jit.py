# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiled kernels: numba's njit with a cache that never goes stale, and a first run that takes half as long.

**Cache.** numba keeps compiled code and drops it when the file of the function changes, but not when a kernel that it calls, in another
file, does. Here an entry is stamped by a hash over its own code and that of all kernels that it reaches (``stamps.py``), and kept in a file
of its own (``kernel_store.py``).

**Compiling.** numba makes machine code of each function by itself, optimised with all that it calls, and two more entries to it, for
Python and for C. What is called through four levels is optimised five times. Most kernels are called by other kernels alone: these stay
intermediate code here, which is optimised and translated once, in each kernel that Python calls, and only that one goes to the cache.
Without that a first run compiles 2.3 times as long. A number written in a call is a type of its own for numba, and the function called is
compiled again for it; here it is one of its kind, which saves a tenth. A borrower counts no references, which saves a fifth, and a third of
the time of a step of few blocks. Helpers that are called in many places are left to LLVM to put into their callers, by
``forceinline=True``: with ``inline="always"`` numba copies them into each caller and types them again, a third more time.

**Start.** numba is given a function when it is first called, or compiled into another one: a run loads the kernels that it calls, and none
of the others. Only machine code is loaded; without that a small run takes 1.3 times as long.

**Processor.** Kernels are compiled for any x86-64 with AVX2 and FMA, see ``processor.py``.

**Calls.** NamedTuples among the arguments of a kernel that Python calls are passed field by field, see ``flat_calls.py``: a fifth of the
time of a step of few blocks. A kernel may be given to another one as an argument, or in a NamedTuple of kernels that is a constant of a
module: the other one is compiled once for each.

What a kernel is compiled to must not depend on which kernel called it first, or else neither would its results. So it has its own
``fastmath``, which numba would have it inherit from that caller.

All of this reaches into numba beyond its public interface; ``numba_internals.py`` alone does so. With a newer version of numba than
``NEWEST``, with one that lacks a name, or with MASONRY_CD_PLAIN_NJIT set in the environment, that file is not used: kernels are compiled by
plain ``numba.njit`` in each run, and nothing is kept; the program says so. docs/performance.md says what each piece gains.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from functools import cached_property, partial
from importlib import import_module
from operator import attrgetter
from typing import Any

import numba
from numba.extending import typeof_impl

from masonry_cd.foundation import kernel_store, processor
from masonry_cd.foundation.flat_calls import FlatCall, named_tuples

NEWEST = (0, 68)  # minor version of numba that numba_internals.py was last tried with
SWITCH = "MASONRY_CD_PLAIN_NJIT"  # environment variable: whether to use numba's own njit
COMMON = {"nogil": True, "error_model": "numpy", "fastmath": False}  # options of all kernels
_MAKING = threading.RLock()  # held while an entry is made, for threads that call it at once
processor.choose()  # before numba is given its first function


def _why_plain() -> str:
    """Why numba's own njit has to serve; empty where it has not."""
    if os.environ.get(SWITCH):
        return f"{SWITCH} is set"
    if numba.version_info[:2] > NEWEST:
        return f"numba {numba.__version__} is newer than {'.'.join(map(str, NEWEST))}, the last that was tried"
    try:
        import_module("masonry_cd.foundation.numba_internals")
    except (ImportError, AttributeError) as failure:
        return f"numba {numba.__version__} lacks what the cache of kernels needs: {failure}"
    return ""


WHY_PLAIN = _why_plain()
PLAIN = bool(WHY_PLAIN)
if not PLAIN:
    from masonry_cd.foundation import numba_internals


def entry(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a kernel that Python calls, and other kernels too; what is compiled is kept for later runs.

    Arguments that are NamedTuples are annotated with their classes.

    Args:
        options: those of ``numba.njit``, in addition to ``nogil`` and numpy's error model, which all kernels have.
    """
    return partial(_decorated, Entry, options)


def kernel(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a kernel that other kernels alone call, as part of them; Python gets a TypeError. The options are those of :func:`entry`."""
    return partial(_decorated, Kernel, options)


def borrower(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a kernel that other kernels alone call and that makes no arrays: it counts no references at all.

    No kernel counts them to its arguments, but others do to what they take out of NamedTuples, which costs more than a short kernel does.
    Only another borrower may call one that returns arrays, and it may not call a kernel that does. The options are those of :func:`entry`.
    """
    return partial(_decorated, Kernel, {"_nrt": False} | options)


def _decorated(kind: type[Kernel], options: dict[str, Any], function: Callable[..., Any]) -> Any:
    """Return the object that stands for a function in its module."""
    chosen = COMMON | options
    if PLAIN:
        chosen.pop("_nrt", None)  # no public option
        return numba.njit(**chosen)(function)
    return kind(function, chosen)


class Kernel:
    """A function that other kernels call, compiled as part of them.

    Args:
        function: to be compiled.
        options: those of ``numba.njit``.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        self.py_func, self.targetoptions = function, options  # by numba's names: it looks there whether to put it into its callers
        self.__module__, self.__qualname__, self.__doc__ = function.__module__, function.__qualname__, function.__doc__
        self.__name__ = function.__name__

    def __call__(self, *_: Any) -> Any:
        raise TypeError("this kernel is called by other kernels alone; with @entry Python may call it too")

    @cached_property
    def inner(self) -> Any:
        """numba's dispatcher, as other kernels call it."""
        return numba_internals.compile_kernel(self.py_func, self.targetoptions)


class Entry(Kernel):
    """A function that Python calls, and other kernels too. The arguments are those of a Kernel."""

    __call__ = property(attrgetter("_call"))  # a method would be one more frame of Python in each call

    @cached_property
    def _call(self) -> Callable[..., Any]:
        """Callable by which Python enters."""
        with _MAKING:
            return self.outer if self._flat is None else self._flat.spread

    @cached_property
    def outer(self) -> Any:
        """numba's dispatcher, as Python calls it."""
        return self._compiled(self.py_func, self.targetoptions) if self._flat is None else self._flat.flat

    @cached_property
    def _flat(self) -> FlatCall | None:
        """How NamedTuples are taken apart; None where there are none."""
        if self.targetoptions.get("parallel") or not any(named_tuples(self.py_func)):
            return None
        return FlatCall(self.py_func, self.inner, partial(self._compiled, options=COMMON))

    def _compiled(self, function: Any, options: dict[str, Any]) -> Any:
        """numba's dispatcher of a function through which Python enters."""
        return numba_internals.compile_entry(function, options, f"{self.__module__}.{self.__qualname__}", target())


def target() -> str:
    """Return the target of files of compiled kernels: processor, numba and Python."""
    return f"{processor.target()} numba {numba.__version__} python {sys.version_info[0]}.{sys.version_info[1]}"


def keeps() -> bool:
    """Return True if later runs find what this one compiles."""
    return not PLAIN and kernel_store.folder() is not None


def why_nothing_is_kept() -> str:
    """Why no run keeps what it compiled; empty where it does."""
    return "" if keeps() else WHY_PLAIN or f"no folder takes compiled kernels; {kernel_store.FOLDER} names one that does"


def lost() -> OSError | None:
    """Why some of what this process compiled could not be kept, though there is a folder for it; None where all is."""
    return kernel_store.unkept[0] if kernel_store.unkept else None


@typeof_impl.register(Kernel)
def _in_kernels(kernel: Kernel, _: Any) -> Any:
    """numba's type of a kernel that another one calls."""
    return numba.typeof(kernel.inner)
