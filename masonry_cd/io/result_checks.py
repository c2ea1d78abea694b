# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of a result file against layout.py: names, types, shapes, and indices that lie within what they point into.

Readers go on to compiled kernels and to VTK, which check nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.hdf5_file import READ_ERRORS
from masonry_cd.io.layout import (
    BY_NAME,
    CONSTANTS,
    DATASETS,
    JOINT_PEAKS,
    KINDS,
    REAL,
    STEP_PEAKS,
    WHOLE,
    Dataset,
)
from masonry_cd.io.segments import GROUP, held, in_pieces

Sizes = dict[str, int]  # of dimensions that are known, by their names


def check_constants(file: h5py.File, path: Path) -> Sizes:
    """Check what does not grow: the blocks, the joints and their peaks. The sizes of dimensions that follow from it come back.

    Raises:
        InputError: it is missing, or not what it should be.
    """
    needed = ("time", *(name for name in CONSTANTS if not BY_NAME[name].when))
    if missing := next((name for name in needed if name not in file), ""):
        raise InputError(path, f"not the result of a run, or of a run that ended before its first frame (it has no {missing})")
    sizes: Sizes = {}
    found = {name: _read(file, path, BY_NAME[name], sizes) for name in CONSTANTS if name in file or name in needed}
    found |= {f"joints/peak/{name}": _read(file, path, BY_NAME[f"joints/peak/{name}"], sizes) for name in JOINT_PEAKS}
    blocks, fixed = sizes["B"], found["blocks/fixed"]
    _check_lists(path, found, (("blocks/vertex_start", "corners"), ("blocks/face_start", "faces"), ("blocks/loop_start", "entries")), sizes)
    of_face = np.repeat(np.arange(blocks), np.diff(found["blocks/face_start"]))
    of_loop = np.repeat(of_face, np.diff(found["blocks/loop_start"]))
    _check_indices(path, "blocks/loops", found["blocks/loops"], np.diff(found["blocks/vertex_start"])[of_loop])
    for name in ("joints/block_a", "joints/block_b"):
        _check_indices(path, name, found[name], blocks)
    _check_lists(path, found, (("joints/polygon_start", "points"),), sizes)
    if "blocks/fill_block" in found:
        _check_fill(file, path, found, sizes)
    if "blocks/radius" in found:
        _check_radii(path, found["blocks/radius"], found["blocks/vertex_start"])
    if "blocks/support" in found:
        _check_support(path, found["blocks/support"], fixed)
    if "meshes" in file:
        _check_meshes(file, path, found, sizes)
    if "peaks" in file or "segments/step_peaks" in file:
        _check_step_peaks(file, path, sizes)
    return sizes | {"S": int(np.count_nonzero(fixed))}


def _check_fill(file: h5py.File, path: Path, found: Mapping[str, np.ndarray], sizes: Sizes) -> None:
    """Check the faces on which fill lies."""
    for name in (one.name for one in DATASETS if one.name.startswith("blocks/fill_")):
        if name not in file:
            raise InputError(path, f"damaged: {name} is missing")
    _check_indices(path, "blocks/fill_block", found["blocks/fill_block"], sizes["B"])
    _check_lists(path, found, (("blocks/fill_start", "fill corners"),), sizes)
    numbers = np.concatenate([found["blocks/fill_level"], found["blocks/fill_corners"].ravel()])
    if not np.isfinite(numbers).all() or (np.diff(found["blocks/fill_start"]) < 3).any():
        raise InputError(path, "blocks/fill_corners do not belong to faces")


def _check_radii(path: Path, radii: np.ndarray, vertex_start: np.ndarray) -> None:
    """Check the radii of spheres, 0 of polyhedra; a sphere has one vertex, its centre."""
    if not ((radii >= 0.0) & (radii < np.inf)).all() or (np.diff(vertex_start)[radii > 0.0] != 1).any():
        raise InputError(path, "blocks/radius does not match the spheres")


def _check_support(path: Path, support: np.ndarray, fixed: np.ndarray) -> None:
    """Check the number of the support to which displacements are relative, -1 for none."""
    if not -1 <= support[0] < len(fixed) or (support[0] >= 0 and not fixed[support[0]]):
        raise InputError(path, "blocks/support is not a support")


def _check_meshes(file: h5py.File, path: Path, found: Mapping[str, np.ndarray], sizes: Sizes) -> None:
    """Check the meshes of blocks: all of their datasets are there, and point to what there is."""
    for name in (one.name for one in DATASETS if one.name.startswith("meshes/")):
        if name not in file:
            raise InputError(path, f"damaged: {name} is missing")
    _check_indices(path, "meshes/block", found["meshes/block"], sizes["B"])
    _check_lists(path, found, (("meshes/node_start", "V"), ("meshes/element_start", "E")), sizes)
    if sizes["d"] not in (2, 3):
        raise InputError(path, f"meshes/elements should have 3 or 4 nodes each, not {sizes['d'] + 1}")
    _check_indices(path, "meshes/elements", found["meshes/elements"].ravel(), sizes["V"])


