# SPDX-License-Identifier: GPL-3.0-or-later
"""HDF5 files opened to be read whatever a kill, a copy that broke or a bad disc has left of them.

HDF5 reads a file whose writer was killed only in its SWMR mode. In that mode it takes what does not fit its checksum for something that is
being written, waits and tries again, twice as long each time: a hundred times for each such place, which is for ever. And beyond the end
of a file it reads zeros. So it gets its bytes from here, not in that mode: the mark of the writer in the superblock is taken off, a place
that does not fit is an error at once, and so is a read beyond the end. A file that is being written is read just as well: its writer puts
what is referred to into the file before what refers to it.

Superblock: HDF5 File Format Specification 3.0, II.A; its checksum is Jenkins' lookup3.
"""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import size_of_regular

SIGNATURE = b"\x89HDF\r\n\x1a\n"
SUPERBLOCK = struct.Struct("<8s4B4QI")  # signature, version, sizes, marks; base, extension, end of file, root; checksum
WORD = 0xFFFFFFFF
READ_ERRORS = (OSError, RuntimeError, ValueError, KeyError, TypeError)  # what bytes that do not fit make h5py raise


class TruncatedFile(OSError):
    """A truncated file."""


class _Source(io.RawIOBase):
    """The bytes of a file as HDF5 asks for them.

    Args:
        path: of the file.

    Attributes:
        written: whether its writer has not closed it: it was killed, or is at work.

    Raises:
        InputError: a superblock that is damaged.
        Cut: the file is shorter than its superblock says, and no writer may have been killed while it grew.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = path.open("rb")
        self._size = os.fstat(self._file.fileno()).st_size
        self._head, self.written = self._superblock()

    def _superblock(self) -> tuple[bytes, bool]:
        """The superblock with the mark of a writer taken off and the true end of the file; and whether there was such a mark."""
        head = self._file.read(SUPERBLOCK.size)
        if len(head) < SUPERBLOCK.size or head[:8] != SIGNATURE or head[8] not in (2, 3):
            return head, False  # HDF5 itself says what it is, or is not
        signature, version, offsets, lengths, marks, base, extension, end, root, checksum = SUPERBLOCK.unpack(head)
        if checksum != lookup3(head[:-4]):
            raise InputError(self._path, "damaged: its header cannot be read")
        if not marks and end > self._size:
            raise TruncatedFile
        repaired = SUPERBLOCK.pack(signature, version, offsets, lengths, 0, base, extension, self._size, root, 0)[:-4]
        return repaired + struct.pack("<I", lookup3(repaired)), bool(marks)

    def seekable(self) -> bool:
        """Return True if there is :meth:`seek`."""
        return True

    def readable(self) -> bool:
        """Return True if there is :meth:`readinto`."""
        return True

    def seek(self, place: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place; the end of the file is where it was when it was opened."""
        return self._file.seek(place + self._size if whence == os.SEEK_END else place, whence % os.SEEK_END)

    def tell(self) -> int:
        """Where the next read begins."""
        return self._file.tell()

    def readinto(self, buffer: memoryview) -> int:  # type: ignore[override]
        """Fill a buffer.

        Raises:
            Cut: the file ends before the buffer is full.
        """
        place, wanted = self._file.tell(), len(buffer)
        if place + wanted > self._size or self._file.readinto(buffer) != wanted:
            raise TruncatedFile(f"{self._path}: is truncated")
        if place < len(self._head):
            known = self._head[place : place + wanted]
            buffer[: len(known)] = known
        return wanted

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()


def open_to_read(path: Path) -> tuple[h5py.File, bool]:
    """Open an HDF5 file; whether its writer has not closed it comes with it.

    Raises:
        InputError: no HDF5 file, one that is cut off, or damaged so that it does not open.
    """
    try:
        if not size_of_regular(path):
            raise EOFError
        source = _Source(path)
        return h5py.File(source, "r"), source.written
    except TruncatedFile:
        raise InputError(path, "truncated: parts of the file are missing, perhaps because a copy was interrupted") from None
    except IsADirectoryError:
        raise InputError(path, "is a folder, not a file") from None
    except (OSError, EOFError, RuntimeError, ValueError, KeyError) as reason:
        if isinstance(reason, InputError | PermissionError):
            raise
        raise InputError(path, "not a readable HDF5 file, or cut off before its first frame") from None


