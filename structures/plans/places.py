# SPDX-License-Identifier: GPL-3.0-or-later
"""Places of a plan in messages: a drawing that lies far from its origin is brought near it, but its user knows its own coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

ORIGIN: ContextVar[tuple[float, float]] = ContextVar("origin", default=(0.0, 0.0))  # of the plan of which messages speak [m]


@contextmanager
def drawn_about(origin: tuple[float, float]) -> Iterator[None]:
    """Have messages give places in the coordinates of a drawing, in which the origin of the structure is this point [m]."""
    token = ORIGIN.set(origin)
    try:
        yield
    finally:
        ORIGIN.reset(token)


def place(point: Sequence[float] | np.ndarray) -> str:
    """A point of the plan (2,) as messages give it: in the coordinates of its drawing, where it has one."""
    origin = ORIGIN.get()
    x, y = (
        f"{far + float(near):.2f}" if any(origin) else f"{round(float(near), 6) + 0.0:.4g}" for near, far in zip(point, origin, strict=True)
    )
    return f"x = {x} m, y = {y} m"
