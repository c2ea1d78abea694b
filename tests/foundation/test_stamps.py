# SPDX-License-Identifier: GPL-3.0-or-later
"""What a compiled kernel is stamped by: everything that decides what it computes, and nothing else."""

from __future__ import annotations

from types import FunctionType
from typing import Any

import pytest

from masonry_cd.foundation import stamps
from masonry_cd.foundation.stamps import stamp

SOURCE = """
import math
from typing import NamedTuple
import numpy as np
import tools
from masonry_cd.foundation.jit import entry, kernel

ONE, TWO, TABLE, OTHER = 1.0, 2.0, np.array([3.0, 4.0]), 5

class Pair(NamedTuple):
    first: float
    second: float

@kernel(fastmath=False)
def scaled(x):
    return TWO * x

@kernel()
def neighbour(x):
    return x - OTHER

GIVEN = (scaled, ONE)

@entry()
def result(x):
    '''A number.'''
    pair = Pair(x, GIVEN[0](x))
    return pair.first + GIVEN[1] * TABLE[0] + math.sqrt(pair.second) + tools.shifted(x)
"""
TOOLS = """
from masonry_cd.foundation.jit import kernel
SHIFT = 1

@kernel()
def shifted(x):
    return x + SHIFT

@kernel()
def unused(x):
    return 7.0 * x
"""


def stamped(monkeypatch: pytest.MonkeyPatch, change: tuple[str, str] = ("", "")) -> str:
    """The stamp of ``result`` after a change of the sources."""
    made: list[dict[str, Any]] = []
    for name, text in (("tools", TOOLS), ("above", SOURCE)):
        module = type(stamps)(name)
        monkeypatch.setitem(stamps.sys.modules, name, module)
        exec(text.replace(*change) if change[0] else text, vars(module))
        made.append(vars(module))
    function = made[1]["result"].py_func
    assert isinstance(function, FunctionType)
    return stamp(function)


@pytest.mark.parametrize(
    "change",
    [
        ("x + SHIFT", "x - SHIFT"),  # a callee in another file
        ("SHIFT = 1", "SHIFT = 2"),  # its constant
        ("ONE, TWO", "TWO, ONE"),  # two constants change places
        ("[3.0, 4.0]", "[3.0, 5.0]"),
        ("fastmath=False", "fastmath=True"),
        ("second: float", "third: float"),
        ("math.sqrt", "math.exp"),
        ("from masonry_cd.foundation.jit import entry, kernel", "from masonry_cd.foundation.jit import entry, borrower as kernel"),
    ],
)
def test_what_decides_the_code_of_a_kernel_changes_its_stamp(monkeypatch: pytest.MonkeyPatch, change: tuple[str, str]) -> None:
    assert change[0] in SOURCE + TOOLS
    assert stamped(monkeypatch, change) != stamped(monkeypatch) != ""


@pytest.mark.parametrize("change", [("A number.", "The number."), ("x - OTHER", "x"), ("7.0", "8.0"), ("GIVEN = (", "# a line\nGIVEN = (")])
def test_comments_and_neighbours_do_not(monkeypatch: pytest.MonkeyPatch, change: tuple[str, str]) -> None:
    assert stamped(monkeypatch, change) == stamped(monkeypatch)


def test_a_kernel_that_depends_on_a_file_changed_since_it_was_imported_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stamps, "BEGUN", 0.0)
    monkeypatch.setattr(stamps, "text_of", stamps.text_of.__wrapped__)
    assert stamped(monkeypatch) == ""
