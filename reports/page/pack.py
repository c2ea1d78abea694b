# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays for the page: one stretch of bytes, deflated (RFC 1950) and written in base64 (RFC 4648).

Histories have time as their last axis. What is sent of them is the difference from one time to the next, all low bytes before all
high bytes: motions are smooth, so most high bytes are 0 or 255 and deflate well. The base64 alphabet is the one for addresses (- and _),
so that the text holds no two slashes in a row.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

KINDS = {"uint8": "u1", "uint16": "u2", "int16": "i2", "uint32": "u4", "float32": "f4"}
LEVEL = 7  # of the deflation
SAMPLE = 1 << 18  # values of a history by which its length is judged


def packed(arrays: Mapping[str, np.ndarray], histories: Mapping[str, np.ndarray]) -> tuple[list[dict[str, Any]], str]:
    """Pack arrays as they are, and histories (..., F) of int16 or uint16 as differences along their last axis.

    Returns:
        the list of what the bytes hold, in order (name, kind, shape, and whether it is a history), and the bytes as text.
    """
    contents: list[dict[str, Any]] = []
    parts: list[bytes] = []
    for name, array in [*arrays.items(), *histories.items()]:
        history = name in histories
        contents.append({"name": name, "kind": KINDS[array.dtype.name], "shape": list(array.shape), "history": history})
        parts.append(_differences(array) if history else np.ascontiguousarray(array).tobytes())
    return contents, base64.urlsafe_b64encode(zlib.compress(b"".join(parts), LEVEL)).decode("ascii")


def packed_length(arrays: Mapping[str, np.ndarray], histories: Mapping[str, np.ndarray]) -> int:
    """About how long the text of :func:`packed` will be, from every so-manieth row of long histories."""
    still = sum(len(zlib.compress(np.ascontiguousarray(array).tobytes(), 1)) for array in arrays.values())
    moving = 0.0
    for array in histories.values():
        rows = array.reshape(-1, array.shape[-1])
        some = rows[:: max(1, rows.size // SAMPLE)]
        moving += len(zlib.compress(_differences(some), LEVEL)) * len(rows) / max(1, len(some))
    return int((still + moving) * 4 / 3)


def _differences(array: np.ndarray) -> bytes:
    """Differences along the last axis modulo 2^16, low bytes first."""
    whole = np.ascontiguousarray(array).view(np.uint16)
    step = np.diff(whole, axis=-1, prepend=np.zeros((*whole.shape[:-1], 1), np.uint16))
    return (step & 0xFF).astype(np.uint8).tobytes() + (step >> 8).astype(np.uint8).tobytes()
