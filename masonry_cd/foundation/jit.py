# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiled kernels: numba's njit with a cache that never goes stale, and a first run that takes half as long.

**Cache.** numba keeps compiled code and drops it when the file of the function changes, but not when a kernel that it calls, in another
file, does. Here an entry is stamped by a hash over the sources that it reaches: its own file and all that this one imports, and so on.
``kernel_store.py`` has the files.

**Compiling.** numba makes machine code of each function by itself, optimised with all that it calls, and two more entries to it, for
Python and for C. What is called through four levels is optimised five times. Most kernels are called by other kernels alone: these stay
intermediate code here, which is optimised and translated once, in each kernel that Python calls, and only that one goes to the cache.
Further, a number written in a call is a type of its own for numba, and the function called is compiled again for it; here it is one of its
kind. Together they save half of the time of a first run.

**Start.** numba is given a function when it is first called, or compiled into another one: a run loads the kernels that it calls, and none
of the others.

**Processor.** Kernels are compiled for any x86-64 with AVX2 and FMA, see ``processor.py``.

**Calls.** NamedTuples among the arguments of a kernel that Python calls are passed field by field, see ``flat_calls.py``. A kernel may be
given to another one as an argument, or in a NamedTuple of kernels that is a constant of a module: the other one is compiled once for each.

What a kernel is compiled to must not depend on which kernel called it first, or else neither would its results. So it has its own
``fastmath``, which numba would have it inherit from that caller.

All of this reaches into numba beyond its public interface; ``numba_internals.py`` alone does so. With a newer version of numba than
``NEWEST``, with one that lacks a name, or with MASONRY_CD_PLAIN_NJIT set in the environment, that file is not used: kernels are compiled by
plain ``numba.njit`` in each run, and nothing is kept; the program says so.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from functools import cache, cached_property, partial
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any

import numba
from numba.extending import typeof_impl

from masonry_cd.foundation import kernel_store, processor
from masonry_cd.foundation.flat_calls import FlatCall, named_tuples

NEWEST = (0, 68)  # minor version of numba that numba_internals.py was last tried with
SWITCH = "MASONRY_CD_PLAIN_NJIT"  # environment variable: whether to use numba's own njit
COMMON = {"nogil": True, "error_model": "numpy", "fastmath": False}  # options of all kernels
INTERNALS = "masonry_cd.foundation.numba_internals"
OWN = ("masonry_cd.foundation.jit", INTERNALS, "masonry_cd.foundation.flat_calls")  # modules that decide how any kernel is compiled
IMPORT = re.compile(r"^(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n#]*)|import[ \t]+([^\n#]*))", re.MULTILINE)  # at its top level
_MAKING = threading.RLock()  # held while an entry is made, for threads that call it at once
BEGUN = time.time()  # when this process had loaded no kernel yet [s]
processor.choose()  # before numba is given its first function


def _why_plain() -> str:
    """Why numba's own njit has to serve; empty where it has not."""
    if os.environ.get(SWITCH):
        return f"{SWITCH} is set"
    if numba.version_info[:2] > NEWEST:
        return f"numba {numba.__version__} is newer than {'.'.join(map(str, NEWEST))}, the last that was tried"
    try:
        lacking = import_module(INTERNALS).missing()
    except (ImportError, AttributeError) as failure:
        lacking = [str(failure)]
    return f"numba {numba.__version__} lacks what the cache of kernels needs: {', '.join(lacking)}" if lacking else ""


WHY_PLAIN = _why_plain()
PLAIN = bool(WHY_PLAIN)
if not PLAIN:
    from masonry_cd.foundation import numba_internals