def _check_step_peaks(file: h5py.File, path: Path, sizes: Sizes) -> None:
    """Check the largest drifts, displacements and hinges."""
    for name in STEP_PEAKS:
        _read(file, path, BY_NAME[f"peaks/{name}"], sizes)
    checksum = file.get("segments/step_peaks")
    if not isinstance(checksum, h5py.Dataset) or checksum.shape != (1,) or checksum.dtype.kind not in WHOLE:
        raise InputError(path, f"segments/step_peaks should have {KINDS[WHOLE]}")


def check_growing(file: h5py.File, path: Path, rows: Mapping[str, int], sizes: Sizes) -> None:
    """Check types and shapes of what grows; ``sizes`` are of dimensions that are known.

    Raises:
        InputError: a dataset that is not what it should be.
    """
    there = {name: file.get(name) for name in {*rows, *(one.name for one in DATASETS if one.grows)}}
    for one in (one for one in DATASETS if there.get(one.name) is not None and one.grows):
        dataset = there[one.name]
        if (
            not isinstance(dataset, h5py.Dataset)
            or dataset.dtype.kind not in one.kind
            or not dataset.shape
            or not _fits(one.shape[1:], dataset.shape[1:], sizes)
        ):
            raise InputError(path, f"{one.name} should have {_described(one)}")
    for name in rows:
        dataset = there[name]
        if not isinstance(dataset, h5py.Dataset):
            raise InputError(path, f"damaged: {name} is missing")
        if name not in BY_NAME and (dataset.ndim != 1 or dataset.dtype.kind not in REAL + WHOLE):
            raise InputError(path, f"{name} should have a number per step")


def rows_that_read(file: h5py.File, path: Path) -> dict[str, int]:
    """Rows of each growing dataset of a file without checksums, all of which are read once.

    Raises:
        InputError: one that does not read.
    """
    found: dict[str, int] = {}

    def visit(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset) and item.maxshape and item.maxshape[0] is None and not name.startswith(f"{GROUP}/"):
            found[name] = held(item)
            for _ in in_pieces(item, 0, found[name]):
                pass

    try:
        file.visititems(visit)
    except READ_ERRORS:
        raise InputError(path, "damaged: parts of it cannot be read") from None
    return found


def _read(file: h5py.File, path: Path, one: Dataset, sizes: Sizes) -> np.ndarray:
    """A dataset that does not grow, read; its dimensions are those that are known, or become known."""
    dataset = file.get(one.name)
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind not in one.kind or dataset.ndim < 1:
        raise InputError(path, f"{one.name} should have {_described(one)}")
    if dataset.nbytes > dataset.id.get_storage_size() or dataset.external or dataset.is_virtual:
        raise InputError(path, f"{one.name} has more entries than the file stores")
    if not _fits(one.shape, dataset.shape, sizes):
        raise InputError(path, f"{one.name} should have the shape {_shape_in_words(one, sizes)}, not {dataset.shape}")
    return np.asarray(dataset[...])


def _fits(shape: tuple[str | int, ...], found: tuple[int, ...], sizes: Sizes) -> bool:
    """Return True if a shape is that of a dataset; the size of a dimension that is not known yet becomes known."""
    if len(shape) != len(found):
        return False
    for dimension, size in zip(shape, found, strict=True):
        if isinstance(dimension, int):
            if size != dimension:
                return False
        else:
            own = size - dimension.endswith("+1")
            if own < 0 or sizes.setdefault(dimension.removesuffix("+1"), own) != own:
                return False
    return True


def _shape_in_words(one: Dataset, sizes: Sizes) -> str:
    """The shape that a dataset should have, sizes that are known as numbers."""
    known = {name: str(size) for name, size in sizes.items()} | {f"{name}+1": str(size + 1) for name, size in sizes.items()}
    return " x ".join(known.get(str(dimension), str(dimension)) for dimension in one.shape)


def _check_lists(path: Path, found: Mapping[str, np.ndarray], lists: tuple[tuple[str, str], ...], sizes: Sizes) -> None:
    """Check where lists begin in what has a size of some name, and that the last of them ends with it."""
    for name, end in lists:
        starts = found[name]
        if starts[0] != 0 or starts[-1] != sizes[end] or (np.diff(starts.astype(np.int64)) < 0).any():
            raise InputError(path, f"{name} does not partition its {sizes[end]} entries")


def _check_indices(path: Path, name: str, indices: np.ndarray, count: int | np.ndarray) -> None:
    """Check indices into something of a given number of entries."""
    if (indices < 0).any() or (indices >= count).any():
        raise InputError(path, f"{name} has indices out of range")


def _described(one: Dataset) -> str:
    """Numbers and their shape as text."""
    return f"{KINDS.get(one.kind, 'bytes')}, {' x '.join(map(str, one.shape))}"
