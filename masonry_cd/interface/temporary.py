# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders that live as long as what needs them."""

from __future__ import annotations

import os
import shutil
import tempfile
import weakref
from pathlib import Path


class TemporaryFolder:
    """A folder that is taken away with its last holder, or when Python ends."""

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="masonry_cd-"))
        weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)


def place_of(folder: str | os.PathLike[str] | None) -> tuple[Path, TemporaryFolder | None]:
    """The folder that is named, or else a temporary one with its keeper."""
    if folder is not None:
        return Path(folder), None
    keeper = TemporaryFolder()
    return keeper.path, keeper
