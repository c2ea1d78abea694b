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

    format: Annotated[Count, "of this file"] = FORMAT
    title: Annotated[str, "of the scene"] = ""
    verdict: Annotated[RunVerdict | None, "on the run"] = None


class Summary(JointCounts, SummaryHead):
    """The results of a run in numbers."""

    version: Annotated[str, "of the program"] = ""
    stopped: Annotated[str, "why the run ended early; empty where it did not"] = ""
    signal: Annotated[Count, "number of the signal that stopped it; 0 without one"] = 0
    timed_out: Flag = Field(default=False, exclude=True)  # it took longer than it was given: for who gave the time, not in the file
    steps: Annotated[Count, "time steps made"] = 0
    steps_asked: Annotated[Count, "time steps that run.duration asks for"] = 0
    duration: Annotated[Seconds | None, "run.duration"] = None
    longest: Annotated[Seconds, "time up to which the run may go on until all blocks are still"] = 0.0
    still: Annotated[Speed | None, "what is slower does not move"] = None
    ended_still: Annotated[Flag, "the run ended since all that stands was still"] = False
    dt: Annotated[Seconds | None, "run.dt; the shortest step where it adapts"] = None
    wall_seconds: Annotated[Seconds, "time of the clock that all of it took"] = 0.0
    stepping_seconds: Annotated[Seconds, "time of the clock that the steps took"] = 0.0
    contacts_mean: Annotated[Real, "contact points of a step"] = 0.0
    contacts_max: Annotated[Count, "contact points of a step"] = 0
    planar: Annotated[Flag, "solved in the plane of symmetry"] = False
    solver: Solver = Solver()
    islands: IslandCounts = IslandCounts()
    left_out: SkippedWork = SkippedWork()
    built_gap: Annotated[Metres, "widest gap of joints as built"] = 0.0
    penetration_max: Annotated[Metres, "deepest overlap of blocks"] = 0.0
    penetration_where: Annotated[str, "its blocks and time, of one that is deep"] = ""
    shortening_max: Annotated[Metres, "largest shortening of an elastic joint"] = 0.0
    shortening_where: Annotated[str, "its blocks and time, of one that is large"] = ""
    closing: ClosingSteps = ClosingSteps()
    energy: Energy = Energy()
    modelled: Annotated[tuple[str, ...], "what stands for what, line by line"] = ()
    loads: LoadSummary = LoadSummary()
    masonry: Annotated[dict[str, Any] | None, "the kind of masonry, what is taken of it, and the ranges of its table, in SI units"] = None
    elastic_period: Annotated[Seconds, "first elastic period, which rigid joints leave out"] = 0.0
    amplification: Annotated[Real, "of the motion of the base at that period: S_a over PGA"] = 0.0
    elastic_basis: ElasticBasis | None = None
    time_step: TimeStep | None = None
    dumped: Annotated[tuple[str, ...], "files of friction problems"] = ()
    explanation: Annotated[tuple[str, ...], "what was left out for this scene, and why"] = ()
    warnings: Annotated[tuple[str, ...], "what must not pass in silence"] = ()
    python: Annotated[str, "what code added to the scene"] = ""
    load_factor: LoadFactor | None = None
    ties: tuple[TieTension, ...] = ()
    displacement_max: Annotated[Metres, "largest displacement of a block relative to the base, at any time"] = 0.0
    doubts: Annotated[tuple[str, ...] | None, "values that are unusual, and blocks that nothing carries"] = None
    beds: Beds | None = None
    time_step_remarks: Annotated[tuple[str, ...] | None, "why the time step is coarse"] = None
    blocks: Annotated[Count, "in all"] = 0
    joints: Annotated[Count, "in all"] = 0
    collapsed_block_names: Annotated[tuple[str, ...], "blocks that have fallen"] = ()
    provisional: Annotated[str, "why residual values and grades are not the last; empty where the run ended at rest"] = ""
    end: End | None = None
    shocks: tuple[ShockDamage, ...] = ()
    events: tuple[Event, ...] = ()
    joints_bonded: Annotated[Count, "joints that were bonded at the start"] = 0
    joints_broken: Annotated[Count, "those of them whose bond broke, all over or in part"] = 0
    stones: Annotated[Count, "stones that can crack along planes within them"] = 0
    cracked_stones: Annotated[Count, "those of them that are cracked at the end"] = 0
    cracked_stone_names: Annotated[tuple[str, ...], "their names"] = ()
    joints_crushed: Annotated[Count, "joints that are shorter for good"] = 0
    crushed_max: Annotated[Metres, "largest such shortening"] = 0.0
    crushed_where: Annotated[str, "its blocks"] = ""
    crushing_forgotten: Annotated[Count, "joints whose crushing is forgotten, since their blocks came apart or met with other faces"] = 0
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
        InputError: it is no summary.
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
        raise Newer(path, f"of format {form}, which a newer masonry_cd wrote; this one reads formats up to {FORMAT}")
    try:
        return Summary.model_validate(found)
    except ValidationError as fault:
        key = ".".join(map(str, fault.errors()[0]["loc"]))
        raise InputError(path, f"{key} is not what a run writes: not a summary, or a damaged one") from None
