# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels with and without an entry for Python, and the cache of those that have one."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from places import ROOT

from masonry_cd.foundation.jit import entry, kernel


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
print(scaled_twice(1.0), sum(getattr(scaled_twice, "outer", scaled_twice).stats.cache_misses.values()))
"""


def run_kernel(folder: Path, factor: float, caller: str = CALLER, **environment: str) -> tuple[float, int]:
    """Run a kernel whose callee, in another file, multiplies by a factor: the result, and how many versions were compiled."""
    (folder / "kernel_below.py").write_text(CALLEE.format(factor=factor))
    (folder / "kernel_above.py").write_text(caller)
    result, compiled = in_python(PROGRAM, folder, **environment).split()
    return float(result), int(compiled)


def in_python(program: str, folder: Path, **environment: str) -> str:
    """The output of a program that finds the kernels in a folder."""
    places = {"PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)]), "NUMBA_CACHE_DIR": str(folder / "cache")}
    settings = os.environ | places | environment
    # without bytecode, which is taken for that of a module written in the same second
    command = [sys.executable, "-B", "-c", program]
    return subprocess.run(command, env=settings, capture_output=True, text=True, check=True).stdout.strip()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the kernels and what was kept of them as they were compiled, for a factor of two."""
    folder = tmp_path_factory.mktemp("kernels")
    assert run_kernel(folder, 2.0) == (4.0, 1)
    return folder


@pytest.fixture
def kept(made: Path, tmp_path: Path) -> Path:
    """A copy of that folder."""
    return shutil.copytree(made, tmp_path, dirs_exist_ok=True)


def test_an_edited_callee_in_another_file_makes_its_callers_anew(kept):
    assert run_kernel(kept, 2.0) == (4.0, 0)
    assert run_kernel(kept, 3.0) == (9.0, 1)


def test_kernels_that_are_given_kernels_are_kept(tmp_path):
    assert run_kernel(tmp_path, 2.0, GIVING) == (9.0, 1)
    assert run_kernel(tmp_path, 2.0, GIVING) == (9.0, 0)
    assert run_kernel(tmp_path, 1.0, GIVING) == (4.0, 1)


def test_a_damaged_cache_is_compiled_anew(kept):
    for file in (kept / "cache").rglob("*.nb[ci]"):
        file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    assert run_kernel(kept, 2.0)[0] == 4.0
    assert run_kernel(kept, 2.0) == (4.0, 0)


LATER = """
from kernel_above import scaled_twice
from masonry_cd.foundation.jit import entry

@entry()
def once_more(x):
    return scaled_twice(x) + 1.0
"""


def test_a_kernel_that_is_compiled_later_takes_in_an_entry_of_which_only_machine_code_was_loaded(kept):
    (kept / "kernel_later.py").write_text(LATER)
    names = "from kernel_later import once_more, scaled_twice"
    said = in_python(f"{names}\nprint(scaled_twice(1.0), once_more(1.0), scaled_twice.outer.stats.cache_hits)", kept)
    assert said.startswith("4.0 5.0 Counter({(float64,): 1}")


def test_loading_an_entry_does_not_fill_the_registries_of_numba(kept):
    """They take longer than a small run."""
    program = "import sys\nfrom kernel_above import scaled_twice\nprint(scaled_twice(1.0), 'numba.np.arraymath' in sys.modules)"
    assert in_python(program, kept) == "4.0 False"


def test_kernels_that_a_wheel_brings_are_used_where_nothing_can_be_written(kept):
    (kept / "cache").rename(kept / "brought")
    (kept / "cache").touch()  # no folder
    program = "from masonry_cd.foundation import kernel_store\nkernel_store.SHIPPED = {!r}\n" + PROGRAM
    assert in_python(program.format(str(kept / "brought")), kept) == "4.0 0"
    assert in_python(program.format(str(kept / "elsewhere")), kept) == "4.0 1"


def test_the_clock_of_steps_leaves_out_the_loading_of_kernels(kept):
    program = """
import time
from kernel_above import scaled_twice
from masonry_cd.foundation import kernel_store
load, kernel_store.read = kernel_store.read, lambda name: time.sleep(0.2) or load(name)
begin, own = time.perf_counter(), kernel_store.clock()
scaled_twice(1.0)
print(time.perf_counter() - begin - (kernel_store.clock() - own) > 0.2)
"""
    assert in_python(program, kept) == "True"


def test_plain_njit_gives_the_same_and_keeps_nothing(tmp_path):
    assert run_kernel(tmp_path, 2.0, MASONRY_CD_PLAIN_NJIT="1")[0] == 4.0
    assert not list((tmp_path / "cache").rglob("*.nbc"))


FULL_DISC = """
import resource
from kernel_above import scaled_twice
from masonry_cd.foundation.jit import lost
scaled_twice(1.0), lost() is None or print("lost too early")
resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))  # no file may grow: what is written fails as on a full disc
print(scaled_twice(1), lost().strerror)
"""


def test_what_a_full_disc_does_not_take_is_known(kept):
    assert in_python(FULL_DISC, kept) == "4.0 File too large"


LACKING = """
import numba.core.typed_passes
del numba.core.typed_passes.NativeLowering
from kernel_above import scaled_twice
from masonry_cd.foundation.jit import why_nothing_is_kept
print(scaled_twice(1.0), why_nothing_is_kept())
"""


def test_a_numba_that_lacks_a_private_name_leaves_plain_njit_and_the_reason(kept):
    said = in_python(LACKING, kept)
    assert said.startswith("4.0 numba ") and "NativeLowering" in said


NEWER = """
import numba
numba.version_info = numba.version_info._replace(minor=99)
from kernel_above import scaled_twice
from masonry_cd.foundation.jit import why_nothing_is_kept
print(scaled_twice(1.0), why_nothing_is_kept())
"""


def test_beyond_the_versions_tried_plain_njit_serves(kept):
    assert "is newer than" in in_python(NEWER, kept)
