"""What a result file holds, to compare runs bit by bit."""

from __future__ import annotations

from pathlib import Path

import h5py


def contents(path: Path) -> dict[str, bytes]:
    """All datasets but the seconds that steps took."""
    found = {}

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            found[name] = item[...].tobytes() if item.dtype != object else b"|".join(item[...])

    with h5py.File(path) as file:
        file.visititems(visit)
    del found["solver/seconds"]
    return found
