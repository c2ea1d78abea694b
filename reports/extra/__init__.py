# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports beyond those that have a key of their own in [report]: a scene asks for them by name, ``extra = ["energy"]``.

One is an :class:`ExtraReport`, listed by name in the ``REPORTS`` of a module here. It reads the result alone; the settings of the scene,
where it needs them, are ``reports.settings.report_of(results.tables)``.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from masonry_cd.foundation import plugins
from masonry_cd.foundation.extensions import Entries

if TYPE_CHECKING:  # scenes are checked before HDF5 is loaded
    from masonry_cd.io.results import Results


class ExtraReport(NamedTuple):
    """A report that a module adds."""

    files: tuple[str, ...]  # what it writes into the folder of a run, by name
    write: Callable[[Results, Path], None]  # from results, into a folder
    meaning: str = ""  # what they hold: their line of the reference
    needs: tuple[str, ...] = ()  # libraries that it imports and a plain install lacks, by the name that is imported


def extra_report(name: str) -> ExtraReport:
    """A report: ours, or one that a package adds.

    Raises:
        InputError: no such report, or a package that cannot be used.
    """
    found: ExtraReport = plugins.find("reports", name, "report.extra", EXTRA)
    return found


EXTRA: Entries[ExtraReport] = Entries("reports.extra", "REPORTS")
