# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a result file holds what layout.py says: names, types, shapes, and indices that lie within what they point into.

Readers go on to compiled kernels and to VTK, which check nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import h5py
import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.hdf5_file import READ_ERRORS
from masonry_cd.io.layout import (
    BLOCK_ARRAYS,
    CLOSING,
    EDGE_STRESS,
    ELEMENT_STRESS,
    FORCE,
    FRAME_FIELDS,
    GRADIENT,
    JOINT_CONSTANTS,
    JOINT_HISTORIES,
    JOINT_PEAKS,
    LAW_HISTORIES,
    MEAN_NORMAL_FORCE,
    MESH_ARRAYS,
    NODE_DISPLACEMENT,
    REACTION,
    STEP_PEAKS,
    STRESS,
)
from masonry_cd.io.segments import held, in_pieces

REAL, WHOLE, FLAG, TEXT, BYTES = "f", "iu", "b", "O", "S"  # kinds of numpy's types
KINDS = {REAL: "real numbers", WHOLE: "whole numbers", FLAG: "flags", TEXT: "texts", BYTES: "texts"}
BLOCKS = {"name": TEXT, "group": TEXT, "fixed": FLAG, "vertex_start": WHOLE, "face_start": WHOLE, "loop_start": WHOLE, "loops": WHOLE}
JOINTS = {"block_a": WHOLE, "block_b": WHOLE, "polygon_start": WHOLE}
PER_STEP = ("penetration", "step_time", "load_step")


def check_constants(file: h5py.File, path: Path) -> None:
    """Check what does not grow: the blocks, the joints and their peaks.

    Raises:
        InputError: it is missing, or not what it should be.
    """
    for name in ("time", *(f"blocks/{name}" for name in BLOCK_ARRAYS), *(f"joints/{name}" for name in JOINT_CONSTANTS)):
        if name not in file:
            raise InputError(path, f"not the result of a run, or one that ended before its first frame (it has no {name})")
    blocks = {name: _read(file, path, f"blocks/{name}", BLOCKS.get(name, REAL)) for name in BLOCK_ARRAYS}
    joints = {name: _read(file, path, f"joints/{name}", JOINTS.get(name, REAL)) for name in JOINT_CONSTANTS}
    count, pairs = len(blocks["name"]), len(joints["area"])
    if "blocks/structure" in file:
        _shape(path, "blocks/structure", _read(file, path, "blocks/structure", TEXT), (count,))
    if "blocks/radius" in file:
        _check_radii(path, _read(file, path, "blocks/radius", REAL), blocks["vertex_start"], count)
    corners, faces = len(blocks["vertices"]), len(blocks["loop_start"]) - 1
    for name in ("group", "fixed", "density"):
        _shape(path, f"blocks/{name}", blocks[name], (count,))
    _shape(path, "blocks/vertices", blocks["vertices"], (corners, 3))
    _starts(path, "blocks/vertex_start", blocks["vertex_start"], count, corners)
    _starts(path, "blocks/face_start", blocks["face_start"], count, faces)
    _starts(path, "blocks/loop_start", blocks["loop_start"], faces, len(blocks["loops"]))
    of_face = np.repeat(np.arange(count), np.diff(blocks["face_start"]))
    of_loop = np.repeat(of_face, np.diff(blocks["loop_start"]))
    _indices(path, "blocks/loops", blocks["loops"], np.diff(blocks["vertex_start"])[of_loop])
    for name in ("block_a", "block_b"):
        _shape(path, f"joints/{name}", joints[name], (pairs,))
        _indices(path, f"joints/{name}", joints[name], count)
    _shape(path, "joints/normal", joints["normal"], (pairs, 3))
    _shape(path, "joints/polygon", joints["polygon"], (len(joints["polygon"]), 3))
    _starts(path, "joints/polygon_start", joints["polygon_start"], pairs, len(joints["polygon"]))
    for name in JOINT_PEAKS:
        _shape(path, f"joints/peak/{name}", _read(file, path, f"joints/peak/{name}", REAL), (pairs,))
    if "blocks/support" in file:
        _check_support(path, _read(file, path, "blocks/support", WHOLE), blocks["fixed"])
    if "meshes" in file:
        _check_meshes(file, path, count)
    if "peaks" in file or "segments/step_peaks" in file:
        _check_step_peaks(file, path, count, pairs)


