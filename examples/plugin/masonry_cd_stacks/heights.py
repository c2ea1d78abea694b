# SPDX-License-Identifier: GPL-3.0-or-later
"""``[report] heights = true``: heights.csv, how high the centre of each block is at the end of a run."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from masonry_cd.foundation.csv_files import write_csv
from reports.files import Job, Output


def write(job: Job) -> Iterable[Path]:
    """Write the table; all that is known of the run is in its result file."""
    results, path = job.results, job.folder / "heights.csv"
    last = results.position[results.frames - 1]
    rows = ([block.name, f"{z:.6g}"] for block, z in zip(results.blocks, last[:, 2].tolist(), strict=True))
    write_csv(path, ["block", "height_m"], rows)
    return [path]


HEIGHTS = Output({"heights.csv": "every block: how high its centre is at the end"}, write)
