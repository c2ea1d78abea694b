# SPDX-License-Identifier: GPL-3.0-or-later
"""summary.json: what a run has come to. The run and the reports fill it in, and all that shows a number of a run reads it here.

A key of the file is a field of these tables, its unit and meaning in the annotation; docs/outputs.md is written from them. A run writes the
keys that it has: ties only where there are ties. A key that an older version did not write has its default when it is read; null, which
stands for what is not finite, is NaN; keys that are not known here pass.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text
from masonry_cd.foundation.json_files import write_json
from masonry_cd.io.summary_tables import (
    Beds,
    ClosingSteps,
    Count,
    ElasticBasis,
    End,
    Energy,
    Event,
    Flag,
    IslandCounts,
    JointCounts,
    LoadFactor,
    LoadSummary,
    Metres,
    PartInShort,
    Push,
    Real,
    RunVerdict,
    Seconds,
    ShockDamage,
    SkippedWork,
    Solver,
    Speed,
    StressSummary,
    SummaryTable,
    TieTension,
    TimeStep,
)

NAME = "summary.json"
FORMAT = 1  # of its keys; raised when an older program would misread them


class Newer(InputError):
    """A summary of a format that a later version of the program wrote."""


class SummaryHead(SummaryTable):
    """The keys that come first."""

    format: Annotated[Count, "version of the format of the file"] = FORMAT
    title: Annotated[str, "title of the scene"] = ""
    verdict: Annotated[RunVerdict | None, "verdict on the run"] = None


class Summary(JointCounts, SummaryHead):
    """The results of a run in numbers."""

    version: Annotated[str, "version of the program"] = ""
    stopped: Annotated[str, "why the run ended early; empty where it did not"] = ""
    signal: Annotated[Count, "number of the signal that stopped it; 0 without one"] = 0
    timed_out: Flag = Field(default=False, exclude=True)  # it took longer than it was given: for who gave the time, not in the file
    steps: Annotated[Count, "number of time steps computed"] = 0
    steps_asked: Annotated[Count, "number of time steps in run.duration"] = 0
    duration: Annotated[Seconds | None, "run.duration"] = None
    longest: Annotated[Seconds, "time up to which the run may continue until all blocks are at rest"] = 0.0
    still: Annotated[Speed | None, "speed below which a block counts as at rest"] = None
    ended_still: Annotated[Flag, "the run ended because all standing blocks were at rest"] = False
    dt: Annotated[Seconds | None, "run.dt; the shortest step where the step adapts"] = None
    wall_seconds: Annotated[Seconds, "elapsed time of the whole run"] = 0.0
    stepping_seconds: Annotated[Seconds, "elapsed time of the time steps"] = 0.0
    contacts_mean: Annotated[Real, "mean number of contact points of a step"] = 0.0
    contacts_max: Annotated[Count, "largest number of contact points of a step"] = 0
    planar: Annotated[Flag, "the run was solved in the plane of symmetry"] = False
    solver: Solver = Solver()
    islands: IslandCounts = IslandCounts()
    left_out: SkippedWork = SkippedWork()
    built_gap: Annotated[Metres, "widest gap of joints as built"] = 0.0
    penetration_max: Annotated[Metres, "deepest overlap of blocks"] = 0.0
    penetration_where: Annotated[str, "blocks and time of that overlap, if it is large"] = ""
    shortening_max: Annotated[Metres, "largest shortening of an elastic joint"] = 0.0
    shortening_where: Annotated[str, "blocks and time of that shortening, if it is large"] = ""
    closing: ClosingSteps = ClosingSteps()
    energy: Energy = Energy()
    modelled: Annotated[tuple[str, ...], "how the model represents masses, ties and loads, line by line"] = ()
    loads: LoadSummary = LoadSummary()
    masonry: Annotated[dict[str, Any] | None, "the kind of masonry, the values taken from it, and the ranges of its table, in SI units"] = (
        None
    )
    elastic_period: Annotated[Seconds, "first elastic period, which a model of rigid joints does not have"] = 0.0
    amplification: Annotated[Real, "amplification of the base motion at that period: S_a over PGA"] = 0.0
    elastic_basis: ElasticBasis | None = None
    time_step: TimeStep | None = None
    dumped: Annotated[tuple[str, ...], "files of friction problems that were written"] = ()
    explanation: Annotated[tuple[str, ...], "work that the scene did not need, and why"] = ()
    warnings: Annotated[tuple[str, ...], "warnings of the run"] = ()
    python: Annotated[str, "changes of the scene by Python code"] = ""
    load_factor: LoadFactor | None = None
    ties: tuple[TieTension, ...] = ()
    displacement_max: Annotated[Metres, "largest displacement of a block relative to the base, at any time"] = 0.0
    doubts: Annotated[tuple[str, ...] | None, "unusual values, and blocks without support"] = None
    beds: Beds | None = None
    time_step_remarks: Annotated[tuple[str, ...] | None, "reasons why the time step is coarse"] = None
    blocks: Annotated[Count, "number of blocks"] = 0
    joints: Annotated[Count, "number of joints"] = 0
    collapsed_block_names: Annotated[tuple[str, ...], "blocks that have fallen"] = ()
    provisional: Annotated[str, "why residual values and grades are provisional; empty where the run ended at rest"] = ""
    end: End | None = None
    shocks: tuple[ShockDamage, ...] = ()
    events: tuple[Event, ...] = ()
    joints_bonded: Annotated[Count, "joints that were bonded at the start"] = 0
    joints_broken: Annotated[Count, "those whose bond broke, entirely or in part"] = 0
    stones: Annotated[Count, "stones that can crack along planes within them"] = 0
    cracked_stones: Annotated[Count, "those that are cracked at the end"] = 0
    cracked_stone_names: Annotated[tuple[str, ...], "names of the cracked stones"] = ()
    joints_crushed: Annotated[Count, "joints that crushed and remain shorter"] = 0
    crushed_max: Annotated[Metres, "largest permanent shortening of a joint"] = 0.0
    crushed_where: Annotated[str, "blocks of that joint"] = ""
    crushing_forgotten: Annotated[
        Count, "joints whose crushing is no longer tracked because their blocks separated or met with other faces"
    ] = 0
    pushes: tuple[Push, ...] = ()
    parts: tuple[PartInShort, ...] = ()
    stress: StressSummary | None = None

    def __or__(self, more: Summary) -> Summary:
        """This summary with the keys that another has."""
        return self.model_copy(update={name: getattr(more, name) for name in more.model_fields_set})

    def write(self, folder: Path) -> None:
        """Write summary.json."""
        write_json(folder / NAME, self.as_dict())


def read_summary(folder: Path) -> Summary | None:
    """The summary of a run; None where it has written none.

    Raises:
        Newer: its format is unknown here.
        InputError: it is not a summary.
    """
    path = folder / NAME
    if not path.exists():
        return None
    try:
        found = json.loads(read_text(path))
    except (OSError, ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise InputError(path, "not a summary, or one that was cut off")
    form = found.get("format", 0)
    if isinstance(form, int | float) and form > FORMAT:
        raise Newer(path, f"has format {form} of a newer masonry_cd; this version reads formats up to {FORMAT}")
    try:
        return Summary.model_validate(found)
    except ValidationError as fault:
        key = ".".join(map(str, fault.errors()[0]["loc"]))
        raise InputError(path, f"{key} has another type than a run writes: this is not a summary, or it is damaged") from None
