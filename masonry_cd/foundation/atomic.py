# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are there whole or not at all: written beside their place, then renamed, so that no kill leaves half of one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def part_of(path: Path) -> Path:
    """Where a file is written until it is whole, ``result.part.h5``: the same folder and ending, by which a format is recognised."""
    return path.with_name(f"{path.stem}.part{path.suffix}")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give the body a path to write to, and put what it wrote into place; after an error the file is as it was before."""
    part = part_of(path)
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
