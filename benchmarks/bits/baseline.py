# SPDX-License-Identifier: GPL-3.0-or-later
"""The kept results: FILE.json with a hash of each array and the machine that made them; the arrays in a folder FILE next to it."""

from __future__ import annotations

import hashlib
import json
import os
import platform
from collections.abc import Iterable
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path

import numpy as np

from benchmarks.bits.runs import Arrays

PACKAGES = ("numpy", "scipy", "numba", "llvmlite", "h5py", "qdldl", "gmsh")
SETTINGS = (
    "MASONRY_CD_NATIVE",
    "NUMBA_CPU_NAME",
    "NUMBA_CPU_FEATURES",
    "OPENBLAS_CORETYPE",
    "NPY_DISABLE_CPU_FEATURES",
)  # of the environment, that choose instructions


def digest(array: np.ndarray) -> str:
    """SHA-256 of the type, the shape and the bytes of an array."""
    head = f"{array.dtype.str} {array.shape} ".encode()
    return hashlib.sha256(head + np.ascontiguousarray(array).tobytes()).hexdigest()


def machine() -> dict[str, str]:
    """Return the processor and the packages, on which bits depend besides the program."""
    found = {"cpu": _processor(), "python": platform.python_version()}
    for name in PACKAGES:
        with suppress(Exception):
            found[name] = version(name)
    return found | {name: os.environ[name] for name in SETTINGS if name in os.environ}


def _processor() -> str:
    """The name of the processor."""
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def save(file: Path, case: str, found: Arrays) -> None:
    """Keep the results of a case; those of other cases stay, unless another machine made them."""
    kept = load(file) if file.exists() else {}
    if kept.get("machine") != machine():
        kept = {"machine": machine(), "cases": {}}
    kept["cases"][case] = {name: digest(array) for name, array in sorted(found.items())}
    _arrays(file, case).parent.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(_arrays(file, case), allow_pickle=False, **found)
    file.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


def load(file: Path) -> dict:
    """``{"machine": {...}, "cases": {case: {array: hash}}}``."""
    return dict(json.loads(file.read_text(encoding="utf-8")))


def machine_lines(kept: dict) -> list[str]:
    """Return the differences to the machine of a baseline."""
    then, now = kept["machine"], machine()
    names = [name for name in {**then, **now} if then.get(name) != now.get(name)]
    return [f"another machine: {name} was {then.get(name, 'not there')}, is {now.get(name, 'not there')}" for name in names]


def differences(file: Path, case: str, found: Arrays) -> list[str]:
    """A line for each array that is not the same to the bit; none where all are."""
    hashes = load(file)["cases"].get(case)
    if hashes is None:
        return ["not in the baseline"]
    changed = [name for name in sorted({*hashes, *found}) if name not in found or hashes.get(name) != digest(found[name])]
    return list(_lines(_arrays(file, case), changed, hashes, found)) if changed else []


def _lines(path: Path, changed: Iterable[str], hashes: dict[str, str], found: Arrays) -> Iterable[str]:
    """Yield the changes, array by array."""
    before: Arrays = {}
    if path.exists():
        with np.load(path, allow_pickle=False) as arrays:
            before = {name: arrays[name] for name in changed if name in arrays.files}
    for name in changed:
        if name not in found:
            yield f"{name}: gone"
        elif name not in hashes:
            yield f"{name}: new"
        elif name not in before or digest(before[name]) != hashes[name]:
            yield f"{name}: differs (its numbers are not kept next to the baseline)"
        else:
            yield f"{name}: {describe(before[name], found[name])}"


def describe(before: np.ndarray, after: np.ndarray) -> str:
    """How two arrays differ: in shape or type, and where it begins by how much."""
    alike = before.dtype.kind == after.dtype.kind and before.ndim == after.ndim and before.shape[1:] == after.shape[1:]
    if not alike or before.ndim == 0:
        return f"was {_shape(before)}, is {_shape(after)}" if not alike else f"was {before}, is {after}"
    length = f"was {_shape(before)}, is {_shape(after)}; " if before.shape != after.shape else ""
    rows = min(len(before), len(after))
    row = next((k for k in range(rows) if before[k].tobytes() != after[k].tobytes()), None)
    if row is None:
        return length + ("the rows of both agree" if length else f"was {before.dtype}, is {after.dtype}")
    return f"{length}first in row {row} of {rows}, {_size(before[row], after[row], before)}"


def _size(before: np.ndarray, after: np.ndarray, whole: np.ndarray) -> str:
    """The largest difference in a row, also as a share of the largest number of all rows."""
    if whole.dtype.kind not in "fiu":
        return f"was {_short(before)}, is {_short(after)}"
    a, b = np.asarray(before, dtype=float), np.asarray(after, dtype=float)
    if (np.isfinite(a) != np.isfinite(b)).any():
        return f"was {_short(before)}, is {_short(after)}"
    size = float(np.abs(b - a)[np.isfinite(a)].max(initial=0.0))
    if size == 0.0:
        return "by the sign of a zero or the bits of a NaN"
    scale = float(np.abs(whole[np.isfinite(whole)]).max(initial=0.0))
    return f"by {size:.3g}" + (f", {size / scale:.1e} of the largest" if scale > 0.0 else "")


def _shape(array: np.ndarray) -> str:
    return f"{array.dtype.kind}{array.shape}"


def _short(value: np.ndarray | bytes) -> str:
    """A row in a few characters."""
    text = value.decode(errors="replace") if isinstance(value, bytes) else str(value)
    return text if len(text) <= 80 else text[:77] + "..."


def _arrays(file: Path, case: str) -> Path:
    """The file of the arrays of a case."""
    return file.with_suffix("") / f"{case}.npz"
