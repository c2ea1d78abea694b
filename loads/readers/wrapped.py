# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of numbers that could be one series in reading order: which they could be, and how such a series is read.

A writer of eight values a line leaves a table whose rows are eight samples in a row. Read by columns it is every eighth. It shows, since

    |x_{k+1} - x_k|  of neighbours, the last of a line and the first of the next among them,  <  |x_{k+w} - x_k|  down the columns

(root mean squares) for what is sampled finely, while of components side by side neighbours have nothing to do with each other and the
columns are smooth. Pairs (time, value) side by side show by their times, which advance evenly in reading order, or down one pair of columns
and on in the next.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

FEWEST_ROWS = 4  # fewer show nothing
EVEN = 0.2  # of a step, as in loads.readers.tables: times written with few digits
CONTINUES = 0.95  # neighbours over columns: 1 is noise, or columns that are copies of each other
ALIKE = 3.0  # largest over smallest spread of columns, and of neighbours by their place in a line


def advances(values: np.ndarray) -> bool:
    """Return True if values (n,) advance evenly, as times do."""
    with np.errstate(over="ignore", invalid="ignore"):
        steps = np.diff(values)
        usual = float(np.median(steps)) if len(steps) else 0.0
        return len(values) >= FEWEST_ROWS and usual > 0.0 and bool((np.abs(steps - usual) <= EVEN * usual).all())


def times_of(table: np.ndarray) -> list[int]:
    """The columns of a table (n, w) that advance evenly."""
    return [c for c in range(table.shape[1]) if advances(table[:, c])]


def is_in_reading_order(table: np.ndarray) -> bool:
    """Return True if the numbers of a table (n, w) could be one series in reading order."""
    rows, width = table.shape
    if rows < FEWEST_ROWS or width < 2 or not np.isfinite(table).all():
        return False
    with np.errstate(over="ignore", invalid="ignore"):  # of numbers that no record has
        spread = table.std(axis=0)
        steps = np.diff(table.ravel())
        across = np.array([_rms(steps[place::width]) for place in range(width)])
        if spread.max() > ALIKE * spread.min() or across.max() > ALIKE * across.min():
            return False
        return bool(across.max() < CONTINUES * _rms(np.diff(table, axis=0)))


def paired(table: np.ndarray) -> np.ndarray | None:
    """The pairs (m, 2) of a table (n, w) that holds (time, value) pairs side by side as one record; None where it is none."""
    rows, width = table.shape
    if rows < 2 or width < 4 or width % 2 or not np.isfinite(table[:, ::2]).all():
        return None
    for pairs in (table.reshape(-1, 2), np.concatenate(np.split(table, width // 2, axis=1))):
        if advances(pairs[:, 0]):
            return pairs
    return None


def filled(rows: Sequence[Sequence[float]]) -> np.ndarray:
    """Rows as a table (n, w) of the width of the first; the last is left out where it is shorter."""
    whole = rows[:-1] if len(rows) > 1 and len(rows[-1]) < len(rows[0]) else rows
    return np.array(whole, dtype=float)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
