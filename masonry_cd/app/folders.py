# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders into which results may be written."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError

RUN = ("result.h5", "summary.json")  # marks of a run


def names_of_run() -> tuple[str, ...]:
    """The files that a run may write or take away, as names and patterns."""
    from masonry_cd.app.dump import FILES
    from masonry_cd.io import checkpoint
    from reports.files import known_files

    saved = Path(checkpoint.NAME)
    return (*known_files(), "crack_map_*s.png", FILES, saved.name, checkpoint.before(saved).name)


def is_run(folder: Path) -> bool:
    """Return True if a folder that has no list of its files is that of a run of an earlier version: by the attributes of its result.h5."""
    from masonry_cd.io.hdf5_file import READ_ERRORS, open_to_read

    if not (folder / RUN[0]).is_file():
        return False
    try:
        file, _ = open_to_read(folder / RUN[0])
        with file:
            return {"format", "scene", "title"} <= set(file.attrs)
    except READ_ERRORS:
        return False


def free_folder(folder: Path, marks: tuple[str, ...], force: bool) -> None:
    """Refuse a folder that holds results, is none, or cannot be written, or where a file of somebody else would be overwritten.

    Args:
        folder: for results; need not be there.
        marks: files that are results.
        force: overwrite them, as far as they are ours.

    Raises:
        InputError: names the folder, the files, and the remedy.
    """
    there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    if not there.is_dir():
        raise InputError(there, "is a file; give -o a folder")
    if not os.access(there, os.W_OK) or not shutil.disk_usage(there).total:  # no disc at all: /proc and its like
        raise InputError(there, "this folder is not writable; choose another one with -o")
    if not force and any((folder / mark).exists() for mark in marks):
        raise InputError(folder, "holds results already; choose another folder with -o, or overwrite them with --force")
    if marks != RUN:  # a run looks itself, once it knows all of its outputs
        own_files.check(folder, marks)
