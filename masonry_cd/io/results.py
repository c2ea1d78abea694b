"""The result file of a run: HDF5, written as the run goes, read by the reports and by whoever likes.

Layout (F frames, N steps, B blocks, J joints; SI units, world frame):

    /time (F,)  /position (F, B, 3)  /orientation (F, B, 4) w first  /velocity (F, B, 6) linear, angular
    /joints/{block_a, block_b, area, normal, polygon_start, polygon}          what the joints are
    /joints/{opening, sliding, rotation, contact_area, normal_force, shear_force} (F, J)
    /joints/force_point (F, J, 3)    where the force of a joint crosses its plane, NaN where it has none
    /joints/bonded (F, J)   share of the area that is bonded; only where joints are
    /joints/peak/{opening, sliding, rotation, contact_area_loss, first_opening_time} (J,)   over all steps
    /energy/* (N,) [J]   /solver/{iterations, error, seconds, contacts} (N,)   /penetration (N,) [m]
    /step_time (N,) [s]   /load_step (N,), the step of the loads that was applied
    /ties/tension (N, T) [N]   in the order of the scene's tables; absent without ties
    /shocks/{name, start, end, frame} (S,)   of a sequence: times [s], and the frame at the end of the rest after each shock
    /shocks/{opening, sliding, rotation, contact_area_loss, first_opening_time} (S, J)   the peaks of the joints up to there
    /blocks/*   the blocks as they were built: a report needs no scene
    attributes: scene (the text of the scene file), title, versions (JSON), run (a name that no other run has)

The file is in HDF5's single-writer mode (SWMR), so it stays readable while it grows and after a kill at any moment. It is made as
result.part.h5 and takes its name only when it is in that mode, with all its datasets. Memory does not grow with the run: frames and
steps wait in small buffers only.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import shutil
import uuid
from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from types import TracebackType

import h5py
import numpy as np

from masonry_cd.atomic import part_of
from masonry_cd.dynamics.pauses import Aftermath
from masonry_cd.errors import InputError
from masonry_cd.model.blocks import Assembly, Block
from masonry_cd.model.joints import Joints

FRAME_FIELDS = ("time", "position", "orientation", "velocity")
JOINT_HISTORIES = ("opening", "sliding", "rotation", "contact_area", "normal_force", "shear_force", "force_point")
BONDED = "bonded"  # a history that only runs with cohesive joints have
JOINT_PEAKS = ("opening", "sliding", "rotation", "contact_area_loss", "first_opening_time")
BUFFER_BYTES = 1 << 20
ROOM = 1 << 22  # bytes of the disc that are left free: HDF5 must be able to close its file


class ResultWriter:
    """Writes result.h5 as the run goes. Use it as a context manager; leaving it closes the file readable.

    Rows are only buffered by :meth:`append` and :meth:`extend`; :meth:`flush` puts the file into place and makes them survive a kill.
    Every dataset has to be named before the first flush.
    """

    def __init__(self, path: Path, assembly: Assembly, joints: Joints, scene: str = "", title: str = "") -> None:
        self._begin(Path(path))
        self._file.attrs.update(scene=scene, title=title, versions=json.dumps(versions()), run=uuid.uuid4().hex)
        _write_blocks(self._file.create_group("blocks"), assembly.blocks)
        group = self._file.create_group("joints")
        for name in Joints.__dataclass_fields__:
            group[name] = getattr(joints, name)
        for name in JOINT_PEAKS:
            group.create_dataset(f"peak/{name}", data=np.full(joints.count, np.nan))

    @classmethod
    def resumed(cls, path: Path, rows: Mapping[str, int], mark: str | None = None) -> ResultWriter:
        """Go on with the file of a run that was stopped or killed, cut back to the given number of rows of each dataset.

        The rows are copied into a new file, since a killed writer leaves its file marked as in use; it takes the place of the old one when
        it is whole and in SWMR mode.

        Args:
            path: of the file.
            rows: by dataset, as :meth:`rows` gave them.
            mark: of the rows, as :meth:`mark` gave it; None does not compare.

        Raises:
            InputError: no result file, one with fewer rows than the checkpoint counts, or with others than those of the mark.
        """
        with Results.open(path) as old:
            for name, count in rows.items():
                if name not in old.file or len(old.file[name]) < count:
                    raise InputError(f"{path}: holds less than its checkpoint says: it cannot be resumed")
            if mark is not None and _mark(old.file, rows) != mark:
                raise InputError(f"{path}: the checkpoint beside it belongs to other results: it cannot be resumed")
            new = cls.__new__(cls)
            new._begin(path)
            try:
                new._copy(old.file, rows)
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
        self._known: set[str] = set()  # datasets that are there: asking HDF5 for each row would cost as much as a small step

    def _copy(self, old: h5py.File, rows: Mapping[str, int]) -> None:
        """Copy a result file, the first rows of what grows."""
        self._file.attrs.update(old.attrs)
        for name in ("blocks", "joints/peak", *(f"joints/{name}" for name in Joints.__dataclass_fields__)):
            old.copy(name, self._file.require_group(str(Path(name).parent)))
        for name, count in rows.items():
            _copy_rows(old[name], self._file, name, count)
        self._known.update(rows)

    def _publish(self) -> None:
        """Make the file readable while it is written, and only then give it its name."""
        if not self._published:
            if not self._file.swmr_mode:
                self._file.swmr_mode = True  # no dataset may be created from here on
            self._file.flush()
            part_of(self.path).replace(self.path)
            self._published = True

    def _discard(self) -> None:
        """Close the file and take away what never got its name."""
        self._file.close()
        part_of(self.path).unlink(missing_ok=True)

    def rows(self) -> dict[str, int]:
        """Rows written so far of each dataset that grows."""
        return {name: len(self._file[name]) for name in sorted(self._known)}

    def mark(self) -> str:
        """What tells the rows written so far from those of any other run: a digest of its name and the last row of each dataset."""
        return _mark(self._file, self.rows())

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
            if name not in self._known:
                self._create(name, array)
            if len(array):
                self._pending.setdefault(name, []).append(np.array(array))
                self._pending_bytes += array.nbytes
        if self._pending_bytes > BUFFER_BYTES:
            self._write()

    def _create(self, name: str, array: np.ndarray) -> None:
        _growing(self._file, name, array.shape[1:], array.dtype)
        self._known.add(name)

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
            raise OSError(f"{self.path}: no room on the disc ({free / 1e6:.2g} MB left); the results before are kept")
        for name, parts in self._pending.items():
            dataset, rows = self._file[name], np.concatenate(parts)
            there = len(dataset)
            dataset.resize(there + len(rows), axis=0)
            dataset[there:] = rows
            dataset.flush()
        self._pending.clear()
        self._pending_bytes = 0

    def write_peaks(self, peaks: Mapping[str, np.ndarray]) -> None:
        """Write the largest joint measures so far, (J,) each."""
        for name, values in peaks.items():
            self._file[f"joints/peak/{name}"][...] = values
            self._file[f"joints/peak/{name}"].flush()

    def close(self) -> None:
        """Write what is left and close the file; one that never got a row goes."""
        if self._file:
            try:
                if self._known:
                    self.flush()
            finally:
                self._file.close()
                part_of(self.path).unlink(missing_ok=True)


class Results:
    """A result file, read lazily. Use ``Results.open(path)`` or the class as a context manager."""

    def __init__(self, file: h5py.File) -> None:
        self.file = file

    @classmethod
    def open(cls, path: Path) -> Results:
        """Open a result file, also one whose run was killed.

        Raises:
            InputError: no such file, no HDF5 file, or no result of a run.
        """
        if not Path(path).exists():
            raise InputError(f"{path}: no such result file")
        try:
            file = h5py.File(path, "r")
        except OSError as failure:
            if "truncated file" in str(failure):  # HDF5 would retry for hours to read what is not there as if it were being written
                raise InputError(f"{path}: cut off: parts of the file are missing, as after a copy that broke") from None
            file = _open_unfinished(path)
        if "time" not in file or "joints" not in file:
            raise InputError(f"{path}: not the result of a run, or one that ended before its first frame")
        return cls(file)

    def __enter__(self) -> Results:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()

    @cached_property
    def frames(self) -> int:
        """Number of frames, when first asked for, whose positions, orientations and joints are all written."""
        names = [*FRAME_FIELDS, *(f"joints/{name}" for name in JOINT_HISTORIES)]
        return min(len(self.file[name]) for name in names if name in self.file)

    @cached_property
    def time(self) -> np.ndarray:
        """(F,) [s]."""
        return self.file["time"][: self.frames]

    @property
    def position(self) -> h5py.Dataset:
        """(F, B, 3) [m], read on indexing."""
        return self.file["position"]

    @property
    def orientation(self) -> h5py.Dataset:
        """(F, B, 4), read on indexing."""
        return self.file["orientation"]

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The blocks as they were built."""
        return tuple(_read_blocks(self.file["blocks"]))

    @cached_property
    def joints(self) -> Joints:
        """The joints at rest."""
        return Joints(**{name: self.file["joints"][name][...] for name in Joints.__dataclass_fields__})

    def joint_history(self, name: str) -> np.ndarray:
        """(F, J) history of opening, sliding, rotation, contact_area, normal_force, shear_force, and bonded where joints are; (F, J, 3) of
        force_point."""
        return self.file[f"joints/{name}"][: self.frames]

    @property
    def peaks(self) -> dict[str, np.ndarray]:
        """Largest joint measures over all steps, (J,) each; NaN where a run was killed before its first flush."""
        return {name: self.file[f"joints/peak/{name}"][...] for name in JOINT_PEAKS}

    @cached_property
    def shocks(self) -> tuple[Aftermath, ...]:
        """The shocks of a sequence whose rests are over; none for any other run."""
        group = self.file.get("shocks", {})
        if "frame" not in group:
            return ()
        columns = (group[name][: len(group["frame"])] for name in ("name", "start", "end", "frame"))
        return tuple(Aftermath(n.decode(), float(a), float(b), int(f)) for n, a, b, f in zip(*columns, strict=True))

    def peaks_after(self, shock: int) -> dict[str, np.ndarray]:
        """Largest joint measures up to the end of the rest after a shock, (J,) each."""
        return {name: self.file[f"shocks/{name}"][shock] for name in JOINT_PEAKS}

    def per_step(self, name: str) -> np.ndarray:
        """(N,) a value per step, e.g. ``solver/error``, ``energy/kinetic``, ``penetration``."""
        return self.file[name][...]

    @property
    def title(self) -> str:
        """The title of the case."""
        return str(self.file.attrs["title"])

    @property
    def scene(self) -> str:
        """The text of the scene file that made this run."""
        return str(self.file.attrs["scene"])


