# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a case by the command line, in processes of their own, and reads all that it wrote into arrays.

Nothing of the program is imported, so its modules may be rearranged at will: only its commands and its files are relied on.
"""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import h5py
import numpy as np

from benchmarks.bits.cases import Case, Solve

Arrays = dict[str, np.ndarray]
ROOT = Path(__file__).parents[2]
WALL_TIME = ("seconds", "wall_seconds", "stepping_seconds")  # the last part of a name that no run repeats
BY_THE_CLOCK = ("segments/", "closing")  # datasets that depend on when the run wrote
ABOUT_PROGRAM = ("version", "versions", "explanation", "run", "format", "inputs", "constant")  # about the program, not the result


def run_case(case: Case, environment: Mapping[str, str] | None = None) -> Arrays:
    """Run a case and return its results by name, e.g. ``result.h5/joints/opening``; texts are arrays of bytes, a line or a key each.

    Args:
        case: to be run.
        environment: variables to run it with, in addition to those of this process.

    Raises:
        RuntimeError: a command that failed, with its last line.
    """
    with TemporaryDirectory() as name:
        folder, given = Path(name), os.environ | (environment or {})
        words = ["run", str(case.scene), "-o", str(folder), "--quiet"]
        words += [word for change in case.changes for word in ("--set", change)]
        _command(given, *words, *(["--dump-problem", str(case.dump)] if case.dump else []))
        found = read_folder(folder)
        for problem in sorted(folder.glob("problem_*.npz")):
            for solve in case.solves:
                found |= _solve(problem, solve, folder, given)
    return found


def read_folder(folder: Path) -> Arrays:
    """All results of a run, without times of the clock and versions."""
    found = {f"result.h5/{name}": array for name, array in _hdf5(folder / "result.h5")}
    for path in sorted(folder.glob("*.json")):
        found |= {f"{path.name}/{key}": _text(json.dumps(value)) for key, value in _leaves(json.loads(path.read_text()))}
    for path in sorted(folder.glob("*.csv")):
        found |= _columns(path)
    for path in sorted(folder.glob("problem_*.npz")):
        found |= _npz(path, path.name)
    return found


def _solve(problem: Path, solve: Solve, folder: Path, environment: Mapping[str, str]) -> Arrays:
    """The solution of a problem from its file, and what the program says of it."""
    given = _local_form(problem, folder / "local") if solve.local else problem
    out, name = folder / "solutions" / "solution.npz", f"{problem.stem}/{solve.name}"
    said = _command(
        environment, "solve", str(given), "--solver", solve.solver, "--tolerance", repr(solve.tolerance),
        "--max-iterations", str(solve.max_iterations), "--json", "-o", str(out),
    )  # fmt: skip
    return _npz(out, name) | {f"{name}/{key}": _text(json.dumps(value)) for key, value in _leaves(json.loads(said))}


def _local_form(problem: Path, folder: Path) -> Path:
    """A file in the folder with the problem without its bodies, u = W r + q."""
    folder.mkdir(exist_ok=True)
    local = {name: array for name, array in _npz(problem, "").items() if name.startswith("/W_") or name in ("/q", "/mu")}
    np.savez(folder / problem.name, allow_pickle=False, **{name[1:]: array for name, array in local.items()})
    return folder / problem.name


def _command(environment: Mapping[str, str], *words: str) -> str:
    """Standard output of ``masonry-cd`` with these words."""
    command = [sys.executable, "-m", "masonry_cd", *words]
    done = subprocess.run(command, cwd=ROOT, env=dict(environment), capture_output=True, text=True)
    if done.returncode:
        last = (done.stderr.strip() or done.stdout.strip() or "no word").splitlines()[-1]
        raise RuntimeError(f"masonry-cd {words[0]} ended with {done.returncode}: {last}")
    return done.stdout


def _hdf5(path: Path) -> Iterator[tuple[str, np.ndarray]]:
    """Datasets and attributes of a file by name."""
    with h5py.File(path, "r") as file:
        names: list[str] = []
        file.visit(names.append)
        for name in names:
            item = file[name]
            if isinstance(item, h5py.Dataset) and name.rpartition("/")[2] not in WALL_TIME and not name.startswith(BY_THE_CLOCK):
                array = item[...]
                yield name, array.astype(np.bytes_ if array.dtype.kind == "O" else array.dtype.str)  # without h5py's notes on the type
        for name, value in file.attrs.items():
            if name not in ABOUT_PROGRAM:
                yield f"attributes/{name}", _text(*str(value).splitlines())


def _columns(path: Path) -> Arrays:
    """The columns of a table."""
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = list(csv.reader(file))
    return {f"{path.name}/{name}": _text(*(row[k] for row in rows)) for k, name in enumerate(head)}


def _npz(path: Path, name: str) -> Arrays:
    """The arrays of a file under a name."""
    with np.load(path, allow_pickle=False) as file:
        return {f"{name}/{key}": file[key] for key in file.files}


def _leaves(table: dict[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Keys with dots and values of nested tables; an empty table is a value."""
    for key, value in table.items():
        if key in WALL_TIME or key in ABOUT_PROGRAM:
            continue
        if isinstance(value, dict) and value:
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def _text(*lines: str) -> np.ndarray:
    """Texts as an array of bytes."""
    return np.array([line.encode() for line in lines], dtype=np.bytes_)
