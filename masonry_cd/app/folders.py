# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether results may be written into a folder."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from masonry_cd.foundation.errors import InputError

RUN = ("result.h5", "summary.json")  # marks of a run


def free_folder(folder: Path, marks: tuple[str, ...], force: bool) -> None:
    """Refuse a folder that holds results, is none, or cannot be written.

    Args:
        folder: for results; need not be there.
        marks: files that are results.
        force: overwrite them.

    Raises:
        InputError: names the folder and the remedy.
    """
    there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    if not there.is_dir():
        raise InputError(there, "is a file; -o names a folder")
    if not os.access(there, os.W_OK) or not shutil.disk_usage(there).total:  # no disc at all: /proc and its like
        raise InputError(there, "nothing may be written there; -o names another folder")
    if not force and any((folder / mark).exists() for mark in marks):
        raise InputError(folder, "holds results already; choose another folder, or --force to overwrite them")
