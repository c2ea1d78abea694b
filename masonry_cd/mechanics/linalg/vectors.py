"""Several floats at once, as one instruction of the processor takes them.

The compiler makes such instructions of loops along an array, but not of products whose sums stay in registers, in which a factorisation
spends most of its time. A kernel that loads, multiplies and stores four or eight entries at a time takes half of the time there, or less.
Where the registers of a processor are shorter the compiler takes them apart; where it has no fused multiplication and addition it rounds
twice.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, register_model

from masonry_cd.foundation.jit import kernel
from masonry_cd.mechanics.linalg.intrinsics import declared

_INDEX = ir.IntType(32)


class Lanes(types.Type):
    """numba's type of so many floats of one kind in a register."""

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


def _filler(count: int) -> Callable[..., Any]:
    """An intrinsic that repeats a float so often."""

    def fill(typing: Any, value: types.Float) -> tuple[Any, Any]:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return _spread(builder, signature.return_type.vector, arguments[0])

        return Lanes(value, count)(value), generate

    return fill


def _loader(count: int) -> Callable[..., Any]:
    """An intrinsic that loads so many entries of a row of a contiguous matrix from a column on; its end is not checked."""

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


@kernel(inline="always")
def fill_six(value):
    """A float, six times."""
    return fill_four(value), fill_two(value)


@kernel(inline="always")
def pack_six(a, b, c, d, e, f):
    """Six floats."""
    return pack((a, b, c, d)), pack((e, f))


@kernel(inline="always")
def load_six(matrix, row, column):
    """Six entries of a row of a contiguous matrix from a column on."""
    return load_four(matrix, row, column), load_two(matrix, row, column + 4)


@kernel(inline="always")
def add_six_times(total, factor, six):
    """total + factor times six, as in :func:`add_times`."""
    return add_times(total[0], factor, six[0]), add_times(total[1], factor, six[1])


@kernel(inline="always")
def store_six(matrix, row, column, six):
    """Put six floats into a row of a contiguous matrix from a column on."""
    store_lanes(matrix, row, column, six[0])
    store_lanes(matrix, row, column + 4, six[1])


def _is_plain(matrix: Any) -> bool:
    """Whether a type is that of a contiguous matrix of floats."""
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
