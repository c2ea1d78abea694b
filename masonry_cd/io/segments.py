# SPDX-License-Identifier: GPL-3.0-or-later
"""Checksums of a result file, so that damage is found and what precedes it can still be reported.

Each time rows are handed to the file they make a segment: from the rows that each growing dataset had to those that it has now. Once the
rows are written, a row follows in each of

    /segments/names (D,)      the growing datasets
    /segments/rows (K, D)     rows of each at the end of the segment
    /segments/crc (K, D)      CRC-32 of the bytes that each got in it
    /segments/seal (K,)       CRC-32 of both rows, begun with the seal before, the first with the run and the names
    /segments/peaks (1,)      CRC-32 of /joints/peak/*, which are written over
    /segments/step_peaks (1,) CRC-32 of /peaks/*, likewise

Rows beyond the last seal do not count: a kill came between. Results hold up to the last segment before the first that does not fit. What
does not grow, with the attributes, has one SHA-256. Chunks with HDF5's own checksums would not do: a kill in the middle of writing one
again would take the good rows in it along, and a chunk of zeros passes them.
"""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise, takewhile
from typing import Any

import h5py
import numpy as np

from masonry_cd.io.hdf5_file import READ_ERRORS
from masonry_cd.io.layout import ATTRIBUTES, BY_NAME, CONSTANTS, JOINT_PEAKS, OPTIONAL_ATTRIBUTES, STEP_PEAKS

GROUP = "segments"
NAME_BYTES = 64  # of a dataset
AT_ONCE = 8 << 20  # bytes that are read together


class Sealer:
    """Writes the checksums of a file that grows. Rows may come before :meth:`begin`; they belong to the first segment."""

    def __init__(self) -> None:
        self._crc: dict[str, int] = {}  # of this segment
        self._rows: dict[str, int] = {}
        self._names: tuple[str, ...] = ()
        self._seal = 0
        self._open = False  # whether rows came since the last seal

    def begin(self, file: h5py.File, names: Iterable[str]) -> None:
        """Make the datasets; ``names`` are those that grow."""
        self._names = tuple(sorted(names))
        self._seal = _begun(file, self._names)
        self._group = file.create_group(GROUP)
        self._group["names"] = np.array([name.encode() for name in self._names], dtype=f"S{NAME_BYTES}")
        for name, dtype in (("rows", np.int64), ("crc", np.uint32)):
            growing(self._group, name, (len(self._names),), np.dtype(dtype))
        growing(self._group, "seal", (), np.dtype(np.uint32))
        for name, found in _checksums_of_peaks(file).items():
            self._group[name] = np.array([found], dtype=np.uint32)

    def move_to(self, file: h5py.File) -> None:
        """Go on in the same file, opened again."""
        self._group = file[GROUP]

    def take(self, name: str, rows: np.ndarray) -> None:
        """Count rows that a dataset gets, as it stores them."""
        self._crc[name] = zlib.crc32(np.ascontiguousarray(rows).data, self._crc.get(name, 0))
        self._rows[name] = self._rows.get(name, 0) + len(rows)
        self._open = True

    def seal(self) -> None:
        """End a segment: all of its rows are written."""
        if self._open:
            rows = np.array([[self._rows.get(name, 0) for name in self._names]], dtype=np.int64)
            crc = np.array([[self._crc.get(name, 0) for name in self._names]], dtype=np.uint32)
            self._write(rows, crc)
            self._crc, self._open = {}, False

    def carry_over(self, old: h5py.File, segments: int) -> None:
        """Take over the first segments of a file whose rows are copied."""
        rows = old[GROUP]["rows"][:segments]
        self._write(rows, old[GROUP]["crc"][:segments])
        if segments:
            self._rows = dict(zip(self._names, rows[-1].tolist(), strict=True))

    def seal_peaks(self) -> None:
        """Take in the peaks, which are written."""
        for name, found in _checksums_of_peaks(self._group.file).items():
            self._group[name][0] = found
            self._group[name].flush()

    def _write(self, rows: np.ndarray, crc: np.ndarray) -> None:
        """Append segments; the seals come last."""
        seals = []
        for row, each in zip(rows, crc, strict=True):
            self._seal = _seal_of(row, each, self._seal)
            seals.append(self._seal)
        for name, new in (("rows", rows), ("crc", crc), ("seal", np.array(seals, dtype=np.uint32))):
            append(self._group[name], new)


