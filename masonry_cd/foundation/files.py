# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that a user names, looked at before they are opened.

A device, a pipe or a socket may have no end, or wait for ever for its first byte, so it is refused. Files of the kernel such as those of
/proc may do so too, and call themselves regular and empty: what says that it is empty is taken at its word and never read.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from masonry_cd.foundation.errors import InputError

MOST = 4e9  # bytes of a file that is read whole: a table of 10^8 numbers has a tenth of it
KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def size_of_regular(path: Path, called: str = "") -> int:
    """The size of a file [B], at which it may be opened without waiting.

    Args:
        path: of the file.
        called: what a message calls it; its path when left out.

    Raises:
        InputError: it is there, and is neither a file nor a folder.
        OSError: it is a folder, or not there, as opening it would raise.
    """
    try:
        found = os.stat(path)
    except ValueError:  # a name that no file can have
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path)) from None
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        kind = next((word for test, word in KINDS if test(found.st_mode)), "something else")
        raise InputError(called or path, f"is {kind}; a file is needed")
    return found.st_size


def is_file(path: Path) -> bool:
    """Return True if there is such a file.

    Raises:
        InputError: it is there, and is neither a file nor a folder.
    """
    try:
        size_of_regular(path)
    except OSError:
        return False
    return True


def read_bytes(path: Path, called: str = "") -> bytes:
    """All of a regular file, see :func:`size_of_regular`.

    Raises:
        InputError: no regular file, or one beyond ``MOST``.
        OSError: as the system says.
    """
    size = size_of_regular(path, called)
    if size > MOST:
        raise InputError(called or path, f"of {size / 1e9:.3g} GB, at most {MOST / 1e9:g} GB are read")
    if size == 0:
        return b""
    with path.open("rb") as file:
        return file.read(size)


def read_text(path: Path, called: str = "", encoding: str = "utf-8") -> str:
    """The text of a regular file, see :func:`read_bytes`; its lines end in a line feed, however they were written.

    Raises:
        UnicodeDecodeError: no text in this encoding.
    """
    return read_bytes(path, called).decode(encoding).replace("\r\n", "\n").replace("\r", "\n")
