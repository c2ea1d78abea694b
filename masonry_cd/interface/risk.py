# SPDX-License-Identifier: GPL-3.0-or-later
"""The risk sheet of a structure, from the folders of limit analyses and of a study."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.foundation.extras import require
from masonry_cd.interface.sealed import Sealed
from reports.risk import sheet

if TYPE_CHECKING:
    from pandas import DataFrame

Folder = str | os.PathLike[str]


class RiskSheet(Sealed):
    """Hazard, capacity, return period, class and annual frequencies of a structure; ``print`` shows the closing lines."""

    def __init__(self, found: sheet.RiskSheet) -> None:
        self._found = found

    @property
    def table(self) -> DataFrame:
        """A row per quantity with its formula, a column per analysis, as the page has them."""
        require("a table", "pandas")
        import pandas

        rows = [[name, *values, formula] for name, values, formula in self._found.rows]
        return pandas.DataFrame(rows, columns=["quantity", *(name for name, _ in self._found.columns), "formula"]).set_index("quantity")

    @property
    def numbers(self) -> dict[str, Any]:
        """The contents of risk.json, in SI units."""
        return self._found.numbers()

    def write(self, folder: Folder) -> list[Path]:
        """Write risk.html, risk.json and hazard.png; return their paths.

        Raises:
            InputError: matplotlib is not installed, or a folder that cannot be written.
        """
        return sheet.write_sheet(self._found, Path(folder))

    def __str__(self) -> str:
        return "\n".join(self._found.lines)


def risk_sheet(before: Folder, after: Folder | None = None, study: Folder | None = None) -> RiskSheet:
    """Read the risk sheet of a structure.

    Args:
        before: folder of its limit analysis, of a scene with [hazard] and [limit.check].
        after: folder of the limit analysis of the strengthened structure.
        study: folder of a study over the same hazard.

    Raises:
        InputError: a folder without such results, or one of another site, limit state or code.
    """
    return RiskSheet(sheet.read_sheet(Path(before), None if after is None else Path(after), None if study is None else Path(study)))
