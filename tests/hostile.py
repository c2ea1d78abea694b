# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs that are refused: by a readable line for each fault, and a small scene of a block file to try them on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_cd.foundation.errors import InputError

LONGEST = 900  # characters of a message, its folder apart: two cut values and the words around them
SCENE = """title = "a"
[structure]
kind = "file"
path = "b.json"
[material]
density = 2000.0
friction = 0.6
[run]
dt = 1e-3
duration = 0.1
"""
TETRA: dict[str, list[list[int]]] = {
    "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "faces": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
}


def refusal(folder: Path, action: Callable[[], Any], longest: int = LONGEST) -> str | None:
    """The message, without the folder, of the InputError that an action raises, of printable lines; None where it raises none."""
    try:
        with np.errstate(all="ignore"):
            action()
    except InputError as error:
        lines = [line.replace(f"{folder}/", "") for line in error.lines]
        assert lines and all(lines)
        for line in lines:
            assert line.isprintable()
            assert len(line) < longest, line
        return "\n".join(lines)
    return None


@contextmanager
def refused_at(place: str) -> Iterator[pytest.ExceptionInfo[InputError]]:
    """Expect an InputError whose first fault names a place: the path of a key, an option, the end of a file's path."""
    with pytest.raises(InputError) as caught:
        yield caught
    assert caught.value.place.endswith(place), caught.value
