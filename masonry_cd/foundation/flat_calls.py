# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls from Python to kernels that take NamedTuples: field by field, since numba looks longer at a NamedTuple than at its fields.

At each call numba finds out the type of each argument, for a NamedTuple also by the names of its fields, which takes longer than for as
many single arrays. So a kernel is entered through another one, made here, that takes all fields one by one and puts the NamedTuples
together again in compiled code, where that costs nothing:

    kernel(position, shapes)   ->   flat(position, *shapes)   ->   kernel(position, Shapes(a, b, c))

Which arguments are NamedTuples is said by the annotations of the kernel.
"""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature
from types import FunctionType
from typing import Any, get_type_hints

Classes = list[Any]  # of each argument: its class if that is a NamedTuple, else None


def named_tuples(function: Callable[..., Any]) -> Classes:
    """Return, by argument of a function, the class of NamedTuple that its annotation names, or None."""
    hints = get_type_hints(function)
    return [_as_named_tuple(hints.get(name)) for name in signature(function).parameters]


def _as_named_tuple(kind: Any) -> Any:
    return kind if isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields") else None


class FlatCall:
    """A kernel as Python calls it.

    Args:
        function: the kernel's.
        kernel: what other kernels call, compiled as part of them.
        compile_flat: compiles the function through which Python enters.
    """

    def __init__(self, function: Callable[..., Any], kernel: Any, compile_flat: Callable[[Callable[..., Any]], Any]) -> None:
        kinds, name = named_tuples(function), function.__name__
        classes: dict[str, Any] = {}
        leaves: list[str] = []
        whole = ", ".join([_whole(kind, classes, leaves) for kind in kinds])
        put_together = f"def {name}({', '.join(leaves)}):\n    return call({whole})\n"
        given = [f"argument_{i}" for i in range(len(kinds))]
        apart = ", ".join(map(_apart, given, kinds))
        take_apart = f"def {name}({', '.join(given)}):\n    return call({apart})\n"
        flat = _made(name, put_together, classes | {"call": kernel})
        flat.__module__, flat.__qualname__ = function.__module__, function.__qualname__
        self.flat = compile_flat(flat)
        self.spread = _made(name, take_apart, {"call": self.flat})


def _apart(value: str, kind: Any) -> str:
    """Arguments of a call that pass the fields of a value one by one."""
    if kind is None:
        return value
    inner = _fields(kind)
    if not any(inner):
        return f"*{value}"
    return ", ".join(_apart(f"{value}[{i}]", each) for i, each in enumerate(inner))


def _whole(kind: Any, classes: dict[str, Any], leaves: list[str]) -> str:
    """The expression that puts a value together: from further arguments, whose names go to ``leaves``, by ``classes``, which get names."""
    if kind is None:
        leaves.append(f"leaf_{len(leaves)}")
        return leaves[-1]
    name = f"class_{len(classes)}"
    classes[name] = kind
    return f"{name}({', '.join([_whole(each, classes, leaves) for each in _fields(kind)])})"


def _fields(kind: Any) -> Classes:
    """The classes of the fields of a NamedTuple."""
    hints = get_type_hints(kind)
    return [_as_named_tuple(hints.get(name)) for name in kind._fields]


def _made(name: str, source: str, names: dict[str, Any]) -> FunctionType:
    """The function of a name that a source defines."""
    space = dict(names)
    exec(source, space)
    made: FunctionType = space[name]
    return made