def _growing(file: h5py.File, name: str, row: tuple[int, ...], dtype: np.dtype) -> h5py.Dataset:
    """A dataset that grows along its first axis, in chunks of about 64 kB. Its rows may be empty, those of a scene without joints are."""
    row_bytes = max(1, int(np.prod(row)) * dtype.itemsize)
    chunk = int(np.clip(65536 // row_bytes, 1, 4096))
    chunks = (chunk, *(max(1, size) for size in row))
    return file.create_dataset(name, shape=(0, *row), maxshape=(None, *(size or None for size in row)), chunks=chunks, dtype=dtype)


def _copy_rows(old: h5py.Dataset, file: h5py.File, name: str, count: int) -> None:
    """Copy the first rows of a growing dataset into another file, some megabytes at a time."""
    new = _growing(file, name, old.shape[1:], old.dtype)
    new.resize(count, axis=0)
    block = max(1, (8 << 20) // max(1, int(np.prod(old.shape[1:])) * old.dtype.itemsize))
    for first in range(0, count, block):
        new[first : first + block] = old[first : min(first + block, count)]


def _mark(file: h5py.File, rows: Mapping[str, int]) -> str:
    """A digest of the run's name and of the last of some number of rows of each dataset."""
    digest = hashlib.sha256(str(file.attrs.get("run", "")).encode())
    for name, count in sorted(rows.items()):
        digest.update(f"{name} {count} ".encode())
        if count:
            digest.update(file[name][count - 1 : count].tobytes())
    return digest.hexdigest()


def versions() -> dict[str, str]:
    """Versions of this program and of what decides its numbers."""
    out = {"python": platform.python_version()}
    for name in ("masonry-cd", "numpy", "scipy", "numba", "h5py", "cvxopt"):
        with contextlib.suppress(Exception):
            out[name] = version(name)
    return out


def _open_unfinished(path: Path) -> h5py.File:
    """Open a file whose writer was killed: SWMR readers ignore the mark that it left."""
    try:
        return h5py.File(path, "r", libver="latest", swmr=True)
    except OSError:
        raise InputError(f"{path}: not a readable HDF5 file, or cut off before its first frame") from None


def _write_blocks(group: h5py.Group, blocks: tuple[Block, ...]) -> None:
    """Write the blocks in flat arrays."""
    text = h5py.string_dtype()
    group.create_dataset("name", data=[b.name for b in blocks], dtype=text)
    group.create_dataset("group", data=[b.group for b in blocks], dtype=text)
    group["fixed"] = np.array([b.fixed for b in blocks])
    group["density"] = np.array([b.density for b in blocks])
    group["vertex_start"] = np.cumsum([0, *(len(b.vertices) for b in blocks)])
    group["vertices"] = np.concatenate([b.vertices for b in blocks])
    group["face_start"] = np.cumsum([0, *(len(b.faces) for b in blocks)])
    group["loop_start"] = np.cumsum([0, *(len(face) for b in blocks for face in b.faces)])
    group["loops"] = np.array([i for b in blocks for face in b.faces for i in face])


def _read_blocks(group: h5py.Group) -> Iterator[Block]:
    """Read back what :func:`_write_blocks` wrote."""
    names, groups = group["name"].asstr()[...], group["group"].asstr()[...]
    arrays = {name: group[name][...] for name in ("fixed", "density", "vertex_start", "vertices", "face_start", "loop_start", "loops")}
    for i, name in enumerate(names):
        vertices = arrays["vertices"][arrays["vertex_start"][i] : arrays["vertex_start"][i + 1]]
        loops = range(arrays["face_start"][i], arrays["face_start"][i + 1])
        faces = tuple(tuple(arrays["loops"][arrays["loop_start"][f] : arrays["loop_start"][f + 1]].tolist()) for f in loops)
        yield Block(name, vertices, faces, float(arrays["density"][i]), groups[i], bool(arrays["fixed"][i]))
