# SPDX-License-Identifier: GPL-3.0-or-later
"""Additions to numba's Python: atomic access to an array that threads share, and a hint to fetch memory ahead."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def declared(builder: Any, kind: ir.FunctionType, name: str) -> Any:
    """A function of the C library or of the compiler, declared once in a module."""
    return builder.module.globals.get(name) or ir.Function(builder.module, kind, name)


@intrinsic
def prefetch(typing: Any, array: types.Array, entry: types.Integer) -> tuple[Any, Any]:
    """Ask for the line of the cache that holds an entry of a contiguous array, counted flat; beyond its ends nothing happens."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        address = builder.bitcast(builder.gep(data, [arguments[1]]), ir.IntType(8).as_pointer())
        number = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [address.type, number, number, number])
        fetch = builder.module.declare_intrinsic("llvm.prefetch", [address.type], kind)
        builder.call(fetch, [address, number(0), number(3), number(1)])  # to read, to be kept near, data
        return context.get_dummy_value()

    return types.void(array, entry), generate


@intrinsic
def atomic_add(typing: Any, array: types.Array, entry: types.Integer, value: types.Integer) -> tuple[Any, Any]:
    """Add to an entry of an array of int64 at once for all threads; returns what was there."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        address = builder.gep(data, [context.cast(builder, arguments[1], signature.args[1], types.intp)])
        return builder.atomic_rmw("add", address, context.cast(builder, arguments[2], signature.args[2], types.int64), "seq_cst")

    return types.int64(array, entry, value), generate


@intrinsic
def atomic_load(typing: Any, array: types.Array, entry: types.Integer) -> tuple[Any, Any]:
    """An entry of an array of int64 as the other threads left it."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        address = builder.gep(data, [context.cast(builder, arguments[1], signature.args[1], types.intp)])
        return builder.load_atomic(address, "seq_cst", 8)

    return types.int64(array, entry), generate


@intrinsic
def yield_processor(typing: Any) -> tuple[Any, Any]:
    """Give the processor to another thread that wants it."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = ir.IntType(32)
        builder.call(declared(builder, ir.FunctionType(number, []), "sched_yield"), [])
        return context.get_dummy_value()

    return types.void(), generate


@intrinsic
def is_tuple(typing: Any, size: Any) -> tuple[Any, Any]:
    """Return True if a value is a tuple, which the compiler knows, and leaves out what is for the other case."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.get_constant(types.boolean, isinstance(signature.args[0], types.BaseTuple))

    return types.boolean(size), generate
