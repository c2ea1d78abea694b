# SPDX-License-Identifier: GPL-3.0-or-later
"""Several floats at once, as one instruction of the processor takes them.

The compiler makes such instructions of loops along an array, but not of products whose sums stay in registers, in which a factorisation
spends most of its time. A kernel that loads, multiplies and stores four or eight entries at a time takes half of the time there, or less.
Where the registers of a processor are shorter the compiler takes them apart; where it has no fused multiplication and addition it rounds
twice.

Python's operators work on lanes, place by place, and between lanes and a float. Where one place would take another branch than its
neighbour both are computed, and :func:`where_at_most` picks.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.linalg.intrinsics import declared

_INDEX = ir.IntType(32)


class Lanes(types.Type):
    """numba's type of a given number of floats of one kind in a register."""

    def __init__(self, dtype: types.Float, count: int) -> None:
        self.dtype, self.count = dtype, count
        super().__init__(name=f"Lanes({dtype}, {count})")

    @property
    def vector(self) -> ir.VectorType:
        """The compiler's own type."""
        return ir.VectorType(ir.DoubleType() if self.dtype == types.float64 else ir.FloatType(), self.count)


@register_model(Lanes)
class _InRegister(models.PrimitiveModel):
    """They are one value of the compiler's."""

    def __init__(self, manager: Any, kind: Lanes) -> None:
        super().__init__(manager, kind, kind.vector)


_DOUBLES = Lanes(types.float64, 4)


def _filler(count: int) -> Callable[..., Any]:
    """An intrinsic that repeats a float so often."""

    def fill(typing: Any, value: types.Float) -> tuple[Any, Any]:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return _spread(builder, signature.return_type.vector, arguments[0])

        return Lanes(value, count)(value), generate

    return fill


