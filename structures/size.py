# SPDX-License-Identifier: GPL-3.0-or-later
"""How many blocks a structure may have. Kinds estimate their number from their keys, before they make the first one.

A misplaced decimal point, as a course of 1e-9 m, would otherwise fill the memory. The scene may raise the limit: ``structure.most_blocks``.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

KEY = "most_blocks"
MOST = 100_000  # a step of 20,000 blocks takes some 0.2 s, and a block some kilobytes
# What takes time with its square, or worse: at these some ten seconds.
MOST_TOP = 1000  # points of the top of a wall
MOST_OPENINGS = 1000  # of a wall
MOST_CORNERS = 1000  # of a face of a block
MOST_BENT = 250  # of a face that is not convex, and is cut into triangles

_most: ContextVar[int] = ContextVar(KEY, default=MOST)


def most_blocks() -> int:
    """The limit that holds."""
    return _most.get()


@contextmanager
def limited(most: object) -> Iterator[None]:
    """Set the limit for what is built in the body.

    Raises:
        InputError: it is not a whole number above zero.
    """
    from masonry_cd.foundation.errors import InputError

    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        raise InputError(f"structure.{KEY}", f"should be a whole number above 0, got {most!r}")
    before = _most.set(most)
    try:
        yield
    finally:
        _most.reset(before)


def check_count(count: int, most: int, what: str) -> None:
    """Refuse more of something than are built in a while.

    Args:
        count: of it.
        most: how many are allowed.
        what: the key, or the block, and what there are too many of.

    Raises:
        InputError: names it, the number and the limit.
    """
    from masonry_cd.foundation.errors import InputError

    if count > most:
        raise InputError(what, f"{count}, at most {most} are allowed")


def check_size(estimate: float, key: str) -> None:
    """Refuse a structure of too many blocks.

    Args:
        estimate: of their number; within a factor of two or three is enough.
        key: the one that makes them many.

    Raises:
        InputError: names the key, the number and the limit.
    """
    from masonry_cd.foundation.errors import InputError

    text = beyond(estimate, most_blocks())
    if text:
        raise InputError(f"structure.{key}", text)


def beyond(estimate: float, most: int) -> str:
    """Return the message of :func:`within` where an estimate, which may be infinite or none, exceeds a limit; else an empty one."""
    return "" if estimate <= most else f"makes about {estimate:.2g} blocks, at most {most} are allowed; {KEY} = N allows more"
