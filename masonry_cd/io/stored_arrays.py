# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays from files of strangers: whatever is wrong with such a file ends in one line that names it.

What a file announces is checked before memory is taken for it. Links to other files and data kept in other files are refused.
"""

from __future__ import annotations

import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from masonry_cd.foundation.errors import InputError, in_a_line
from masonry_cd.foundation.files import size_of_regular

MOST = 16e9  # bytes of all arrays of a file: problems of millions of contacts
NO_ZIP = (zipfile.BadZipFile, zlib.error, SyntaxError, RecursionError, tokenize.TokenError)  # the last of the header of a member
BROKEN = (OSError, KeyError, RuntimeError, ValueError, TypeError, AttributeError, EOFError, OverflowError, MemoryError, NotImplementedError)


def npz_arrays(path: Path) -> dict[str, np.ndarray]:
    """All arrays of an .npz file.

    Raises:
        InputError: no such file, one that is damaged, or arrays of objects or beyond ``MOST``.
    """
    try:
        if not size_of_regular(path):
            raise EOFError("the file is empty")
        with zipfile.ZipFile(path) as entries:
            _check_size(path, float(sum(entry.file_size for entry in entries.infolist())))
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except InputError:
        raise
    except (*BROKEN, *NO_ZIP) as failure:
        raise InputError(path, f"not a readable .npz file ({in_a_line(failure)})") from None


@contextmanager
def open_hdf5(path: Path) -> Iterator[h5py.File]:
    """An HDF5 file for reading; what the library finds wrong with it, then or later, is reported in one line.

    Raises:
        InputError: also those of the body.
    """
    try:
        if not size_of_regular(path):
            raise EOFError("the file is empty")
        with h5py.File(path, "r") as file:
            yield file
    except InputError:
        raise
    except BROKEN as failure:
        raise InputError(path, f"not a readable HDF5 file ({in_a_line(failure)})") from None


def datasets(group: h5py.Group | h5py.Dataset | None, prefix: str = "") -> dict[str, np.ndarray]:
    """The datasets in a group by name, with a prefix; none where there is no group.

    Raises:
        InputError: data in another file, or beyond ``MOST``.
    """
    found = {}
    if isinstance(group, h5py.Group):
        path = Path(group.file.filename)
        for name in group:
            if isinstance(group.get(name, getlink=True), h5py.ExternalLink):
                raise InputError(path, f"{prefix}{name} is a link to another file")
            item = group.get(name)
            if isinstance(item, h5py.Dataset):
                if item.external:
                    raise InputError(path, f"{prefix}{name} stores its data in another file")
                _check_size(path, float(item.size or 0) * item.dtype.itemsize)
                found[prefix + name] = np.asarray(item)
    return found


def _check_size(path: Path, size: float) -> None:
    """Refuse arrays that are too large [B]."""
    if size > MOST:
        raise InputError(path, f"has arrays of {size / 1e9:.3g} GB; the limit is {MOST / 1e9:g} GB")
