"""Memory that a step has freed stays with the program for the next one.

glibc gives freed memory at the top of its heap back to the system where that is more than twice the largest array freed so far that was
mapped by itself, and the system fills it with zeros when it is next asked for: a step of meshed blocks that frees 12 MB then spends a
sixth of its time on that (mallopt(3), M_TRIM_THRESHOLD). Freeing one array of the largest size that counts, 32 MB, without ever having
touched it, settles the limit at 64 MB. Larger arrays are mapped by themselves as before, in large pages where the system has them.
Elsewhere this does nothing.
"""

from __future__ import annotations

from functools import cache

import numpy as np

LARGEST = 31 * 2**20  # bytes of an array that, with its header, glibc still counts


@cache
def keep_freed_memory() -> None:
    """Have up to 64 MB of freed memory kept for what is asked for next, in this process."""
    np.empty(LARGEST, dtype=np.uint8)
