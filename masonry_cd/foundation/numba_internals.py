# SPDX-License-Identifier: GPL-3.0-or-later
"""Access to numba beyond its public interface, for ``jit.py``, which gives the reasons. Tried up to the version named there.

A kernel that Python does not call ends as intermediate code in numba's pipeline, and is linked into its callers in that form. Entries are
kept by ``kernel_store.py``; of what is kept only machine code is loaded, without the registries that numba fills before it compiles.
Settings are compared quickly, and calls with literal numbers use the version for all numbers of their kind. Kernels may be given to kernels
as arguments, and what is compiled so is kept, too. No kernel counts references to what it is given.

``jit.py`` does without this file where numba lacks what it imports, and beyond the last version that it was tried with.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from functools import cache, cached_property
from types import FunctionType
from typing import Any

import llvmlite.binding
import numba
from numba.core import ir, types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult, Flags
from numba.core.compiler_machinery import register_pass
from numba.core.imputils import lower_constant
from numba.core.ir_utils import get_definition, guard
from numba.core.lowering import Lower
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.typed_passes import NativeLowering
from numba.types import unliteral

from masonry_cd.foundation import kernel_store
from masonry_cd.foundation.stamps import stamp

HASH = hash(Flags())  # that of all settings, by numba's definition
STUB = 'define void @"{}"() {{ ret void }}\n'  # all that is known of the code of a function that is kept: its name


def settled_target() -> tuple[str, str]:
    """Name and features of the processor that numba compiles for, in LLVM's words; from here on it is this one."""
    _, name, features = numba.njit(_nothing).targetctx.codegen().magic_tuple()
    return name, features


def compile_kernel(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """numba's dispatcher of a function that kernels alone call, compiled as part of them; the options are those of ``numba.njit``."""
    compiled = _dispatcher(function, options, _Inner, no_cpython_wrapper=True)
    compiled._insert = _nothing  # numba would list an entry that is not there, and Python jump to it
    return compiled


def compile_entry(function: FunctionType, options: dict[str, Any], entry: str, target: str) -> Any:
    """numba's dispatcher of a function that Python calls, to be compiled or loaded at its first call.

    Args:
        function: to be compiled.
        options: those of ``numba.njit``.
        entry: name in the store.
        target: what it is compiled for, as text.
    """
    compiled = _dispatcher(function, options, _Pipeline)
    compiled._cache = KeptEntry(entry, function, f"{target} {sorted(map(str, options.items()))}")
    return compiled


def _dispatcher(function: Callable[..., Any], options: dict[str, Any], pipeline: type[Compiler], **more: Any) -> Any:
    compiled = numba.njit(pipeline_class=pipeline, no_cfunc_wrapper=True, **more, **options)(function)
    # Part of the names of the kernels that it is given to. By default it is long, with an address.
    compiled._type.name = f"{function.__module__}.{function.__qualname__}"
    _take_numbers_by_kind(compiled)
    return compiled


class KeptEntry:
    """Stand-in for numba's cache of an entry.

    Args:
        entry: name in the store.
        function: that is compiled.
        target: what it is compiled for, and with which options, as text.
    """

    def __init__(self, entry: str, function: FunctionType, target: str) -> None:
        self.entry, self.function, self.target = entry, function, target

    @cached_property
    def stamp(self) -> str:
        """The hash of all that the function reaches; empty where it must not be kept."""
        return stamp(self.function)

    @property
    def cache_path(self) -> str | None:
        """The folder, for numba's statistics."""
        place = kernel_store.folder()
        return None if place is None else str(place)

    def file(self, kinds: Any) -> str:
        """Name of the file for the types of arguments; empty where there is to be none."""
        given = any(isinstance(kind, types.Dispatcher) for kind in kinds)  # a kernel by Python, of which its type has only the name
        return kernel_store.name_of(self.entry, self.stamp, f"{kinds} {self.target}") if self.stamp and not given else ""

    def load_overload(self, kinds: Any, context: Any) -> Any:
        """The kept entry, or None where there is none that can be read: numba then compiles, for which it fills its registries."""
        with kernel_store.loading():
            name = self.file(kinds)
            data = kernel_store.read(name) if name else None
            found = None if data is None else _loaded(data, context)
        if found is None:
            context.refresh()
        else:
            kernel_store.used.add(name)
        return found

    def save_overload(self, kinds: Any, result: Any) -> None:
        """Keep an entry: its machine code, and stubs instead of the intermediate code, which nothing links."""
        name = self.file(kinds)
        if not name or result.library.has_dynamic_globals or result.lifted:
            return
        library, *rest, environments = result._replace(type_annotation="")._reduce()
        names = [result.fndesc.llvm_cpython_wrapper_name, result.fndesc.llvm_func_name]
        stubs = llvmlite.binding.parse_assembly("".join(map(STUB.format, names))).as_bitcode()
        title, form, (code, _) = library
        kernel_store.write(name, dumps(((title, form, (code, stubs)), *rest, tuple(map(_Environment, environments)))))

    def flush(self) -> None:
        """Nothing: a file that is not right is not read."""


def _loaded(data: bytes, context: Any) -> Any:
    """An entry as numba has it; None where it cannot be read."""
    try:
        rtsys.initialize(context)
        return CompileResult._rebuild(context, *pickle.loads(data))
    except Exception:  # whatever pickle or LLVM raise about what another machine has written
        return None


class _Environment:
    """The environment of compiled code of numba's own functions, as it is kept: its constants, without the module of the function.

    No compiled code looks into the module, and some of numba's take as long to import as a small run takes.
    """

    def __init__(self, environment: Any) -> None:
        self.of = environment

    def __reduce__(self) -> Any:
        rebuild, (module, constants, name) = self.of.__reduce__()
        return rebuild, ("numba" if module.startswith("numba.") else module, constants, name)


def _take_numbers_by_kind(kernel: Any) -> None:
    """Let a kernel that calls this one with a number, say 0, get the version for all integers."""
    template = kernel.get_call_template

    def get_call_template(args: Any, kws: Any) -> Any:
        return template(tuple(map(unliteral, args)), {name: unliteral(kind) for name, kind in kws.items()})

    kernel.get_call_template = get_call_template


def _nothing(*_: Any) -> None:
    """Stand in for what is not to be done."""


class _Flags(Flags):
    """numba's settings of a compilation. It compares them, option by option, for each operator that it finds in a function."""

    def __hash__(self) -> int:
        return HASH

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Flags) and self._values.keys() == other._values.keys():
            return bool(self._values == other._values)
        return Flags.__eq__(self, other)


