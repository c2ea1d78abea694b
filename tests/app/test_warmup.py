# SPDX-License-Identifier: GPL-3.0-or-later
"""Warm-up: after it a run compiles nothing more, so that its times are its own."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
import scenes

from masonry_cd.app import warmup
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.app.warmup import SceneKind
from masonry_cd.foundation import kernel_store
from masonry_cd.foundation.jit import Entry
from masonry_cd.mechanics.solvers import SOLVERS, Options


def compiled() -> Counter[str]:
    """How many versions of each kernel, one for each set of types of its arguments, this process has compiled and not loaded."""
    modules = [vars(module) for name, module in sys.modules.items() if name.startswith(("masonry_cd.", "structures.", "loads.", "tests."))]
    kernels = {kernel for module in modules for kernel in module.values() if isinstance(kernel, Entry)}
    return Counter({f"{k.__module__}.{k.__name__}": sum(k.outer.stats.cache_misses.values()) for k in kernels if "outer" in vars(k)})


def edited(scene: Path, edit: Callable[[str], str]) -> Path:
    """The scene, its file of blocks changed."""
    blocks = scene.with_name("blocks.json")
    blocks.write_text(edit(blocks.read_text()))
    return scene


def lifted(text: str) -> str:
    """The lower corners of the block, so that it drops."""
    return text.replace("0.25, 0.0]", "0.25, 0.01]")


def with_ball(text: str) -> str:
    """A sphere next to the block."""
    structure = json.loads(text)
    structure["blocks"].append({"name": "ball", "centre": [-1.2, 0.0, 0.26], "radius": 0.25, "density": 2000.0})
    return json.dumps(structure)


SLIDES, MOVES = ["material.friction=0.2"], ["run.settle=false", "run.duration=0.1"]


@pytest.mark.parametrize(
    ("changes", "edit"),
    [
        (["run.solver=auto", "run.planar=true", *SLIDES, "run.duration=0.1"], str),
        (["run.solver=auto", "run.planar=false", *SLIDES, "run.duration=0.1"], str),
        (["run.solver=nlgs", *MOVES, *SLIDES, "material.deformable=uniform", "material.young=1e9"], str),
        (["run.solver=auto", *MOVES], lifted),
        (["run.solver=nlgs", *MOVES, "material.rolling_friction=0.01"], with_ball),
    ],
    ids=["in a plane", "in space", "blocks that deform", "a block that lands", "spheres"],
)
def test_a_run_compiles_nothing(block_on_plate, tmp_path, changes, edit):
    prepared = prepare(read_scene(edited(block_on_plate(), edit), changes))
    before = compiled()
    assert run_case(prepared, tmp_path / "out").steps == 100
    assert compiled() - before == Counter()


def test_packed_grains_find_their_sweeps_compiled(block_on_plate):
    """auto begins with them from hundreds of contacts on, which the cubes do not have."""
    prepare(read_scene(edited(block_on_plate(), with_ball), ["run.solver=auto"]))
    before = compiled()
    assert SOLVERS["auto"](scenes.packing(4, mu=0.3, speed=0.0), Options(tolerance=1e-4), None).reason == "accelerated: converged"
    assert compiled() - before == Counter()


@pytest.mark.parametrize("planar", [True, False])
def test_the_two_processes_compile_what_a_run_needs(planar):
    kind = SceneKind("auto", planar)
    with warmup.compiling(kind):
        pass
    before = compiled()
    for process in (0, 1):
        warmup.compile_jobs(kind, process)
    assert compiled() - before == Counter()


def test_a_run_in_a_plane_does_not_wait_for_methods_that_it_seldom_needs(monkeypatch):
    asked: list[str] = []
    monkeypatch.setattr(warmup, "SOLVERS", {name: lambda *_, name=name: asked.append(name) for name in ("pivoting", *warmup.SELDOM)})
    monkeypatch.setattr(warmup, "shake_cubes", lambda kind, unsolved=False: asked.append(kind.solver))
    monkeypatch.setitem(warmup.JOBS, True, ((), ("pivoting",)))
    warmup.compile_missing(SceneKind("auto", True))
    assert asked == ["pivoting", "admm"]


def test_what_is_compiled_is_known_until_a_file_is_missing(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    kind, name = SceneKind("nlgs", True), kernel_store.name_of("package.kernel", "sources", "float64")
    assert not kind.is_compiled()
    monkeypatch.setattr(kernel_store, "used", {name})
    kernel_store.write(name, b"code")
    kind.note()
    assert kind.is_compiled() and not replace(kind, planar=False).is_compiled()
    (tmp_path / name).unlink()
    assert not kind.is_compiled()


def test_a_run_does_without_a_second_process(monkeypatch, tmp_path):
    failing = tmp_path / "python"
    failing.write_text("#!/bin/sh\nexit 1\n")
    for mode in (0o644, 0o755):  # cannot be started; fails
        failing.chmod(mode)
        monkeypatch.setattr(sys, "executable", str(failing))
        with warmup.second_process(SceneKind("auto", True)) as other:
            assert (other is None) == (mode == 0o644)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at the processes under /proc")
def test_no_second_process_outlives_a_killed_first_one(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))  # it has everything to compile
    code = (
        "import time\nfrom masonry_cd.app import warmup\n"
        "kind = warmup.SceneKind('auto', True)\nwith warmup.second_process(kind) as p:\n print(p.pid, flush=True)\n"
        " time.sleep(600)"
    )
    first = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    status = Path(f"/proc/{int(first.stdout.readline())}/stat")

    def lives() -> bool:
        return status.exists() and status.read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z"

    assert lives()
    first.kill()
    first.communicate()
    for _ in range(6000):
        if not lives():
            return
        time.sleep(0.1)
    raise AssertionError("the second process goes on")
