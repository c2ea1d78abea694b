# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of numbers that Python hands over: one check for geometry, motions, forces and states."""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError


def numbers(given: Any, where: str, shape: tuple[int, ...] | None = None) -> np.ndarray:
    """Finite numbers in an array of its own.

    Args:
        given: whatever numpy makes an array of numbers of.
        where: for messages.
        shape: that it must have, -1 standing for any length; any when not given.

    Raises:
        InputError: anything else.
    """
    try:
        array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise InputError(where, "an array of numbers is needed") from None
    if shape is not None and (array.ndim != len(shape) or any(n >= 0 and n != m for n, m in zip(shape, array.shape, strict=True))):
        wanted = f"({', '.join('N' if n < 0 else str(n) for n in shape)}{',' if len(shape) == 1 else ''})"
        raise InputError(where, f"an array of shape {wanted} is needed, got {array.shape}")
    if not np.isfinite(array).all():
        at = f" at {np.argwhere(~np.isfinite(array))[0].tolist()}" if array.ndim else ""
        raise InputError(where, f"not finite{at}")
    return array
