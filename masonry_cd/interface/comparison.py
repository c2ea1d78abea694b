# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs side by side."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.foundation.extras import require
from masonry_cd.interface.plots import shown
from masonry_cd.interface.results import Run
from masonry_cd.interface.returned import RunWarning
from masonry_cd.interface.sealed import Sealed
from reports.compare import comparison

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

Source = Run | str | os.PathLike[str]


class Comparison(Sealed):
    """Differences in the scenes of some runs, in their damage and in their response; ``print`` shows them as Markdown."""

    def __init__(self, found: comparison.ComparisonTable) -> None:
        self._found = found

    @property
    def table(self) -> DataFrame:
        """A row per quantity, a column per run; the column ``unit`` says the units."""
        require("a table", "pandas")
        import pandas

        rows = [[name, unit, *values] for name, unit, values in self._found.rows]
        return pandas.DataFrame(rows, columns=["quantity", *self._found.header[1:]], dtype=object).set_index("quantity")

    def plot(self) -> Figure:
        """The picture of the comparison, a figure that a notebook shows."""
        from reports.compare.comparison import comparison_figure

        return shown(comparison_figure(self._found))

    def write(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Write comparison.csv, comparison.md and comparison.png; return their paths."""
        return comparison.write_comparison(self._found, Path(folder))

    def __str__(self) -> str:
        return comparison.markdown(self._found)

    def __repr__(self) -> str:
        return f"<Comparison of {', '.join(self._found.header[2:])}>"

    def _repr_html_(self) -> str:
        shown: Any = self.table.map(lambda value: f"{value:.3g}" if isinstance(value, float) else value)
        return str(shown.to_html(na_rep=comparison.MISSING))


def compare(runs: Sequence[Source] | Mapping[str, Source]) -> Comparison:
    """Lay runs side by side. Damage is judged by the thresholds of the first of them.

    Args:
        runs: two or more runs or their folders; a dict gives them names, otherwise their folders do.

    Raises:
        InputError: fewer than two runs, one given twice, or a folder that holds none.

    >>> import masonry_cd as mc
    >>> short = mc.scene("examples/trilithon.toml", "run.duration=0.01")
    >>> runs = {c: mc.run(short.changed(f"loads[0].amplitude={c}"), progress=False) for c in (0.3, 0.6)}
    >>> mc.compare(runs).table.loc["loads[0].amplitude"].tolist()
    ['', 0.3, 0.6]
    """
    names = [str(name) for name in runs] if isinstance(runs, Mapping) else None
    sources = list(runs.values()) if isinstance(runs, Mapping) else list(runs)
    found = comparison.compare([source.folder if isinstance(source, Run) else Path(source) for source in sources], names)
    for line in found.words:
        warnings.warn(line, RunWarning, stacklevel=2)
    return Comparison(found)
