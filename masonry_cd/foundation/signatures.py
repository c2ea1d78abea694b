# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that the user gives, asked before anything runs whether they can be called as they will be."""

from __future__ import annotations

import inspect
import pickle
from collections.abc import Mapping

from masonry_cd.foundation.errors import InputError


def require_call(function: object, arguments: str, where: object, name: str = "f") -> None:
    """Check that something takes some positional arguments; compiled code that does not state its arguments is not checked.

    Args:
        function: of Python, or compiled by numba.
        arguments: names of what it will be given, "problem, options, start".
        where: for messages.
        name: of the function in the contract.

    Raises:
        InputError: says how it is called, and its arguments.
    """
    if not callable(function):
        raise InputError(where, f"a function {name}({arguments}) is needed, got a {type(function).__name__}")
    try:
        signature = inspect.signature(getattr(function, "py_func", function))
    except (TypeError, ValueError):
        return
    try:
        signature.bind(*arguments.split(", "))
    except TypeError:
        takes = ", ".join(str(one.replace(annotation=one.empty)) for one in signature.parameters.values())
        own = getattr(function, "__name__", type(function).__name__)
        raise InputError(where, f"a function {name}({arguments}) is needed, and {own}({takes}) cannot be called so") from None


def require_picklable(given: Mapping[str, object]) -> None:
    """Check that functions and what else was given by name can be pickled: those that a module has at its top.

    Raises:
        InputError: names the one that cannot.
    """
    for name, value in given.items():
        try:
            pickle.dumps(value)
        except Exception as failure:  # whatever an object raises when its parts are read
            text = f"cannot be pickled ({' '.join(str(failure).split())}); functions at the top of a module can, others cannot"
            raise InputError(name, text) from None
