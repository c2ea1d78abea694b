# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs in one sitting: every program in a process of its own, on one thread; and the tables that say what they did on which machine."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.scenes import BenchScene

HERE = Path(__file__).parent


def environment(threads: int) -> dict[str, str]:
    """The environment of every process, which limits the threads of whatever it calls."""
    return os.environ | {name: str(threads) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")}


def run_lmgc90(python: str, made: BenchScene, steps: int, seconds: float, folder: Path) -> dict[str, np.ndarray]:
    """Step a scene with LMGC90 in its own Python.

    Raises:
        RuntimeError: it failed; the last line that it wrote.
    """
    made.write(folder / "scene.json", steps)
    command = [python, str(HERE / "lmgc90.py"), str(folder / "scene.json"), str(folder / "lmgc90.npz"), "--seconds", str(seconds)]
    _call(command, "LMGC90", folder)
    with np.load(folder / "lmgc90.npz") as file:
        return dict(file)


def run_ours(name: str, steps: int, solver: str, tolerance: float, extra: Sequence[str] = ()) -> dict[str, Any]:
    """Step a scene with masonry_cd in a process of its own; the fields of ``ours.Measured``."""
    return numbers_of("benchmarks.ours", [name, "--steps", str(steps), "--solver", solver, "--tolerance", str(tolerance), *extra])


def numbers_of(module: str, arguments: Sequence[str]) -> dict[str, Any]:
    """Return the output of a benchmark of ours with ``--json``, run in a process of its own.

    Raises:
        RuntimeError: it failed; the last line that it wrote.
    """
    out = _call([sys.executable, "-m", module, *arguments, "--json"], "masonry_cd", HERE.parent)
    return dict(json.loads(out.splitlines()[-1]))


def _call(command: list[str], who: str, folder: Path) -> str:
    done = subprocess.run(command, cwd=folder, env=environment(1), capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{who}: {(done.stderr.strip() or 'failed without a word').splitlines()[-1]}")
    return done.stdout


def head(*cells: str) -> str:
    """The first two lines of a Markdown table."""
    return f"| {' | '.join(cells)} |\n|{'---|' * len(cells)}"


def sitting() -> str:
    """The machine and its load, for the record."""
    load = ", ".join(f"{x:.1f}" for x in os.getloadavg())
    return f"{os.cpu_count()} cores, load {load}; Python {platform.python_version()}; one thread each"
