# SPDX-License-Identifier: GPL-3.0-or-later
"""Contents of a result file, to compare runs bit by bit."""

from __future__ import annotations

from pathlib import Path

import h5py

BY_THE_CLOCK = ("segments/", "closing", "solver/seconds")


def contents(path: Path) -> dict[str, bytes]:
    """All datasets but what depends on when the run wrote and how long it took."""
    found = {}

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith(BY_THE_CLOCK):
            found[name] = item[...].tobytes() if item.dtype != object else b"|".join(item[...])

    with h5py.File(path) as file:
        file.visititems(visit)
    return found
