# SPDX-License-Identifier: GPL-3.0-or-later
"""The outputs in the folder of a run, each declared once: its files and their contents, the condition for it, and its function.

A module of ``reports/outputs`` lists its own in ``OUTPUTS``, by a name; a package adds one by its entry points. A scene asks for an output
by the key of its name, ``[report] energy = true``, unless the output says otherwise. A run and the command ``report`` write those that are
requested, a new run clears them, the page carries the tables that say so, and docs/outputs.md has them all. So a new output is one new file
there. A run whose ``[report]`` asks for nothing loads none of this.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from masonry_cd.foundation import own_files, plugins
from reports.settings import OUTPUTS, Report

if TYPE_CHECKING:  # scenes are checked before HDF5 is loaded
    from masonry_cd.analysis.damage.part_damage import PartDamage
    from masonry_cd.io.results import Results
    from masonry_cd.io.summary import Summary


@dataclass(eq=False)
class Job:
    """The folder of a run that is to get outputs."""

    results: Results
    folder: Path
    settings: Report
    summary: Summary  # outputs add to it
    time: float | None = None  # of the frame that maps show [s]; None: of the last
    asked: Mapping[str, bool] = field(default_factory=dict)  # of outputs that are wanted, or not, whatever the settings say

    @cached_property
    def damage(self) -> PartDamage:
        """The damage by part."""
        from reports.damage import damage_of

        return damage_of(self.results, self.settings)

    @cached_property
    def outputs(self) -> dict[str, Output]:
        """All of ours, and those of packages that the settings name, in the order in which they are written."""
        known = dict(OUTPUTS) | {name: output_of(name) for name in self.settings.by_name if name not in OUTPUTS}
        return dict(sorted(known.items(), key=lambda item: item[1].place))

    def wants(self, name: str) -> bool:
        """Return True if an output is requested."""
        asked = self.outputs[name].asked
        return self.asked.get(name, bool(getattr(self.settings, name, False)) if asked is None else asked(self))

    def write(self) -> list[Path]:
        """Write all requested outputs, in their order; return the files."""
        written = []
        for path in (path for name, output in self.outputs.items() if self.wants(name) for path in output.write(self)):
            own_files.note(path)  # also what a plug-in has written
            written.append(path)
        return written


@dataclass(frozen=True)
class Output:
    """Files that belong together."""

    files: Mapping[str, str]  # what each holds, by its name
    write: Callable[[Job], Iterable[Path]] = lambda _: ()  # by default the run itself writes them, step by step
    asked: Callable[[Job], bool] | None = None  # by default where the key of its name in [report] is true
    place: int = 40  # in the order in which they are written; the page comes at 50
    carried: tuple[str, ...] = ()  # tables that the page carries
    needs: tuple[str, ...] = ()  # libraries that it imports and a plain install lacks, by the name that is imported


def output_of(name: str) -> Output:
    """An output: ours, or one that a package adds.

    Raises:
        InputError: no such output, or a package that cannot be used.
    """
    found: Output = plugins.find("reports", name, f"report.{name}", OUTPUTS)
    return found


def never(_: Job) -> bool:
    """False: the run itself, or a command, writes these files."""
    return False


def known_files() -> dict[str, str]:
    """All files with what they hold."""
    return {name: meaning for output in OUTPUTS.values() for name, meaning in output.files.items()}
