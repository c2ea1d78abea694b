"""Kernels with and without an entry for Python, and the cache of those that have one."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from places import ROOT

from masonry_cd.foundation.jit import entry, has_cache, kept, kernel
from masonry_cd.foundation.numba_internals import SharedFiles


@kernel()
def _half(x):
    return 0.5 * x


@entry()
def quarter(x):
    return _half(_half(x))


@entry()
def _eighth(x):
    return _half(quarter(x))


class Line(NamedTuple):
    """A line y = slope x + offset, at some places."""

    places: np.ndarray
    slope: float
    offset: float


class Drawing(NamedTuple):
    """A line, and how often it is drawn: a number of zeros."""

    line: Line
    times: tuple[int, ...]


@entry()
def heights(drawing: Drawing, scale: float) -> np.ndarray:
    line = drawing.line
    return scale * len(drawing.times) * (line.slope * line.places + line.offset)


@entry()
def total_height(drawing: Drawing, line: Line) -> float:
    return heights(drawing, 1.0).sum() + heights(Drawing(line, (0,)), 1.0).sum()


def test_kernels_call_each_other_with_and_without_an_entry():
    assert quarter(8.0) == 2.0
    assert _eighth(8.0) == 1.0


def test_python_is_refused_where_there_is_no_entry_compiled_or_not():
    for argument in (8.0, 8):  # the first version was compiled for the kernels above
        with pytest.raises(TypeError, match="called by other kernels alone"):
            _half(argument)
    assert quarter(8) == 2.0


def test_named_tuples_are_put_together_again():
    line = Line(np.array([0.0, 1.0, 2.0]), 3.0, 1.0)
    drawing = Drawing(line, (0, 0))
    assert heights(drawing, 0.5).tolist() == [1.0, 4.0, 7.0]
    assert heights(Drawing(line, (0, 0, 0)), 0.5).tolist() == [1.5, 6.0, 10.5]
    assert total_height(drawing, line) == 24.0 + 12.0  # kernels pass them on as they are


def test_what_is_kept_is_listed_by_field():
    heights(Drawing(Line(np.zeros(2), 1.0, 0.0), (0, 0)), 1.0)
    first = [drawing for drawing, _ in kept(heights)]
    assert all(isinstance(drawing, Drawing) and isinstance(drawing.line, Line) for drawing in first)
    assert 2 in {len(drawing.times) for drawing in first}


def test_kernels_do_without_a_folder_for_their_cache():
    typed: dict[str, Any] = {"__name__": __name__}
    exec("def third(x):\n    return x / 3.0", typed)  # numba finds a place for a function that a file holds, and this one has none
    compiled = entry()(typed["third"])
    assert compiled(3.0) == 1.0
    assert not has_cache(compiled) and kept(compiled) == []


class Code:
    """What compiles to a text; something else happens while it is written."""

    def __init__(self, text: str, meanwhile: Callable[[], None]) -> None:
        self.text, self.meanwhile = text, meanwhile

    def __reduce__(self) -> tuple[type[str], tuple[str]]:
        self.meanwhile()
        return str, (self.text,)


def test_processes_that_compile_at_once_do_not_take_each_others_code(tmp_path):
    """Another process, which has read the index before this one wrote it, saves its entry while this one does."""
    shared = {"cache_path": str(tmp_path), "filename_base": "scaled", "source_stamp": "1"}

    class Other(SharedFiles):
        def _load_index(self):
            return {}

    code = Code("code for integers", lambda: Other(**shared).save(("floats",), "code for floats"))
    SharedFiles(**shared).save(("integers",), code)
    assert SharedFiles(**shared).load(("integers",)) == "code for integers"
    assert SharedFiles(**shared).load(("floats",)) in (None, "code for floats")


CALLEE = """
from masonry_cd.foundation.jit import kernel

@kernel()
def scaled(x):
    return {factor} * x
"""
CALLER = """
from kernel_below import scaled
from masonry_cd.foundation.jit import entry

@entry()
def scaled_twice(x):
    return scaled(scaled(x))
"""
GIVING = """
from typing import Any, NamedTuple
import numpy as np
from kernel_below import scaled
from masonry_cd.foundation.jit import entry, kernel

class Operators(NamedTuple):
    scale: Any
    add: Any

@kernel()
def add(x, change):
    return np.array([x[0] + change[0]])

@kernel()
def iterated(operators, x):
    while x[0] < 4.0:
        x = operators.add(x, np.full(1, operators.scale(x[0])))
    return x[0]

OPERATORS = Operators(scaled, add)

@entry()
def scaled_twice(x):
    return iterated(OPERATORS, np.full(1, x))
"""
PROGRAM = """
from kernel_above import scaled_twice
print(scaled_twice(1.0), sum(scaled_twice.stats.cache_misses.values()))
"""


@pytest.fixture
def run_kernel(tmp_path):
    """Runs a kernel whose callee, in another file, multiplies by a factor: the result, and how many versions were compiled."""

    def run(factor: float, caller: str = CALLER, **environment: str) -> tuple[float, int]:
        (tmp_path / "kernel_below.py").write_text(CALLEE.format(factor=factor))
        (tmp_path / "kernel_above.py").write_text(caller)
        root = str(ROOT)
        paths = os.pathsep.join([str(tmp_path), root])
        settings = os.environ | {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(tmp_path / "cache")} | environment
        done = subprocess.run([sys.executable, "-c", PROGRAM], env=settings, capture_output=True, text=True, check=True)
        result, compiled = done.stdout.split()
        return float(result), int(compiled)

    return run


def test_an_edited_callee_in_another_file_makes_its_callers_anew(run_kernel):
    assert run_kernel(2.0) == (4.0, 1)
    assert run_kernel(2.0) == (4.0, 0)
    assert run_kernel(3.0) == (9.0, 1)
    assert run_kernel(3.0) == (9.0, 0)


def test_kernels_that_are_given_kernels_are_kept(run_kernel):
    assert run_kernel(2.0, GIVING) == (9.0, 1)
    assert run_kernel(2.0, GIVING) == (9.0, 0)
    assert run_kernel(1.0, GIVING) == (4.0, 1)


def test_a_damaged_cache_is_compiled_anew(run_kernel, tmp_path):
    assert run_kernel(2.0) == (4.0, 1)
    for file in (tmp_path / "cache").rglob("*.nb[ci]"):
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    assert run_kernel(2.0)[0] == 4.0
    assert run_kernel(2.0) == (4.0, 0)


def test_plain_njit_gives_the_same_and_keeps_nothing(run_kernel, tmp_path):
    assert run_kernel(2.0, MASONRY_CD_PLAIN_NJIT="1")[0] == 4.0
    assert not list((tmp_path / "cache").rglob("*.nbc"))


FULL_DISC = """
import resource
from kernel_above import scaled_twice
from masonry_cd.foundation.jit import lost
scaled_twice(1.0), lost() is None or print("lost too early")
resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))  # no file may grow: what is written fails as on a full disc
print(scaled_twice(1), lost().strerror)
"""


def test_what_a_full_disc_does_not_take_is_known(run_kernel, tmp_path):
    run_kernel(2.0)
    settings = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)]), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, "-c", FULL_DISC], env=settings, capture_output=True, text=True, check=True)
    assert done.stdout == "4.0 File too large\n"
