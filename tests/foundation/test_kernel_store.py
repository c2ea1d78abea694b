# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of compiled kernels: whole or absent, shared by processes, and stamped by all that decides what a kernel computes."""

from __future__ import annotations

import os
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest

from masonry_cd.foundation import kernel_store as store
from masonry_cd.foundation import stamps
from masonry_cd.foundation.stamps import stamp


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that is written to."""
    monkeypatch.setenv(store.FOLDER, str(tmp_path / "kernels"))
    monkeypatch.setattr(store, "SHIPPED", str(tmp_path / "brought"))
    return tmp_path / "kernels"


def test_what_is_written_is_read(place: Path) -> None:
    name = store.name_of("package.kernel", "a" * 64, "float64")
    assert store.read(name) is None and not store.is_there(name)
    store.write(name, b"code")
    assert store.read(name) == b"code" and store.is_there(name)
    assert [file.name for file in place.iterdir()] == [name]


def test_another_source_kind_or_processor_has_another_file() -> None:
    names = {store.name_of("package.kernel", sources, kind) for sources in ("a" * 64, "b" * 64) for kind in ("float64", "int64")}
    assert len(names) == 4


@pytest.mark.parametrize("cut", [0, 3, 20, 35])
def test_a_file_that_is_cut_off_counts_as_absent(place: Path, cut: int) -> None:
    name = store.name_of("package.kernel", "a" * 64, "float64")
    store.write(name, b"code")
    (place / name).write_bytes((place / name).read_bytes()[:cut])
    assert store.read(name) is None


def test_a_damaged_file_counts_as_absent(place: Path) -> None:
    name = store.name_of("package.kernel", "a" * 64, "float64")
    store.write(name, b"code")
    (place / name).write_bytes(b"x" + (place / name).read_bytes()[1:])
    assert store.read(name) is None


def test_files_of_other_sources_go_when_they_are_old(place: Path) -> None:
    """Young ones may be of another checkout that shares the folder."""
    old, young, new = (store.name_of("kernel", sources, "float64") for sources in "abc")
    other = store.name_of("kernels", "a", "float64")
    for name in (old, young, other):
        store.write(name, b"code")
    for name in (old, other):
        os.utime(place / name, (0, 0))
    store.write(new, b"code")
    assert sorted(file.name for file in place.iterdir()) == sorted([young, other, new])


def test_what_a_wheel_brings_is_read_and_never_written(place: Path, tmp_path: Path) -> None:
    name = store.name_of("package.kernel", "a" * 64, "float64")
    store.write(name, b"code")
    place.rename(tmp_path / "brought")
    assert store.read(name) == b"code"
    store.write(name, b"other")
    assert store.read(name) == b"code"


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