class _Pipeline(Compiler):
    """numba's compiler, with settings that are quick to compare, and kernels that borrow their arguments."""

    def __init__(self, typing: Any, target: Any, library: Any, args: Any, result: Any, flags: Flags, names: Any) -> None:
        _let_kernels_be_given()
        super().__init__(typing, target, library, args, result, _Flags(flags), names)

    @property
    def lowering(self) -> type[NativeLowering]:
        """The pass that takes the place of numba's own."""
        return _Lowering

    def define_pipelines(self) -> Any:
        pipelines = super().define_pipelines()
        for pipeline in pipelines:
            pipeline.passes = [(self.lowering if step is NativeLowering else step, name) for step, name in pipeline.passes]
        return pipelines


class _Inner(_Pipeline):
    """The compiler of kernels that other kernels alone call: it ends with intermediate code."""

    @property
    def lowering(self) -> type[NativeLowering]:
        return _InnerLowering


class _Borrower(Lower):
    """Lowers a function that counts no references to its arguments: who calls it holds them until it returns.

    numba counts one to each array of a NamedTuple in each call, which was a seventh of the time of a step of one block.
    """

    def __init__(self, *given: Any, **more: Any) -> None:
        super().__init__(*given, **more)
        self.borrowed = set[str]()  # names of the arguments that are never assigned again

    def lower_assign(self, kind: Any, statement: Any) -> Any:
        name, value = statement.target.name, statement.value
        if isinstance(value, ir.Arg) and self.typeof(f"arg.{value.name}") == kind and guard(get_definition, self.func_ir, name) is value:
            self.borrowed.add(name)
            return self.fnargs[value.index]
        return super().lower_assign(kind, statement)

    def delvar(self, name: str) -> None:
        if name not in self.borrowed:
            super().delvar(name)


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    """Lowers to machine code."""

    _name = "borrowing_lowering"
    lowering_class = _Borrower

    def run_pass(self, state: Any) -> bool:
        if state.library is None:
            state.library = _MachineCode(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class _InnerLowering(_Lowering):
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


@cache
def _let_kernels_be_given() -> None:
    """Pass a kernel to another one as nothing, since its type says all. numba passes its address, which no cache can keep."""
    from numba.experimental.function_type import lower_constant_dispatcher  # numba's own rule, which must come before this one

    @lower_constant(types.Dispatcher)
    def _given(context: Any, builder: Any, kind: Any, kernel: Any) -> Any:
        if issubclass(kind.dispatcher._compiler.pipeline_class, _Pipeline):
            return context.get_dummy_value()
        return lower_constant_dispatcher(context, builder, kind, kernel)


class _Name:
    """The name by which numba knows a compiled version of a kernel."""


class _MachineCode(JITCodeLibrary):
    """An entry with all kernels that it calls, which nobody else can call.

    LLVM so leaves out what they are given and do not use, most of each NamedTuple: a tenth of the time of a step of one block, and of code.
    """

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if function.linkage == llvmlite.binding.Linkage.linkonce_odr:  # of the libraries that numba has linked in
                function.linkage = "internal"
        super()._optimize_final_module()


class _IntermediateCode(JITCodeLibrary):
    """A kernel and all that it calls, to be optimised and translated where Python enters."""

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True
