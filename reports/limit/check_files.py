# SPDX-License-Identifier: GPL-3.0-or-later
"""check.csv: the check of a mechanism by a code, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.foundation.csv_files import write_csv

STEPS = ("symbol", "value", "unit", "clause", "meaning")


def write_check(check: Mapping[str, Any], path: Path) -> None:
    """Write the steps of a check, below them its checks.

    Args:
        check: its ``steps`` and ``verdicts``.
        path: of the file.
    """
    rows = [[f"{step[key]:.6g}" if key == "value" else step[key] for key in STEPS] for step in check["steps"]]
    for one in check["verdicts"]:
        rows.append([f"{one['check']} check", one["state"], "", one["clause"], one["words"]])
    write_csv(path, STEPS, rows)
