"""What reaches into numba beyond its public interface, for ``jit.py``, which says what for. Tried up to the version named there.

A kernel that Python does not call ends as intermediate code in numba's pipeline, and is linked into its callers in that form. Cache entries
are stamped by a string given, and processes may share them. Settings are compared quickly, and calls with literal numbers use the version
for all numbers of their kind. Kernels may be given to kernels as arguments, and what is compiled so is kept, too.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from hashlib import sha256
from typing import Any

import numba
from numba.core import caching, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import register_pass
from numba.core.imputils import lower_constant
from numba.core.typed_passes import NativeLowering
from numba.core.types.misc import unliteral
from numba.experimental.function_type import lower_constant_dispatcher

unkept: list[OSError] = []  # why entries of a cache could not be written, a full disc for example
HASH = hash(Flags())  # that of all settings, by numba's definition


def compile_kernel(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """numba's dispatcher of a function that kernels alone call, compiled as part of them; the options are those of ``numba.njit``."""
    compiled = _dispatcher(function, options, _Inner, no_cpython_wrapper=True)
    compiled._insert = _nothing  # numba would list an entry that is not there, and Python jump to it
    compiled._compile_for_args = _refused
    return compiled


def compile_entry(function: Callable[..., Any], options: dict[str, Any], stamp: str) -> Any:
    """numba's dispatcher of a function that Python calls, to be compiled at its first call.

    Args:
        function: to be compiled.
        options: those of ``numba.njit``.
        stamp: of its entries in the cache; others are not used.
    """
    compiled = _dispatcher(function, options, _Pipeline)
    with contextlib.suppress(RuntimeError):  # neither the package's folder nor the user's takes a cache
        compiled._cache = _StampedCache(function, stamp)
    return compiled


def _dispatcher(function: Callable[..., Any], options: dict[str, Any], pipeline: type[Compiler], **more: Any) -> Any:
    compiled = numba.njit(pipeline_class=pipeline, no_cfunc_wrapper=True, **more, **options)(function)
    compiled._type.name = function.__qualname__  # part of the names of the kernels that it is given to; by default long, with an address
    _take_numbers_by_kind(compiled)
    return compiled


def kept(kernel: Any) -> list[tuple[Any, ...]]:
    """The kinds of arguments for which the cache of a kernel holds an entry, as it is to be compiled on this machine."""
    cache, target = kernel._cache, kernel.targetctx.codegen()
    return [key[0] for key in cache._cache_file._load_index() if key == cache._index_key(key[0], target)]


class _StampedCache(caching.FunctionCache):
    """numba's cache of a function, whose entries are stamped by a given string."""

    def __init__(self, function: Callable[..., Any], stamp: str) -> None:
        super().__init__(function)
        self._cache_file = SharedFiles(cache_path=self._cache_path, filename_base=self._impl.filename_base, source_stamp=stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The kept entry, or None where there is none that can be read."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # whatever a damaged file makes pickle or LLVM raise
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep an entry, where the disc has room for it; why it has not is noted in ``unkept``."""
        try:
            super().save_overload(sig, data)
        except OSError as failure:
            unkept.append(failure)


class SharedFiles(caching.IndexDataCacheFile):
    """The files of a cache that processes share: an entry's file has a name of its own, and is there before the index tells of it.

    numba counts entries up. Two processes that compile for different kinds of arguments at once would take the same number, and what the
    one has compiled be loaded for the arguments of the other.
    """

    def save(self, key: Any, data: Any) -> None:
        """Save the entry of a key. Should another process write the index at this instant, one of the two entries is compiled again."""
        name = self._data_name(int(sha256(repr(key).encode()).hexdigest()[:12], 16))
        self._save_data(name, data)
        try:
            known = self._load_index()
        except Exception:  # as in load_overload
            known = {}
        self._save_index(known | {key: name})


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


@lower_constant(types.Dispatcher)
def _given(context: Any, builder: Any, kind: Any, kernel: Any) -> Any:
    """What a kernel is passed as to another one: nothing, since its type says all. numba passes its address, which no cache can keep."""
    if issubclass(kind.dispatcher._compiler.pipeline_class, _Pipeline):
        return context.get_dummy_value()
    return lower_constant_dispatcher(context, builder, kind, kernel)


class _Name:
    """What numba knows a compiled version of a kernel by."""


class _IntermediateCode(JITCodeLibrary):
    """A kernel and all that it calls, to be optimised and translated where Python enters."""

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True