def _check_radii(path: Path, radii: np.ndarray, vertex_start: np.ndarray, blocks: int) -> None:
    """Check the radii of spheres, 0 of polyhedra; a sphere has one vertex, its centre."""
    _shape(path, "blocks/radius", radii, (blocks,))
    _shape(path, "blocks/vertex_start", vertex_start, (blocks + 1,))
    if not ((radii >= 0.0) & (radii < np.inf)).all() or (np.diff(vertex_start)[radii > 0.0] != 1).any():
        raise InputError(path, "blocks/radius is not that of spheres")


def _check_support(path: Path, support: np.ndarray, fixed: np.ndarray) -> None:
    """Check the number of the support to which displacements are relative, -1 for none."""
    _shape(path, "blocks/support", support, (1,))
    if not -1 <= support[0] < len(fixed) or (support[0] >= 0 and not fixed[support[0]]):
        raise InputError(path, "blocks/support is no support")


def _check_meshes(file: h5py.File, path: Path, blocks: int) -> None:
    """Check the meshes of blocks, of which there are B in all."""
    found = {name: _read(file, path, f"meshes/{name}", REAL if name == "nodes" else WHOLE) for name in MESH_ARRAYS}
    meshed, nodes, elements = len(found["block"]), len(found["nodes"]), found["elements"]
    _shape(path, "meshes/block", found["block"], (meshed,))
    _indices(path, "meshes/block", found["block"], blocks)
    _shape(path, "meshes/nodes", found["nodes"], (nodes, 3))
    _starts(path, "meshes/node_start", found["node_start"], meshed, nodes)
    _starts(path, "meshes/element_start", found["element_start"], meshed, len(elements))
    _shape(path, "meshes/elements", elements, (len(elements), 4 if elements.shape[1:] == (4,) else 3))
    _indices(path, "meshes/elements", elements.ravel(), nodes)
    for name in (NODE_DISPLACEMENT, ELEMENT_STRESS):
        if name not in file:
            raise InputError(path, f"damaged: {name} is missing")


def _check_step_peaks(file: h5py.File, path: Path, blocks: int, joints: int) -> None:
    """Check the largest drifts, displacements and hinges."""
    found = {name: _read(file, path, f"peaks/{name}", REAL) for name in STEP_PEAKS}
    parts, levels = len(found["drift"]), found["level_drift"].shape[-1]
    shapes = ((blocks,), (parts,), (parts, levels), (parts, levels), (joints,), (joints,), (joints, 3))
    for name, shape in zip(STEP_PEAKS, shapes, strict=True):
        _shape(path, f"peaks/{name}", found[name], shape)
    checksum = file.get("segments/step_peaks")
    if not isinstance(checksum, h5py.Dataset) or checksum.shape != (1,) or checksum.dtype.kind not in WHOLE:
        raise InputError(path, f"segments/step_peaks is not what a run writes ({KINDS[WHOLE]})")


def check_growing(file: h5py.File, path: Path, rows: Mapping[str, int]) -> None:
    """Check types and shapes of what grows.

    Raises:
        InputError: a dataset that is not what it should be.
    """
    blocks, joints = len(file["blocks/name"]), len(file["joints/area"])
    parts = len(file["peaks/drift"]) if "peaks" in file else 0
    meshes = (len(file["meshes/nodes"]), len(file["meshes/elements"])) if "meshes" in file else (0, 0)
    supports = int(np.count_nonzero(file["blocks/fixed"][...]))
    for name, kind, row in (*_growing(blocks, joints, parts, meshes), (REACTION, REAL, (supports, 6))):
        if name in file:
            dataset = file[name]
            if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind not in kind or dataset.shape[1:] != row:
                raise InputError(path, f"{name} is not what a run writes ({_described(kind, ('rows', *row))})")
    for name in rows:
        if not isinstance(file.get(name), h5py.Dataset):
            raise InputError(path, f"damaged: {name} is missing")
    for group in ("solver", "energy"):
        for name in file.get(group, ()):
            _scalars(file, path, f"{group}/{name}")
    for name in PER_STEP:
        if name in file:
            _scalars(file, path, name)


