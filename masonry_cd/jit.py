"""Compiled kernels: numba's njit with a cache that never goes stale and a first run that takes half as long. No other file knows how.

**Cache.** numba keeps compiled code and drops it when the file of the function changes, but not when a kernel that it calls, in another
file, does. Here an entry is stamped by a hash over the sources that it reaches: its own file and all that this one imports, and so on.
An entry that cannot be read is dropped and compiled anew.

**Compiling.** numba makes machine code of each function by itself, optimised with all that it calls, and two more entries to it, for
Python and for C. What is called through four levels is optimised five times. Most kernels are called by other kernels alone: these stay
intermediate code here, which is optimised and translated once, in each kernel that Python calls, and only that one goes to the cache.
Further, a number written in a call is a type of its own for numba, and the function called is compiled again for it; here it is one of its
kind. Together they save half of the time of a first run.

What a kernel is compiled to must not depend on which kernel called it first, or else neither would its results. So it has its own
``fastmath``, which numba would have it inherit from that caller.

All of this reaches into numba beyond its public interface. With a newer version of numba than ``NEWEST``, or with MASONRY_CD_PLAIN_NJIT set
in the environment, kernels are compiled by plain ``numba.njit`` in each run instead, and nothing is kept; the program says so.
"""

from __future__ import annotations

import contextlib
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
from numba.core import caching
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering
from numba.core.types.misc import unliteral

NEWEST = (0, 68)  # numba's minor version that this file was last tried with
SWITCH = "MASONRY_CD_PLAIN_NJIT"  # environment variable: whether to use numba's own njit
PLAIN = bool(os.environ.get(SWITCH)) or numba.version_info[:2] > NEWEST
HASH = hash(Flags())  # that of all settings, by numba's definition
IMPORT = re.compile(r"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n#]*)|import[ \t]+([^\n#]*))", re.MULTILINE)


def entry(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a kernel that Python calls, and other kernels too; what is compiled is kept for later runs.

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
    call one that returns arrays. The options are those of :func:`entry`.
    """
    return partial(_compile, {"_nrt": False} | options, called=False)


def _compile(options: dict[str, Any], function: Callable[..., Any], called: bool) -> Any:
    """numba's dispatcher of a function."""
    chosen = {"nogil": True, "error_model": "numpy", "fastmath": False} | options
    if PLAIN:
        chosen.pop("_nrt", None)  # no public option
        return numba.njit(**chosen)(function)
    pipeline = _Pipeline if called else _Inner
    compiled = numba.njit(pipeline_class=pipeline, no_cfunc_wrapper=True, no_cpython_wrapper=not called, **chosen)(function)
    _take_numbers_by_kind(compiled)
    if not called:
        compiled._insert = _nothing  # numba would list an entry that is not there, and Python jump to it
        compiled._compile_for_args = _refused
        return compiled
    with contextlib.suppress(RuntimeError):  # neither the package's folder nor the user's takes a cache
        compiled._cache = _StampedCache(function)
    return compiled


def has_cache(kernel: Any) -> bool:
    """Whether there is a folder to keep an entry in."""
    return kernel.stats.cache_path is not None


def why_nothing_is_kept() -> str:
    """Why no run keeps what it compiled, whatever the folders; empty where it does."""
    if os.environ.get(SWITCH):
        return f"{SWITCH} is set"
    return f"numba {numba.__version__} is newer than {'.'.join(map(str, NEWEST))}, the last that was tried" if PLAIN else ""


def kept(kernel: Any) -> list[tuple[Any, ...]]:
    """The kinds of arguments for which the cache holds an entry, as it is to be compiled on this machine."""
    if not has_cache(kernel):
        return []
    cache, target = kernel._cache, kernel.targetctx.codegen()
    return [key[0] for key in cache._cache_file._load_index() if key == cache._index_key(key[0], target)]


# --- the cache -------------------------------------------------------------------------------------------------------------


class _StampedCache(caching.FunctionCache):
    """numba's cache of a function, whose entries are stamped by all the sources that the function reaches."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        stamp = _stamp(function.__module__)
        self._cache_file = caching.IndexDataCacheFile(
            cache_path=self._cache_path, filename_base=self._impl.filename_base, source_stamp=stamp
        )

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The kept entry, or None where there is none that can be read."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # whatever a damaged file makes pickle or LLVM raise
            with contextlib.suppress(OSError):
                self.flush()
            return None


def _stamp(module: str) -> str:
    """Hash over the source of a module and all that it imports from the packages that its kernels are in, directly or not."""
    found, left = set[str](), [module]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left.extend(_imports(name))
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
def _imports(module: str) -> tuple[str, ...]:
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
    return any(isinstance(value, numba.core.dispatcher.Dispatcher) for value in vars(module).values())


# --- compiling -------------------------------------------------------------------------------------------------------------
def _take_numbers_by_kind(kernel: Any) -> None:
    """Let a kernel that calls this one with a number, say 0, get the version for all integers."""
    template = kernel.get_call_template

    def get_call_template(args: Any, kws: Any) -> Any:
        return template(tuple(map(unliteral, args)), {name: unliteral(kind) for name, kind in kws.items()})

    kernel.get_call_template = get_call_template


def _nothing(*_: Any) -> None:
    """Stand in for what is not to be done."""


def _refused(*_: Any, **__: Any) -> None:
    raise TypeError("this kernel is called by other kernels alone; with @entry Python may call it too")


class _Flags(Flags):
    """numba's settings of a compilation. It compares them, option by option, for each operator that it finds in a function."""

    def __hash__(self) -> int:
        return HASH

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Flags) and self._values.keys() == other._values.keys():
            return bool(self._values == other._values)
        return Flags.__eq__(self, other)


class _Pipeline(Compiler):
    """numba's compiler, with settings that are quick to compare."""

    def __init__(self, typing: Any, target: Any, library: Any, args: Any, result: Any, flags: Flags, names: Any) -> None:
        super().__init__(typing, target, library, args, result, _Flags(flags), names)


class _Inner(_Pipeline):
    """The compiler of kernels that other kernels alone call: it ends with intermediate code."""

    def define_pipelines(self) -> Any:
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [(_InnerLowering if step is NativeLowering else step, name) for step, name in pipeline.passes]
        return pipelines


@register_pass(mutates_CFG=True, analysis_only=False)
class _InnerLowering(NativeLowering):
    """Lowers to intermediate code, for other kernels to take in."""

    _name = "inner_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = _IntermediateCode(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        lowered = state["cr"]
        name = _Name()
        state.targetctx.insert_user_function(name, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=name)
        return True


class _Name:
    """What numba knows a compiled version of a kernel by."""


class _IntermediateCode(JITCodeLibrary):
    """A kernel and all that it calls, to be optimised and translated where Python enters."""

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True
