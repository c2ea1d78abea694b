# SPDX-License-Identifier: GPL-3.0-or-later
"""The outputs in the folder of a run, each declared once: its files with what they hold, when it is asked for, and what writes it.

A module of ``reports/outputs`` lists its own in ``OUTPUTS``, by a name. A run and the command ``report`` write those that are asked for, a
new run clears them, the page carries the tables that say so, and docs/outputs.md has them all. So a new output is one new file there. What
a scene is to ask for by a name of its own choice is an extra report (:mod:`reports.extra`). A run whose ``[report]`` asks for nothing loads
none of this.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.foundation import own_files
from masonry_cd.foundation.extensions import Entries
from reports.extra import EXTRA
from reports.settings import Report

if TYPE_CHECKING:  # scenes are checked before HDF5 is loaded
    from masonry_cd.analysis.damage.part_damage import PartDamage
    from masonry_cd.io.results import Results


@dataclass(eq=False)
class Job:
    """The folder of a run that is to get outputs."""

    results: Results
    folder: Path
    settings: Report
    summary: Mapping[str, Any]
    time: float | None = None  # of the frame that maps show [s]; None: of the last
    asked: Mapping[str, bool] = field(default_factory=dict)  # of outputs that are wanted, or not, whatever the settings say
    more: dict[str, Any] = field(default_factory=dict)  # what outputs add to the summary

    @cached_property
    def damage(self) -> PartDamage:
        """The damage by part."""
        from reports.damage import damage_of

        return damage_of(self.results, self.settings)

    def wants(self, name: str) -> bool:
        """Whether an output is asked for."""
        return self.asked.get(name, OUTPUTS[name].asked(self))

    def write(self) -> list[Path]:
        """Write all that are asked for, in their order; return the files."""
        order = sorted(OUTPUTS, key=lambda name: OUTPUTS[name].place)
        written = []
        for path in (path for name in order if self.wants(name) for path in OUTPUTS[name].write(self)):
            own_files.note(path)  # also what a plug-in has written
            written.append(path)
        return written


@dataclass(frozen=True)
class Output:
    """Files that belong together."""

    files: Mapping[str, str]  # what each holds, by its name
    write: Callable[[Job], Iterable[Path]] = lambda _: ()  # by default the run itself writes them, step by step
    asked: Callable[[Job], bool] = lambda _: False
    place: int = 0  # in the order in which they are written
    carried: tuple[str, ...] = ()  # tables that the page carries


OUTPUTS: Entries[Output] = Entries("reports.outputs", "OUTPUTS")


def known_files() -> dict[str, str]:
    """All files with what they hold, those of extra reports last."""
    own = {name: meaning for output in OUTPUTS.values() for name, meaning in output.files.items()}
    return own | {name: report.meaning for report in EXTRA.values() for name in report.files}
