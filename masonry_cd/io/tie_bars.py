# SPDX-License-Identifier: GPL-3.0-or-later
"""The ties of a run in its result file: what does not change of each bar, as JSON in the attribute ``ties``, absent without ties."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import h5py
import numpy as np

from masonry_cd.foundation.errors import InputError

ATTRIBUTE = "ties"


class TieBar(NamedTuple):
    """A bar between two blocks. Bars of one name are one tie, spread over the blocks that its plates cover."""

    name: str  # empty where it was given none
    blocks: tuple[int, int]
    points: np.ndarray  # (2, 3) its ends as built [m]
    section: float  # [m2]
    limit: float  # force at which it yields, infinite where it never does [N]


def as_text(bars: Sequence[TieBar]) -> str:
    """Bars as JSON."""
    rows = [
        {
            "name": bar.name,
            "blocks": list(bar.blocks),
            "points": np.asarray(bar.points).tolist(),
            "section": bar.section,
            "limit": bar.limit if math.isfinite(bar.limit) else None,
        }
        for bar in bars
    ]
    return json.dumps(rows, allow_nan=False)


def read_bars(file: h5py.File, blocks: int) -> tuple[TieBar, ...]:
    """The bars of a result file of a given number of blocks; none where it has no ties.

    Raises:
        InputError: they are not what a run writes.
    """
    text = file.attrs.get(ATTRIBUTE)
    if text is None:
        return ()
    try:
        return tuple(_bar(row, blocks) for row in json.loads(str(text)))
    except (ValueError, TypeError, KeyError):
        raise InputError(file.filename, "damaged: its ties do not have the format of a run") from None


def _bar(row: dict[str, Any], blocks: int) -> TieBar:
    """One bar; raises ValueError, TypeError or KeyError where it is none."""
    first, second = row["blocks"]
    points, limit = np.array(row["points"], dtype=float), row["limit"]
    if points.shape != (2, 3) or not np.isfinite(points).all() or not all(isinstance(b, int) and 0 <= b < blocks for b in (first, second)):
        raise ValueError("no bar")
    return TieBar(str(row["name"]), (first, second), points, float(row["section"]), math.inf if limit is None else float(limit))
