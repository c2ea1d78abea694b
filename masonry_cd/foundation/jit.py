"""Compiled kernels: numba's njit with a cache that never goes stale, and a first run that takes half as long.

**Cache.** numba keeps compiled code and drops it when the file of the function changes, but not when a kernel that it calls, in another
file, does. Here an entry is stamped by a hash over the sources that it reaches: its own file and all that this one imports, and so on.
An entry that cannot be read is dropped and compiled anew.

**Compiling.** numba makes machine code of each function by itself, optimised with all that it calls, and two more entries to it, for
Python and for C. What is called through four levels is optimised five times. Most kernels are called by other kernels alone: these stay
intermediate code here, which is optimised and translated once, in each kernel that Python calls, and only that one goes to the cache.
Further, a number written in a call is a type of its own for numba, and the function called is compiled again for it; here it is one of its
kind. Together they save half of the time of a first run.

**Processor.** Kernels are compiled for any x86-64 with AVX2 and FMA, see ``processor.py``.

**Calls.** NamedTuples among the arguments of a kernel that Python calls are passed field by field, see ``flat_calls.py``. A kernel may be
given to another one as an argument, or in a NamedTuple of kernels that is a constant of a module: the other one is compiled once for each.

What a kernel is compiled to must not depend on which kernel called it first, or else neither would its results. So it has its own
``fastmath``, which numba would have it inherit from that caller.

All of this reaches into numba beyond its public interface; ``numba_internals.py`` alone does so. With a newer version of numba than
``NEWEST``, or with MASONRY_CD_PLAIN_NJIT set in the environment, that file is not imported: kernels are compiled by plain ``numba.njit`` in
each run, and nothing is kept; the program says so.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numba
from numba.extending import typeof_impl
from numba.types import Dispatcher

from masonry_cd.foundation import processor
from masonry_cd.foundation.flat_calls import FlatCall, named_tuples

NEWEST = (0, 68)  # minor version of numba that numba_internals.py was last tried with
SWITCH = "MASONRY_CD_PLAIN_NJIT"  # environment variable: whether to use numba's own njit
PLAIN = bool(os.environ.get(SWITCH)) or numba.version_info[:2] > NEWEST
COMMON = {"nogil": True, "error_model": "numpy", "fastmath": False}  # options of all kernels
processor.choose()  # before numba is given its first function
DISPATCHER = type(numba.njit(lambda: None))  # what a compiled function is
IMPORT = re.compile(r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n#]*)|import[ \t]+([^\n#]*))", re.MULTILINE)

if not PLAIN:
    from masonry_cd.foundation import numba_internals


def entry(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a kernel that Python calls, and other kernels too; what is compiled is kept for later runs.

    Arguments that are NamedTuples are annotated with their classes.

    Args:
        options: those of ``numba.njit``, beside ``nogil`` and numpy's error model, which all kernels have.
    """
    return partial(_compile, options, called=True)


def kernel(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a kernel that other kernels alone call, as part of them; Python gets a TypeError. The options are those of :func:`entry`."""
    return partial(_compile, options, called=False)


def borrower(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a kernel that other kernels alone call and that makes no arrays: it counts no references to those that it is given.

    numba counts references to all arrays of a NamedTuple in each call, which costs more than a short kernel does. Only another borrower may
    call one that returns arrays, and it may not call a kernel that does. The options are those of :func:`entry`.
    """
    return partial(_compile, {"_nrt": False} | options, called=False)


def _compile(options: dict[str, Any], function: Callable[..., Any], called: bool) -> Any:
    """numba's dispatcher of a function."""
    chosen = COMMON | options
    if PLAIN:
        chosen.pop("_nrt", None)  # no public option
        return numba.njit(**chosen)(function)
    if not called:
        return numba_internals.compile_kernel(function, chosen)
    stamp = _stamp(function.__module__)
    if chosen.get("parallel") or not any(named_tuples(function)):
        return numba_internals.compile_entry(function, chosen, stamp)
    inner = numba_internals.compile_kernel(function, chosen)
    return FlatCall(function, inner, partial(numba_internals.compile_entry, options=COMMON, stamp=stamp))


def compiled(kernel: Any) -> Any:
    """numba's dispatcher of an entry: it knows the versions that were compiled."""
    return kernel.flat if isinstance(kernel, FlatCall) else kernel


def compiled_for() -> str:
    """LLVM's name of the processor that kernels are compiled for."""
    return processor.target()[0]


def has_cache(kernel: Any) -> bool:
    """Whether there is a folder to keep an entry in."""
    return compiled(kernel).stats.cache_path is not None


def why_nothing_is_kept() -> str:
    """Why no run keeps what it compiled, whatever the folders; empty where it does."""
    if os.environ.get(SWITCH):
        return f"{SWITCH} is set"
    return f"numba {numba.__version__} is newer than {'.'.join(map(str, NEWEST))}, the last that was tried" if PLAIN else ""


def lost() -> OSError | None:
    """Why some of what this process compiled could not be kept, though there is a folder for it; None where all is."""
    return None if PLAIN or not numba_internals.unkept else numba_internals.unkept[0]


def kept(kernel: Any) -> list[tuple[Any, ...]]:
    """The kinds of arguments for which the cache holds an entry, as it is to be compiled on this machine; NamedTuples hold those of their
    fields."""
    found = numba_internals.kept(compiled(kernel)) if has_cache(kernel) else []
    return [kernel.regrouped(kinds) for kinds in found] if isinstance(kernel, FlatCall) else found


@typeof_impl.register(FlatCall)
def _in_kernels(call: FlatCall, _: Any) -> Any:
    """numba's type of an entry that a kernel calls: that of the kernel itself."""
    return Dispatcher(call.kernel)


# --- what an entry of the cache is stamped by -------------------------------------------------------------------------------------


def _stamp(module: str) -> str:
    """Hash over the source of a module and all that it imports from the packages that its kernels are in, directly or not."""
    found, left = set[str](), [module]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left.extend(imports_of(name))
    digest = hashlib.sha256()
    for name in sorted(found):
        digest.update(name.encode() + b"\0" + _source(name) + b"\0")
    return digest.hexdigest()


@cache
def _source(module: str) -> bytes:
    """The text of a module."""
    path = getattr(sys.modules[module], "__file__", None)
    return Path(path).read_bytes() if path and path.endswith(".py") else b""


@cache
def imports_of(module: str) -> tuple[str, ...]:
    """The loaded modules that a module imports: those of its own package, and others that hold kernels."""
    names = dict.fromkeys(_named(_source(module).decode(errors="replace")))
    top = module.partition(".")[0]
    return tuple(name for name in names if name in sys.modules and (name.partition(".")[0] == top or _has_kernels(sys.modules[name])))


def _named(text: str) -> Iterator[str]:
    """What may be a module in the import statements of a source: ``from a import b`` names a, and a.b if that is one."""
    for origin, what, plain in IMPORT.findall(text):
        for item in (what or plain).strip("()").split(","):
            word = item.split()[0] if item.split() else ""
            yield f"{origin}.{word}" if origin else word
        if origin:
            yield origin


def _has_kernels(module: ModuleType) -> bool:
    """Whether a module holds compiled functions, and is none of numba's."""
    if module.__name__.partition(".")[0] in ("numba", "llvmlite", "numpy", "scipy"):
        return False
    return any(isinstance(value, (DISPATCHER, FlatCall)) for value in vars(module).values())
