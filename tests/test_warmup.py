"""Warm-up: after it a run compiles nothing more, so that its times are its own."""

from __future__ import annotations

import sys
from collections import Counter

import pytest
from numba.core.dispatcher import Dispatcher

from masonry_cd import case
from masonry_cd.scene import read_scene


def versions() -> Counter[str]:
    """How many versions of each kernel, one for each set of types of its arguments, are compiled or loaded from the cache."""
    rooms = [vars(module) for name, module in sys.modules.items() if name.startswith(("masonry_cd.", "structures.", "loads.", "tests."))]
    kernels = {f"{k.py_func.__module__}.{k.py_func.__name__}": k for room in rooms for k in room.values() if isinstance(k, Dispatcher)}
    return Counter({name: len(kernel.signatures) for name, kernel in kernels.items()})


@pytest.mark.parametrize("planar", [True, False])
def test_a_run_compiles_nothing(block_on_plate, tmp_path, planar):
    changes = ["run.solver=auto", f"run.planar={str(planar).lower()}", "material.friction=0.2", "run.duration=0.3"]
    prepared = case.prepare(read_scene(block_on_plate(), changes))
    before = versions()
    summary = case.run_case(prepared, tmp_path / "out")
    assert summary["steps"] == 300
    assert versions() - before == Counter()
    assert before["masonry_cd.coulomb.admm_bodies"] > 0
