# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing the result file of a run: HDF5, appended to as the run goes. What it holds is in layout.py.

The file is in HDF5's single-writer mode (SWMR), so it stays readable while it grows and after a kill at any moment. It is made as
result.part.h5 and takes its name only when it is in that mode, with all its datasets. Memory does not grow with the run: frames and
steps wait in small buffers only. Checksums go with all that is written, see segments.py.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import shutil
import uuid
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from types import TracebackType

import h5py
import numpy as np

from masonry_cd import __version__
from masonry_cd.foundation import processor, system
from masonry_cd.foundation.atomic import part_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.json_files import as_json
from masonry_cd.io import tie_bars
from masonry_cd.io.block_arrays import Meshes, write_blocks
from masonry_cd.io.gauges import ATTRIBUTE as GAUGES
from masonry_cd.io.gauges import Gauges
from masonry_cd.io.layout import BY_NAME, CLOSING, CONSTANTS, FORMAT, JOINT_CONSTANTS, JOINT_PEAKS
from masonry_cd.io.results import Results
from masonry_cd.io.segments import Sealer, append, checksum_of_constants, growing, in_pieces
from masonry_cd.io.summary import Summary
from masonry_cd.io.tie_bars import ATTRIBUTE as TIES
from masonry_cd.io.tie_bars import TieBar
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import Fill
from masonry_cd.mechanics.model.joints import Joints

BUFFER_BYTES = 1 << 20
ROOM = 1 << 22  # bytes of the disc that are left free: HDF5 must be able to close its file


