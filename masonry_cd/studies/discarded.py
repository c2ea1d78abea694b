# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs whose numbers are wanted and whose folder is not."""

from __future__ import annotations

import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from masonry_cd.app.case import Case
from masonry_cd.app.run_case import run_case


def run_and_discard(case: Case) -> dict[str, Any]:
    """Run a case in a folder that is thrown away; its summary, with the seconds of the processor from the first step to the last file.

    Raises:
        KeyboardInterrupt: it was interrupted.
    """
    begin = time.process_time()
    with TemporaryDirectory() as folder:
        summary = run_case(case, Path(folder) / "out")
    if summary["signal"]:
        raise KeyboardInterrupt
    return summary | {"processor": time.process_time() - begin}