def growing(place: h5py.Group, name: str, row: tuple[int, ...], dtype: np.dtype) -> h5py.Dataset:
    """A dataset that grows along its first axis, in chunks of about 64 kB. Its rows may be empty, those of a scene without joints are."""
    row_bytes = max(1, int(np.prod(row)) * dtype.itemsize)
    chunk = int(np.clip(65536 // row_bytes, 1, 4096))
    chunks = (chunk, *(max(1, size) for size in row))
    return place.create_dataset(name, shape=(0, *row), maxshape=(None, *(size or None for size in row)), chunks=chunks, dtype=dtype)


def append(dataset: h5py.Dataset, rows: np.ndarray) -> None:
    """Write rows behind those of a dataset, and hand them to the file."""
    there = len(dataset)
    dataset.resize(there + len(rows), axis=0)
    dataset[there:] = rows
    dataset.flush()


def held(dataset: h5py.Dataset) -> int:
    """Rows of a dataset for which the file has bytes: one that a kill made longer, or a stranger, may announce others."""
    row_bytes = int(np.prod(dataset.shape[1:])) * dataset.dtype.itemsize
    return min(len(dataset), dataset.id.get_storage_size() // row_bytes) if row_bytes else len(dataset)


def in_pieces(dataset: h5py.Dataset, first: int, last: int) -> Iterator[np.ndarray]:
    """The rows of a dataset from ``first`` up to ``last``, some megabytes at a time; rows without columns, of no joints, count as well."""
    row_bytes = int(np.prod(dataset.shape[1:])) * dataset.dtype.itemsize
    step = max(1, AT_ONCE // row_bytes if row_bytes else last - first)
    for begin in range(first, last, step):
        yield dataset[begin : min(begin + step, last)]


# --- reading ---------------------------------------------------------------------------------------------------------------------


class Segments:
    """The segments of a file, checked as far as they fit.

    Attributes:
        rows: (K, D) of the good ones, D datasets by ``names``.
        damaged: whether others follow that do not fit.
    """

    def __init__(self, file: h5py.File, unfinished: bool, sums: bool = True) -> None:
        """Read the table, and with ``sums`` all that it covers; ``unfinished``: a kill may have come while the last seal was written."""
        group = file[GROUP]
        self.names = tuple(name.decode() for name in group["names"][...])
        count = min(held(group[name]) for name in ("rows", "crc", "seal"))
        rows, crc, seal = (group[name][:count] for name in ("rows", "crc", "seal"))
        begun, good = _begun(file, self.names), 0
        while good < count and _seal_of(rows[good], crc[good], begun) == seal[good]:
            begun, good = int(seal[good]), good + 1
        torn = unfinished and good == count - 1
        fits = (_fitting(file, name, rows[:good, k], crc[:good, k]) for k, name in enumerate(self.names if sums else ()))
        fitting = min(fits, default=good)
        self.damaged = fitting < count - torn
        self.rows = rows[:fitting]

    @property
    def last(self) -> dict[str, int]:
        """Rows of each dataset that hold."""
        return dict(zip(self.names, self.rows[-1].tolist() if len(self.rows) else [0] * len(self.names), strict=True))

    def ending_at(self, rows: Mapping[str, int]) -> int | None:
        """How many segments there are up to some rows of some datasets; None where no segment ends there."""
        columns = [self.names.index(name) for name in rows if name in self.names]
        there = np.flatnonzero((self.rows[:, columns] == [rows[self.names[c]] for c in columns]).all(axis=1))
        return int(there[-1]) + 1 if len(there) else None


def _fitting(file: h5py.File, name: str, ends: np.ndarray, crc: np.ndarray) -> int:
    """How many segments of a dataset fit, counted from the first."""
    found = 0
    try:
        for value in _checksums(file[name], ends):
            if value != crc[found]:
                break
            found += 1
    except READ_ERRORS:
        pass
    return found


def _checksums(dataset: h5py.Dataset, ends: np.ndarray) -> Iterator[int]:
    """CRC-32 of the rows of a dataset up to each of ``ends``, from the one before; they stop where the file holds no more."""
    there, found, segment = held(dataset), 0, 0
    ordered = takewhile(lambda pair: pair[0] <= pair[1] <= there, pairwise([0, *ends.tolist()]))
    wanted = [end for _, end in ordered]
    begin = 0
    for piece in in_pieces(dataset, 0, max(wanted, default=0)):
        data, stop = np.ascontiguousarray(piece), begin + len(piece)
        while segment < len(wanted) and wanted[segment] < stop:
            yield zlib.crc32(data[: wanted[segment] - begin].data, found)
            data, begin, found, segment = data[wanted[segment] - begin :], wanted[segment], 0, segment + 1
        begin, found = stop, zlib.crc32(data.data, found)
    for _ in wanted[segment:]:
        yield found
        found = 0


def checksum_of_peaks(file: h5py.File) -> int:
    """CRC-32 of the largest joint measures."""
    found = 0
    for name in JOINT_PEAKS:
        found = zlib.crc32(file[f"joints/peak/{name}"][...], found)
    return found


def checksum_of_step_peaks(file: h5py.File) -> int:
    """CRC-32 of the largest drifts, displacements and hinges."""
    found = 0
    for name in STEP_PEAKS:
        found = zlib.crc32(file[f"peaks/{name}"][...], found)
    return found


def _checksums_of_peaks(file: h5py.File) -> dict[str, int]:
    """The checksums of what is written over, by their names."""
    found = {"peaks": checksum_of_peaks(file)}
    return found | {"step_peaks": checksum_of_step_peaks(file)} if "peaks" in file else found


def checksum_of_constants(file: h5py.File) -> str:
    """SHA-256 of the attributes and of all that is written once."""
    digest = hashlib.sha256()
    for name in (*ATTRIBUTES, *(name for name in OPTIONAL_ATTRIBUTES if name in file.attrs)):
        digest.update(f"{name} {_text(file.attrs.get(name, ''))}\0".encode())
    for name in (name for name in CONSTANTS if not BY_NAME[name].when or name in file):
        array = file[name][...]
        digest.update(f"{name} {array.shape} ".encode())
        digest.update(b"\0".join(array.tolist()) if array.dtype == object else array.tobytes())
    return digest.hexdigest()


def _text(value: Any) -> str:
    """An attribute as a text."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _begun(file: h5py.File, names: Iterable[str]) -> int:
    """Return the start of the first seal: CRC-32 of the name of the run, which no other has, and of the datasets."""
    return zlib.crc32(" ".join((str(file.attrs["run"]), *names)).encode())


def _seal_of(rows: np.ndarray, crc: np.ndarray, before: int) -> int:
    """CRC-32 of a row of the table, begun with the seal before."""
    return zlib.crc32(crc.tobytes(), zlib.crc32(rows.tobytes(), before))