class ResultWriter:
    """Writes result.h5 as the run goes. Use it as a context manager; leaving it closes the file readable.

    Rows are only buffered by :meth:`append` and :meth:`extend`; :meth:`flush` puts the file into place and makes them survive a kill.
    Every dataset has to be named before the first flush.
    """

    def __init__(
        self,
        path: Path,
        assembly: Assembly,
        joints: Joints,
        scene: str = "",
        title: str = "",
        inputs: Mapping[str, str] | None = None,
        scene_file: str = "",
        ties: Sequence[TieBar] = (),
        gauges: Gauges | None = None,
        fills: Sequence[Fill] = (),
    ) -> None:
        self._begin(Path(path))
        about = {"versions": json.dumps(versions()), "inputs": json.dumps(dict(inputs or {})), "run": uuid.uuid4().hex}
        self._file.attrs.update(scene=scene, title=title, scene_file=scene_file, format=FORMAT, **about)
        if ties:
            self._file.attrs[TIES] = tie_bars.as_text(ties)
        if gauges is not None and gauges.any:
            self._file.attrs[GAUGES] = gauges.as_text()
        write_blocks(self._file.create_group("blocks"), assembly.blocks, fills)
        group = self._file.create_group("joints")
        for name in JOINT_CONSTANTS:
            group[name] = getattr(joints, name)
        for name in JOINT_PEAKS:
            group.create_dataset(f"peak/{name}", data=np.full(joints.count, np.nan))

    def begin_step_peaks(self, peaks: Mapping[str, np.ndarray], support: int) -> None:
        """Make room for the largest drifts, displacements and hinges, before the first flush; a resumed file has it.

        Args:
            peaks: by the names of STEP_PEAKS; only their shapes count.
            support: to which displacements are relative, -1 without one.
        """
        if "peaks" not in self._file:
            self._file["blocks/support"] = np.array([support], dtype=np.int64)
            for name, values in peaks.items():
                self._file.create_dataset(f"peaks/{name}", data=np.full(values.shape, np.nan))

    def begin_meshes(self, meshes: Meshes) -> None:
        """Write the meshes of blocks whose elements' stress is kept, before the first flush; a resumed file has them."""
        if "meshes/block" not in self._file:
            meshes.write(self._file)

    @classmethod
    def resumed(cls, path: Path, rows: Mapping[str, int], mark: str | None = None, sums: bool = True) -> ResultWriter:
        """Continue the file of a run that was stopped or killed, cut back to the given number of rows of each dataset.

        The rows are copied into a new file, since a killed writer leaves its file marked as in use; it takes the place of the old one when
        it is whole and in SWMR mode.

        Args:
            path: of the file.
            rows: by dataset, as :meth:`rows` gave them.
            mark: of the rows, as :meth:`mark` gave it; None does not compare.
            sums: see :meth:`Results.open`.

        Raises:
            InputError: no result file, one with fewer rows than the checkpoint counts, or with others than those of the mark.
        """
        with Results.open(path, sums) as old:
            segments = require_rows(old, rows, mark)
            new = cls.__new__(cls)
            new._begin(path)
            try:
                new._copy(old, rows, segments)
                new._publish()
            except BaseException:
                new._discard()
                raise
        return new

    def _begin(self, path: Path) -> None:
        """Open the file under the name that it has until it can be read."""
        self.path = path
        self._file = h5py.File(part_of(path), "w", libver="latest")
        self._pending: dict[str, list[np.ndarray]] = {}
        self._pending_bytes = 0
        self._published = False
        self._sealer = Sealer()
        self._growing: dict[str, h5py.Dataset] = {}  # by name: to ask HDF5 for them would cost as much as a small step

    def _copy(self, results: Results, rows: Mapping[str, int], segments: int) -> None:
        """Copy a result file, the first rows of what grows and their segments."""
        old = results.file
        self._file.attrs.update(old.attrs)
        for name in ("blocks", "joints/peak", *(f"joints/{name}" for name in JOINT_CONSTANTS)):
            old.copy(name, self._file.require_group(str(Path(name).parent)))
        if "peaks" in old:
            old.copy("peaks", self._file)
        for name in (name for name in CONSTANTS if name.startswith("meshes/") and name in old):
            old.copy(name, self._file.require_group("meshes"))
        for name, values in _named(results.peaks, results.step_peaks).items():
            self._file[name][...] = values  # not those that a kill has left half written
        for name, count in rows.items():
            self._growing[name] = growing(self._file, name, old[name].shape[1:], old[name].dtype)
            for piece in in_pieces(old[name], 0, count):
                append(self._growing[name], piece)
        self._sealer.begin(self._file, self._growing)
        self._sealer.carry_over(old, segments)

    def _publish(self) -> None:
        """Make the file readable while it is written, and only then give it its name."""
        if not self._published:
            if "segments" not in self._file:
                self._file.attrs["constant"] = checksum_of_constants(self._file)
                self._sealer.begin(self._file, self._growing)
            if not system.RENAMES_OPEN_FILES:
                self._rename_closed()
            _close_attributes(self._file)
            self._file.swmr_mode = True  # no dataset may be created from here on
            self._sealer.seal()
            self._file.flush()
            if system.RENAMES_OPEN_FILES:
                part_of(self.path).replace(self.path)
            self._published = True

    def _rename_closed(self) -> None:
        """Give the file its name while it is closed: for an instant a reader, or a kill, finds a file that is open and cannot be read."""
        self._file.close()
        part_of(self.path).replace(self.path)
        self._file = h5py.File(self.path, "r+", libver="latest")
        self._growing = {name: self._file[name] for name in self._growing}
        self._sealer.move_to(self._file)

    def _discard(self) -> None:
        """Close the file and take away what never got its name."""
        self._file.close()
        part_of(self.path).unlink(missing_ok=True)

    def rows(self) -> dict[str, int]:
        """Rows written so far of each dataset that grows."""
        return {name: len(dataset) for name, dataset in sorted(self._growing.items())}

    def mark(self) -> str:
        """Return a mark of the rows written so far that no other run has: a digest of its name and the last row of each dataset."""
        return _mark(self._file, self._growing, self.rows())

    def __enter__(self) -> ResultWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if error is None:
            self.close()
            return
        with contextlib.suppress(Exception):  # one that follows from the error must not hide it
            self.close()

    def append(self, rows: Mapping[str, np.ndarray | float]) -> None:
        """Append one row to each named dataset, e.g. ``{"time": 0.1, "position": (B, 3)}``."""
        self._extend({name: np.asarray(row)[None] for name, row in rows.items()})

    def extend(self, rows: Mapping[str, np.ndarray]) -> None:
        """Append many rows, the first axis of each array, to each named dataset; no rows make the dataset alone."""
        self._extend(rows)

    def _extend(self, rows: Mapping[str, np.ndarray]) -> None:
        for name, array in rows.items():
            if name not in self._growing:
                self._create(name, array)
            if len(array):
                self._pending.setdefault(name, []).append(np.array(array))
                self._pending_bytes += array.nbytes
        if self._pending_bytes > BUFFER_BYTES:
            self._write()

    def _create(self, name: str, array: np.ndarray) -> None:
        shape = BY_NAME[name].shape if name in BY_NAME else ("N",)
        if array.ndim != len(shape):
            raise ValueError(f"{name} has rows of the shape {shape[1:]}, not {array.shape[1:]}")
        self._growing[name] = growing(self._file, name, array.shape[1:], array.dtype)

    def flush(self) -> None:
        """Write what waits in the buffers; from here on it survives a kill.

        Raises:
            OSError: no room on the disc. What was written before is kept, and stays readable.
        """
        self._write()
        self._publish()

    def sync(self) -> None:
        """Wait until what was flushed is on the disc, so that it survives a loss of power as well."""
        self._file.flush()
        os.fsync(self._file.id.get_vfd_handle())

    def _write(self) -> None:
        """Hand what waits in the buffers to HDF5."""
        if (free := shutil.disk_usage(self.path.parent).free) < self._pending_bytes + ROOM:  # HDF5 itself would not survive it
            raise OSError(f"{self.path}: the disk is full ({free / 1e6:.2g} MB left); results up to here are kept")
        for name, parts in self._pending.items():
            dataset = self._growing[name]
            rows = np.concatenate(parts).astype(dataset.dtype, copy=False)
            append(dataset, rows)
            self._sealer.take(name, rows)
        self._pending.clear()
        self._pending_bytes = 0
        if self._published:
            self._sealer.seal()

    def write_peaks(self, peaks: Mapping[str, np.ndarray], of_steps: Mapping[str, np.ndarray] | None = None) -> None:
        """Write the largest joint measures so far, (J,) each, and largest drifts, displacements and hinges by the names of STEP_PEAKS."""
        for name, values in _named(peaks, of_steps or {}).items():
            self._file[name][...] = values
            self._file[name].flush()
        if self._published:
            self._sealer.seal_peaks()

    def write_closing(self, summary: Summary) -> None:
        """Write what is known of a run that has ended, so that its summary can be written from here."""
        self.extend({CLOSING: np.frombuffer(as_json(summary.as_dict()).encode(), dtype=np.uint8)})
        self.flush()

    def close(self) -> None:
        """Write what is left and close the file; one that never got a row goes."""
        if self._file:
            try:
                if self._growing:
                    self.flush()
            finally:
                self._file.close()
                part_of(self.path).unlink(missing_ok=True)


