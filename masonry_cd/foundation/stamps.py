# SPDX-License-Identifier: GPL-3.0-or-later
"""One hash of all that a compiled kernel depends on: an edit of a callee in another file changes it, an edit of a comment or of a
neighbour does not.

A kernel stands for its own code as Python has compiled it (instructions, constants, names, without docstring and lines), its options, and
all that its names mean: other kernels in the same way, numbers and arrays by their values, NamedTuples by their fields, what comes with
Python, numpy or numba by its name. Anything else, such as an intrinsic, is taken by the text of its module.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

BEGUN = time.time()  # when this process had imported no module with kernels yet [s]
LIBRARIES = {"numba", "llvmlite", "numpy", "scipy", *sys.stdlib_module_names}  # whose versions are part of what code is compiled for
HOW = "masonry_cd.foundation.numba_internals"  # decides what any kernel is compiled to


def stamp(function: FunctionType) -> str:
    """The hash of a function that is compiled; empty where it depends on the text of a module that has changed since this process began."""
    texts, left, seen = {text_of(HOW)}, [function], set[FunctionType]()
    while left:
        if (one := left.pop()) not in seen:
            seen.add(one)
            text, reached = _of_function(one)
            texts.add(text)
            left += reached
    return "" if "" in texts else sha256("\0".join(sorted(texts)).encode()).hexdigest()


@cache
def _of_function(function: FunctionType) -> tuple[str, list[FunctionType]]:
    """The text of a function, empty where it cannot be had, and the functions of the kernels that it reaches."""
    reached, names, shown = list[FunctionType](), set[str](), [f"{function.__module__}.{function.__qualname__}"]
    for code in _codes(function.__code__):
        constants = [constant for constant in code.co_consts if not isinstance(constant, CodeType)]
        if constants and constants[0] == function.__doc__:
            constants[0] = ""
        shown += [code.co_code.hex(), *(_shown(constant, reached) for constant in constants)]
        shown += [repr((code.co_names, code.co_varnames, code.co_freevars, code.co_flags, code.co_argcount))]
        names |= {*code.co_names}
    values = _named(names, function.__globals__)
    values |= {name: cell.cell_contents for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)}
    shown += [f"{name} = {_shown(value, reached)}" for name, value in values.items()] + [_shown(function.__defaults__, reached)]
    return "" if "" in shown else "\n".join(shown), reached


def _named(names: set[str], space: dict[str, Any], place: str = "") -> dict[str, Any]:
    """The values of names in a module, and of those in the modules that they stand for."""
    found = {f"{place}{name}": space[name] for name in sorted(names & space.keys())}
    for name, value in [*found.items()]:
        if isinstance(value, ModuleType) and not _comes_along(value.__name__):
            found |= _named(names, vars(value), f"{name}.")
    return found


def _comes_along(module: str) -> bool:
    """True for a module that is one of LIBRARIES, or in it."""
    return module.partition(".")[0] in LIBRARIES


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code and that of the functions within it."""
    yield code
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _codes(inner)


def _shown(value: Any, reached: list[FunctionType]) -> str:
    """A value as text, empty where it cannot be had; kernels are shown by name and options, and their functions added to ``reached``."""
    if hasattr(value, "py_func") and hasattr(value, "targetoptions"):  # a kernel, here or of another package
        reached.append(value.py_func)
        return f"{value.py_func.__qualname__} {_shown(tuple(sorted(value.targetoptions.items())), reached)}"
    if isinstance(value, (tuple, frozenset, set)):
        inner = [_shown(one, reached) for one in value]
        return f"{type(value).__qualname__} {inner if isinstance(value, tuple) else sorted(inner)}" if all(inner) else ""
    if isinstance(value, np.ndarray):
        return f"array {value.dtype} {value.shape} {sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, type) and issubclass(value, (tuple, BaseException)):
        return f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', '')}"
    if isinstance(value, ModuleType):
        return value.__name__  # what it names that is used is shown by itself
    module = getattr(value, "__module__", None) or type(value).__module__
    return f"{type(value).__qualname__} {getattr(value, '__name__', value)!r}" if _comes_along(module) else text_of(module)


@cache
def text_of(module: str) -> str:
    """The text of a module; empty where it has been written to, or put into its place, since this process began."""
    path = Path(getattr(sys.modules.get(module), "__file__", None) or "")
    if not path.is_file():
        return module
    return "" if path.stat().st_ctime > BEGUN else path.read_text(encoding="utf-8", errors="replace")
