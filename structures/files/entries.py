# SPDX-License-Identifier: GPL-3.0-or-later
"""A block of a mesh file as its reader gives it, and the lines of a text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text
from masonry_cd.mechanics.model.geometry import Faces

Shell = tuple[np.ndarray, Faces]


@dataclass
class Entry:
    """A block of a mesh file, in its own unit and axes."""

    name: str
    shells: list[Shell]
    group: str = ""
    fixed: bool = False
    density: float = 0.0  # [kg/m3]; 0 where the file states none


Read = tuple[list[Entry], Sequence[float], Sequence[str]]  # figures whose meaning the reader states, and lines on what was not read


def lines_of(path: Path, name: str) -> list[str]:
    """The lines of a text.

    Raises:
        InputError: not readable, or not in UTF-8.
    """
    try:
        return read_text(path, name).splitlines()
    except UnicodeDecodeError:
        raise InputError(name, "no text in UTF-8") from None
