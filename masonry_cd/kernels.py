"""numba's njit for kernels, without what costs a new user time to compile and is of no use here.

numba makes machine code of each function by itself, optimised with all that it calls, and two more entries to it, for Python and for C.
What is called through four levels is optimised five times. Most kernels are called by other kernels alone: these stay intermediate code
here, which is optimised and translated once, in each kernel that Python calls, and only that one goes to the cache. Further, a number
written in a call is a type of its own for numba, and the function called is compiled again for it; here it is one of its kind. Together
they save half of the time of a first run.

What a kernel is compiled to must not depend on which kernel called it first, or else neither would its results. So it has its own
``fastmath``, which numba would have it inherit from that caller.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering
from numba.core.types.misc import unliteral

HASH = hash(Flags())  # that of all settings, by numba's definition


def njit(entry: bool | None = None, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as ``numba.njit(**options)`` does.

    Args:
        entry: whether Python calls it; not given, it does unless the name begins with an underscore. Kernels call it in any case; without
            an entry, Python gets a TypeError.
        options: those of ``numba.njit``; ``cache`` is for entries.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        called = not function.__name__.startswith("_") if entry is None else entry
        chosen = {"fastmath": False} | options | {"pipeline_class": _Pipeline if called else _Inner}
        if not called:
            chosen["cache"] = False
        compiler = partial(numba.njit, no_cfunc_wrapper=True, no_cpython_wrapper=not called)
        try:
            kernel = compiler(**chosen)(function)
        except RuntimeError:  # neither the package's folder nor the user's takes a cache
            kernel = compiler(**chosen | {"cache": False})(function)
        _take_numbers_by_kind(kernel)
        if not called:
            kernel._insert = _nothing  # numba would list an entry that is not there, and Python jump to it
            kernel._compile_for_args = _refused
        return kernel

    return decorate


def has_cache(kernel: Any) -> bool:
    """Whether there is a folder to keep an entry in."""
    return kernel.stats.cache_path is not None


def kept(kernel: Any) -> list[tuple[Any, ...]]:
    """The kinds of arguments for which the cache holds an entry, as it is to be compiled on this machine."""
    if not has_cache(kernel):
        return []
    cache, target = kernel._cache, kernel.targetctx.codegen()
    return [key[0] for key in cache._cache_file._load_index() if key == cache._index_key(key[0], target)]


def _take_numbers_by_kind(kernel: Any) -> None:
    """Let a kernel that calls this one with a number, say 0, get the version for all integers."""
    template = kernel.get_call_template

    def get_call_template(args: Any, kws: Any) -> Any:
        return template(tuple(map(unliteral, args)), {name: unliteral(kind) for name, kind in kws.items()})

    kernel.get_call_template = get_call_template


def _nothing(*_: Any) -> None:
    """Stand in for what is not to be done."""


def _refused(*_: Any, **__: Any) -> None:
    raise TypeError("this kernel is called by other kernels alone; entry=True lets Python call it too")


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
    """The same for kernels that other kernels alone call: it ends with intermediate code."""

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
