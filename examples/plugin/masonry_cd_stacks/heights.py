# SPDX-License-Identifier: GPL-3.0-or-later
"""``[report] extra = ["heights"]``: heights.csv, how high the centre of each block is at the end of a run."""

from __future__ import annotations

from pathlib import Path

from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.io.results import Results
from reports.extra import ExtraReport


def write(results: Results, folder: Path) -> None:
    """Write the table; all that is known of the run is in its result file."""
    last = results.position[results.frames - 1]
    rows = ([block.name, f"{z:.6g}"] for block, z in zip(results.blocks, last[:, 2].tolist(), strict=True))
    write_csv(folder / "heights.csv", ["block", "height_m"], rows)


HEIGHTS = ExtraReport(("heights.csv",), write)