def rows_that_read(file: h5py.File, path: Path) -> dict[str, int]:
    """Rows of each growing dataset of a file without checksums, all of which are read once.

    Raises:
        InputError: one that does not read.
    """
    found: dict[str, int] = {}

    def visit(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset) and item.maxshape and item.maxshape[0] is None:
            found[name] = held(item)
            for _ in in_pieces(item, 0, found[name]):
                pass

    try:
        file.visititems(visit)
    except READ_ERRORS:
        raise InputError(path, "damaged: not all of it can be read") from None
    return found


def _growing(blocks: int, joints: int, parts: int, meshes: tuple[int, int]) -> Iterator[tuple[str, str, tuple[int, ...]]]:
    """Name, kinds of number and shape of a row of each dataset that grows; ``meshes`` have so many nodes and elements."""
    yield from zip(FRAME_FIELDS, (REAL,) * 4, ((), (blocks, 3), (blocks, 4), (blocks, 6)), strict=True)
    yield GRADIENT, REAL, (blocks, 3, 3)
    yield STRESS, REAL, (blocks, 6)
    yield NODE_DISPLACEMENT, REAL, (meshes[0], 3)
    yield ELEMENT_STRESS, REAL, (meshes[1], 6)
    for name in (*JOINT_HISTORIES, FORCE, *LAW_HISTORIES, MEAN_NORMAL_FORCE, EDGE_STRESS):
        yield f"joints/{name}", REAL, (joints, 3) if name in ("force_point", FORCE) else (joints,)
    yield from (("shocks/name", BYTES, ()), ("shocks/frame", WHOLE, ()), ("shocks/start", REAL, ()), ("shocks/end", REAL, ()))
    for name in JOINT_PEAKS:
        yield f"shocks/{name}", REAL, (joints,)
    yield "shocks/peaks/hinge_opening", REAL, (joints,)
    yield "shocks/peaks/drift", REAL, (parts,)
    yield CLOSING, "u", ()


def _read(file: h5py.File, path: Path, name: str, kind: str) -> np.ndarray:
    """A dataset that was written once, read."""
    dataset = file.get(name)
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype.kind not in kind or dataset.ndim < 1:
        raise InputError(path, f"{name} is not what a run writes ({KINDS[kind]})")
    if dataset.nbytes > dataset.id.get_storage_size() or dataset.external or dataset.is_virtual:
        raise InputError(path, f"{name} is larger than what the file holds of it")
    return np.asarray(dataset[...])


def _scalars(file: h5py.File, path: Path, name: str) -> None:
    """Check a number per step."""
    dataset = file[name]
    if not isinstance(dataset, h5py.Dataset) or dataset.ndim != 1 or dataset.dtype.kind not in REAL + WHOLE:
        raise InputError(path, f"{name} is not what a run writes (a number per step)")


def _shape(path: Path, name: str, array: np.ndarray, shape: tuple[int, ...]) -> None:
    """Check a shape."""
    if array.shape != shape:
        raise InputError(path, f"{name} should have the shape {shape}, not {array.shape}")


def _starts(path: Path, name: str, starts: np.ndarray, count: int, end: int) -> None:
    """Check where each of ``count`` lists begins in an array of ``end`` entries, and that the last ends with it."""
    _shape(path, name, starts, (count + 1,))
    if starts[0] != 0 or starts[-1] != end or (np.diff(starts.astype(np.int64)) < 0).any():
        raise InputError(path, f"{name} does not divide its {end} entries")


def _indices(path: Path, name: str, indices: np.ndarray, count: int | np.ndarray) -> None:
    """Check indices into something of so many entries."""
    if indices.ndim != 1 or (indices < 0).any() or (indices >= count).any():
        raise InputError(path, f"{name} points beyond what there is")


def _described(kind: str, shape: tuple[object, ...]) -> str:
    """Numbers and their shape in words."""
    return f"{KINDS.get(kind, 'bytes')}, {' x '.join(map(str, shape))}"