def entry(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a kernel that Python calls, and other kernels too; what is compiled is kept for later runs.

    Arguments that are NamedTuples are annotated with their classes.

    Args:
        options: those of ``numba.njit``, beside ``nogil`` and numpy's error model, which all kernels have.
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
    """What stands for a function in its module."""
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
        """What Python enters by."""
        with _MAKING:
            return self.outer if self._flat is None else self._flat.spread

    @cached_property
    def outer(self) -> Any:
        """numba's dispatcher, as Python calls it."""
        return self._compiled(self.py_func, self.targetoptions) if self._flat is None else self._flat.flat

    @property
    def stats(self) -> Any:
        """numba's counts of what was compiled and loaded."""
        return self.outer.stats

    @property
    def signatures(self) -> list[Any]:
        """The kinds of arguments that there is code for in this process."""
        return list(self.outer.signatures)

    @cached_property
    def _flat(self) -> FlatCall | None:
        """How NamedTuples are taken apart; None where there are none."""
        if self.targetoptions.get("parallel") or not any(named_tuples(self.py_func)):
            return None
        return FlatCall(self.py_func, self.inner, partial(self._compiled, options=COMMON))

    def _compiled(self, function: Callable[..., Any], options: dict[str, Any]) -> Any:
        """numba's dispatcher of a function through which Python enters."""
        title, sources = f"{self.__module__}.{self.__qualname__}", partial(stamp, self.__module__)
        kept = numba_internals.Kept(title, sources, target()) if can_be_kept(self.py_func) else None
        return numba_internals.compile_entry(function, options, kept)


COMPILED = (Kernel, type(numba.njit(lambda: None)))  # what a compiled function is, here and in other packages


def can_be_kept(function: Callable[..., Any]) -> bool:
    """Whether all that a function hangs on is in the file of its module, by which what it is compiled to is stamped."""
    module = sys.modules.get(function.__module__)
    own = getattr(module, "__file__", None)
    return (
        own is not None
        and function.__code__.co_filename == own
        and function.__closure__ is None
        and "<locals>" not in function.__qualname__
    )


def compiled_for() -> str:
    """LLVM's name of the processor that kernels are compiled for."""
    return processor.target()[0]


def target() -> str:
    """What files of compiled kernels are for: processor, numba and Python."""
    return f"{processor.target()} numba {numba.__version__} python {sys.version_info[0]}.{sys.version_info[1]}"


def keeps() -> bool:
    """Whether later runs find what this one compiles."""
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


# --- what an entry of the cache is stamped by -------------------------------------------------------------------------------------


@cache
def stamp(module: str) -> str:
    """Hash over the source of a module and all that it imports from the packages that its kernels are in, directly or not.

    Imports at the top level of a module count: a kernel sees no others. Empty where a file has changed since this process began: it may
    not be what was imported, so that nothing is kept or read under its hash.
    """
    found, left = set[str](), [module, *OWN]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left.extend(imports_of(name))
    if any(map(_has_changed, found)):
        return ""
    digest = hashlib.sha256()
    for name in sorted(found):
        digest.update(name.encode() + b"\0" + _source(name) + b"\0")
    return digest.hexdigest()


@cache
def _source(module: str) -> bytes:
    """The text of a module."""
    path = _file(module)
    return path.read_bytes() if path is not None else b""


def _has_changed(module: str) -> bool:
    """Whether the file of a module has been written to, or put into its place, since this process began."""
    path = _file(module)
    return path is not None and path.stat().st_ctime > BEGUN


def _file(module: str) -> Path | None:
    """The source file of a module."""
    path = getattr(sys.modules[module], "__file__", None)
    return Path(path) if path and path.endswith(".py") else None


@cache
def imports_of(module: str) -> tuple[str, ...]:
    """The loaded modules that a module imports: those of its own package, and others that hold kernels."""
    names = dict.fromkeys(_named(_source(module).decode(errors="replace")))
    top = module.partition(".")[0]
    return tuple(name for name in names if name in sys.modules and (name.partition(".")[0] == top or _has_kernels(name)))


def _named(text: str) -> Iterator[str]:
    """What may be a module in the import statements of a source: ``from a import b`` names a, and a.b if that is one."""
    for origin, what, plain in IMPORT.findall(text):
        for item in (what or plain).strip("()").split(","):
            word = item.split()[0] if item.split() else ""
            yield f"{origin}.{word}" if origin else word
        if origin:
            yield origin


@cache
def _has_kernels(module: str) -> bool:
    """Whether a module holds compiled functions, and is none of numba's, nor of those that come with Python."""
    top = module.partition(".")[0]
    if top in ("numba", "llvmlite", "numpy", "scipy") or top in sys.stdlib_module_names:
        return False
    return any(isinstance(value, COMPILED) for value in list(vars(sys.modules[module]).values()))
