"""Arrays by name, as a checkpoint keeps them: those of a part of the program under ``part/name``."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


def prefixed(prefix: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Put arrays under ``prefix/name``."""
    return {f"{prefix}/{name}": array for name, array in arrays.items()}


def part(prefix: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays under ``prefix/``, without it."""
    head = prefix + "/"
    return {name.removeprefix(head): array for name, array in arrays.items() if name.startswith(head)}
