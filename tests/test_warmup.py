"""Warm-up: after it a run compiles nothing more, so that its times are its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from numba.core import event

from masonry_cd import case
from masonry_cd.scene import read_scene


@contextmanager
def kernels_compiled() -> Iterator[list[str]]:
    """Names of the kernels that are compiled, or loaded from the cache, in the body."""
    names: list[str] = []

    class Listener(event.Listener):
        def on_start(self, happening: event.Event) -> None:
            names.append(happening.data["dispatcher"].py_func.__qualname__)

        def on_end(self, happening: event.Event) -> None:
            pass

    with event.install_listener("numba:compile", Listener()):
        yield names


def test_the_listener_hears_what_is_compiled():
    from numba import njit

    with kernels_compiled() as names:
        njit(lambda x: x + 1)(1)
    assert len(names) == 1


@pytest.mark.parametrize("planar", [True, False])
def test_a_run_compiles_nothing(block_on_plate, tmp_path, planar):
    changes = ["run.solver=auto", f"run.planar={str(planar).lower()}", "material.friction=0.2", "run.duration=0.3"]
    prepared = case.prepare(read_scene(block_on_plate(), changes))
    with kernels_compiled() as names:
        summary = case.run_case(prepared, tmp_path / "out")
    assert summary["steps"] == 300
    assert names == []
