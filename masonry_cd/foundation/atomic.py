# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are there whole or not at all: written next to their place, then renamed, so that no kill leaves half of one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from masonry_cd.foundation import own_files


def part_of(path: Path) -> Path:
    """Where a file is written until it is whole, ``result.part.h5``: the same folder and ending, by which a format is recognised."""
    return path.with_name(f"{path.stem}.part{path.suffix}")


@contextmanager
def replacing(path: Path, listed: bool = True) -> Iterator[Path]:
    """Give the body a path to write to, and put what it wrote into place; after an error the file is as it was before.

    Args:
        path: of the file.
        listed: among those of its folder that are ours; a lock is not.

    Raises:
        InputError: a file of somebody else is there, in a folder that has a list of ours (:mod:`masonry_cd.foundation.own_files`).
    """
    if listed:
        own_files.guard(path)
    part = part_of(path)
    try:
        yield part
        if listed:
            own_files.note(path, part)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