def _loader(count: int) -> Callable[..., Any]:
    """An intrinsic that loads a given number of entries of a row of a contiguous matrix from a column on; its end is not checked."""

    def load(typing: Any, matrix: types.Array, row: types.Integer, column: types.Integer) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            address = _address(context, builder, signature, arguments, signature.return_type.vector)
            return builder.load(address, align=matrix.dtype.bitwidth // 8)

        return (Lanes(matrix.dtype, count)(matrix, row, column), generate) if _is_plain(matrix) else None

    return load


fill_two, fill_four, fill_eight = intrinsic(_filler(2)), intrinsic(_filler(4)), intrinsic(_filler(8))
load_two, load_four, load_eight = intrinsic(_loader(2)), intrinsic(_loader(4)), intrinsic(_loader(8))


@intrinsic
def pack(typing: Any, values: types.UniTuple) -> Any:
    """Lanes of the floats of a tuple."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        lanes = ir.Constant(signature.return_type.vector, ir.Undefined)
        for k in range(values.count):
            lanes = builder.insert_element(lanes, builder.extract_value(arguments[0], k), _INDEX(k))
        return lanes

    return Lanes(values.dtype, values.count)(values), generate


@intrinsic
def store_lanes(typing: Any, matrix: types.Array, row: types.Integer, column: types.Integer, lanes: Lanes) -> Any:
    """Put floats into a row of a contiguous matrix from a column on, rounded to its precision; its end is not checked."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = Lanes(matrix.dtype, lanes.count).vector
        values = _cast(builder, arguments[3], kind)
        builder.store(values, _address(context, builder, signature, arguments, kind), align=matrix.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return (types.void(matrix, row, column, lanes), generate) if _is_plain(matrix) else None


@intrinsic
def add_times(typing: Any, total: Lanes, factor: types.Float, lanes: Lanes) -> Any:
    """total + factor times lanes in the precision of the total, rounded once where the processor can."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = total.vector
        name = f"llvm.fmuladd.v{total.count}f{total.dtype.bitwidth}"
        fused = declared(builder, ir.FunctionType(kind, [kind, kind, kind]), name)
        return builder.call(fused, [_spread(builder, kind, arguments[1]), _cast(builder, arguments[2], kind), arguments[0]])

    return total(total, total.dtype, lanes), generate


# Rows of blocks of rigid bodies in space have six entries, of those that deform as many or twelve: pairs of four lanes and two.


@borrower(forceinline=True)
def fill_six(value):
    """A float, six times."""
    return fill_four(value), fill_two(value)


@borrower(forceinline=True)
def pack_six(a, b, c, d, e, f):
    """Six floats."""
    return pack((a, b, c, d)), pack((e, f))


@borrower(forceinline=True)
def load_six(matrix, row, column):
    """Six entries of a row of a contiguous matrix from a column on."""
    return load_four(matrix, row, column), load_two(matrix, row, column + 4)


@borrower(forceinline=True)
def add_six_times(total, factor, six):
    """total + factor times six, as in :func:`add_times`."""
    return add_times(total[0], factor, six[0]), add_times(total[1], factor, six[1])


@borrower(forceinline=True)
def store_six(matrix, row, column, six):
    """Put six floats into a row of a contiguous matrix from a column on."""
    store_lanes(matrix, row, column, six[0])
    store_lanes(matrix, row, column + 4, six[1])


# Four items side by side, each with its row of a matrix: rows are gathered into lanes, a register for each column, and lanes added to them.

LANES = 4


def _let_operate(operation: Callable[..., Any], instruction: str) -> None:
    """Give an operator of Python between lanes, or lanes and a float."""

    @type_callable(operation)
    def typer_of(_: Any) -> Callable[..., Any]:
        def typer(a: Any, b: Any) -> Any:
            lanes = a if isinstance(a, Lanes) else b
            return lanes if isinstance(lanes, Lanes) and all(kind in (lanes, lanes.dtype) for kind in (a, b)) else None

        return typer

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = signature.return_type.vector
        return getattr(builder, instruction)(*(x if x.type == kind else _spread(builder, kind, x) for x in arguments))

    for kinds in ((Lanes, Lanes), (Lanes, types.Float), (types.Float, Lanes)):
        lower_builtin(operation, *kinds)(generate)


for _operation, _instruction in (
    (operator.add, "fadd"),
    (operator.iadd, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _let_operate(_operation, _instruction)


@intrinsic
def root_of(typing: Any, lanes: Lanes | types.Float) -> Any:
    """Square roots; that of a float too."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = arguments[0].type
        name = f"llvm.sqrt.v{lanes.count}f{lanes.dtype.bitwidth}" if isinstance(lanes, Lanes) else f"llvm.sqrt.f{lanes.bitwidth}"
        return builder.call(declared(builder, ir.FunctionType(kind, [kind]), name), arguments)

    return lanes(lanes), generate


@intrinsic
def where_at_most(typing: Any, x: Any, y: Any, yes: Any, no: Any) -> Any:
    """The places of ``yes`` where x <= y, and of ``no`` elsewhere, where one of the two is not a number too; each lanes or a float."""
    given = (x, y, yes, no)
    kind = next((each for each in given if isinstance(each, Lanes)), x)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        lanes = signature.return_type
        low, high, one, other = (
            _spread(builder, lanes.vector, value) if each != lanes else value for each, value in zip(given, arguments, strict=True)
        )
        return builder.select(builder.fcmp_ordered("<=", low, high), one, other)

    return kind(*given), generate


@intrinsic
def sum_of(typing: Any, lanes: Lanes) -> Any:
    """The sum of all places, one after the other."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        total, *others = (builder.extract_element(arguments[0], _INDEX(k)) for k in range(lanes.count))
        for other in others:
            total = builder.fadd(total, other)
        return total

    return lanes.dtype(lanes), generate


@intrinsic
def gather(typing: Any, matrix: types.Array, rows: types.Array, group: types.Integer, first: types.Integer, column: types.Integer) -> Any:
    """Entries of a column of a contiguous matrix, in double precision, of the rows that stand in rows[group, first : first + LANES]."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        out = ir.Constant(_DOUBLES.vector, ir.Undefined)
        for k, address in enumerate(_addresses(context, builder, signature, arguments)):
            value = builder.load(address)
            out = builder.insert_element(out, value if matrix.dtype == types.float64 else builder.fpext(value, ir.DoubleType()), _INDEX(k))
        return out

    return (_DOUBLES(matrix, rows, group, first, column), generate) if _is_plain(matrix) else None


@intrinsic
def scatter(
    typing: Any, matrix: types.Array, rows: types.Array, group: types.Integer, first: types.Integer, column: types.Integer, lanes: Lanes
) -> Any:
    """Add lanes to the entries that :func:`gather` gives, one after the other: two of the rows may be the same."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        for k, address in enumerate(_addresses(context, builder, signature, arguments)):
            builder.store(builder.fadd(builder.load(address), builder.extract_element(arguments[5], _INDEX(k))), address)
        return context.get_dummy_value()

    return (types.void(matrix, rows, group, first, column, lanes), generate) if _is_plain(matrix) else None


@borrower(forceinline=True)
def gather_six(matrix, rows, group, first):
    """The six columns of the rows that stand in rows[group, first : first + LANES], as :func:`gather` gives each."""
    left = gather(matrix, rows, group, first, 0), gather(matrix, rows, group, first, 1), gather(matrix, rows, group, first, 2)
    return left + (gather(matrix, rows, group, first, 3), gather(matrix, rows, group, first, 4), gather(matrix, rows, group, first, 5))


@borrower(forceinline=True)
def scatter_six(matrix, rows, group, first, six):
    """Add six columns of lanes to the rows of :func:`gather_six`, as :func:`scatter` adds one."""
    for k in range(6):
        scatter(matrix, rows, group, first, k, six[k])


def _addresses(context: Any, builder: Any, signature: Any, arguments: Any) -> list[Any]:
    """Where the entries of :func:`gather` are, its arguments."""
    matrix, rows = (context.make_array(signature.args[k])(context, builder, arguments[k]) for k in range(2))
    group, first, column = (context.cast(builder, arguments[k], signature.args[k], types.intp) for k in (2, 3, 4))
    at = builder.gep(rows.data, [builder.add(builder.mul(group, builder.extract_value(rows.shape, 1)), first)])
    found = []
    for k in range(LANES):
        entry = builder.add(builder.mul(builder.load(builder.gep(at, [_INDEX(k)])), builder.extract_value(matrix.shape, 1)), column)
        found.append(builder.gep(matrix.data, [entry]))
    return found


def _is_plain(matrix: Any) -> bool:
    """Return True if a type is that of a contiguous matrix of floats."""
    return isinstance(matrix, types.Array) and matrix.ndim == 2 and matrix.layout == "C" and isinstance(matrix.dtype, types.Float)


def _spread(builder: Any, kind: ir.VectorType, value: Any) -> Any:
    """A float in each place of a vector."""
    nothing = ir.Constant(kind, ir.Undefined)
    first = ir.Constant(ir.VectorType(_INDEX, kind.count), [0] * kind.count)
    return builder.shuffle_vector(builder.insert_element(nothing, value, _INDEX(0)), nothing, first)


def _cast(builder: Any, value: Any, kind: ir.VectorType) -> Any:
    """A vector in the precision of another kind."""
    if value.type.element == kind.element:
        return value
    return (builder.fpext if isinstance(kind.element, ir.DoubleType) else builder.fptrunc)(value, kind)


def _address(context: Any, builder: Any, signature: Any, arguments: Any, kind: ir.VectorType) -> Any:
    """Where the entries of a matrix from a row and a column on are, the first three arguments."""
    matrix = context.make_array(signature.args[0])(context, builder, arguments[0])
    row, column = (context.cast(builder, arguments[k], signature.args[k], types.intp) for k in (1, 2))
    entry = builder.add(builder.mul(row, builder.extract_value(matrix.shape, 1)), column)
    return builder.bitcast(builder.gep(matrix.data, [entry]), kind.as_pointer())