def require_rows(results: Results, rows: Mapping[str, int], mark: str | None) -> int:
    """How many segments of a result file there are up to the rows of a checkpoint, and that these are its rows.

    Raises:
        InputError: the file has fewer rows that hold, or others than those of the mark.
    """
    segments = results.segments_up_to(rows)
    if mark is not None and _mark(results.file, results.file, rows) != mark:
        raise InputError(results.path, "the checkpoint next to it belongs to other results, so the run cannot be resumed")
    return segments


def _close_attributes(file: h5py.File) -> None:
    """Close the attributes and datatypes that are open still, with which HDF5 begins no single-writer mode.

    Python closes them as it forgets them. Where another thread looks at what this one does, as the profiler of a dask worker, it may hold
    them at this instant.
    """
    for found in h5py.h5f.get_obj_ids(file.id, h5py.h5f.OBJ_ATTR | h5py.h5f.OBJ_DATATYPE):
        while found.valid:
            h5py.h5i.dec_ref(found)


def _named(peaks: Mapping[str, np.ndarray], of_steps: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Peaks of the joints and of the steps by the names of their datasets."""
    return {f"joints/peak/{name}": values for name, values in peaks.items()} | {f"peaks/{n}": values for n, values in of_steps.items()}


def _mark(file: h5py.File, datasets: Mapping[str, h5py.Dataset], rows: Mapping[str, int]) -> str:
    """A digest of the run's name and of the last of some number of rows of each dataset."""
    digest = hashlib.sha256(str(file.attrs.get("run", "")).encode())
    for name, count in sorted(rows.items()):
        digest.update(f"{name} {count} ".encode())
        if count:
            digest.update(datasets[name][count - 1 : count].tobytes())
    return digest.hexdigest()


def versions() -> dict[str, str]:
    """Versions of this program and of what decides its numbers."""
    out = {"masonry-cd": __version__, "python": platform.python_version()}
    for name in ("numpy", "scipy", "numba", "h5py", "qdldl"):
        with contextlib.suppress(Exception):
            out[name] = version(name)
    return out | {"kernels for": processor.target()[0]}