class Sink(io.FileIO):
    """A file that HDF5 writes to. HDF5 would not survive a write that fails, so it never hears of one: what no longer fits is kept in
    memory until who writes asks :meth:`check`, which has to be often.

    Args:
        path: of the file.
        name: by which it is called in a message.
    """

    def __init__(self, path: Path, name: Path) -> None:
        super().__init__(path, "w+")
        self._called, self._failure = name, ""
        self._kept: list[tuple[int, bytes]] = []  # places and bytes that could not be written

    def write(self, data: Any, /) -> int:
        """Write, or keep."""
        place, left = self.tell(), memoryview(data).cast("B")
        whole = len(left)
        try:
            while left and not self._failure:
                left = left[super().write(left) :]
        except OSError as failure:
            self._failure = failure.strerror or "no reason is known"
        if left:
            self._kept.append((place + whole - len(left), bytes(left)))
        self.seek(place + whole)
        return whole

    def readinto(self, buffer: Any, /) -> int:
        """Read what was written, or kept; zeros elsewhere."""
        place, view = self.tell(), memoryview(buffer).cast("B")
        read = super().readinto(view) or 0
        view[read:] = bytes(len(view) - read)
        for start, data in self._kept:
            first, last = max(start, place), min(start + len(data), place + len(view))
            if first < last:
                view[first - place : last - place] = data[first - start : last - start]
        self.seek(place + len(view))
        return len(view)

    def truncate(self, size: int | None = None, /) -> int:
        """Set the length, as far as that can be done."""
        try:
            return super().truncate(size)
        except OSError as failure:
            self._failure = self._failure or failure.strerror or "no reason is known"
            return size or 0

    def check(self) -> None:
        """Raise an OSError if something could not be written."""
        if self._failure:
            raise OSError(f"{self._called}: cannot be written: {self._failure}")


@contextmanager
def created(path: Path, name: Path) -> Iterator[tuple[h5py.File, Sink]]:
    """Make an HDF5 file that older readers know; ``name`` is what messages call it.

    Raises:
        OSError: it could not be written, a full disc for example.
    """
    with Sink(path, name) as sink:
        try:
            with h5py.File(sink, "w", libver=("earliest", "v110")) as file:
                yield file, sink
        except READ_ERRORS:
            sink.check()
            raise
        sink.check()


def lookup3(data: bytes) -> int:
    """Bob Jenkins' lookup3 hash of some bytes, hashlittle() with the initial value 0, as HDF5 checks its metadata."""
    a = b = c = (0xDEADBEEF + len(data)) & WORD
    while len(data) > 12:
        x, y, z = struct.unpack_from("<3I", data)
        a, b, c = _mix((a + x) & WORD, (b + y) & WORD, (c + z) & WORD)
        data = data[12:]
    if not data:
        return c
    x, y, z = struct.unpack("<3I", data.ljust(12, b"\0"))
    return _final((a + x) & WORD, (b + y) & WORD, (c + z) & WORD)


def _turned(word: int, bits: int) -> int:
    """A word of 32 bits rotated to the left."""
    return ((word << bits) | (word >> (32 - bits))) & WORD


def _mix(a: int, b: int, c: int) -> tuple[int, int, int]:
    """Three words mixed so that each bit of one changes the others, and can be undone."""
    for bits in (4, 6, 8, 16, 19, 4):
        a = ((a - c) & WORD) ^ _turned(c, bits)
        c = (c + b) & WORD
        a, b, c = b, c, a
    return a, b, c


def _final(a: int, b: int, c: int) -> int:
    """The last word, in which all three are mixed."""
    for bits in (14, 11, 25, 16, 4, 14, 24):
        c = ((c ^ b) - _turned(b, bits)) & WORD
        a, b, c = b, c, a
    return b
