# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of a study before anything runs: that every value that varies is one the scene takes, and that its runs can be made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from masonry_cd.analysis.fragility.limits import BOUND, LimitStateTable
from masonry_cd.app.case import prepare, structure_of
from masonry_cd.app.scene import Origin, Scene, scene_of
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.designs import DesignedRun, Space
from masonry_cd.studies.study.plan import Maker, StudyPlan
from masonry_cd.studies.study.study_file import ReadStudy
from masonry_cd.studies.study.study_units import ROTATE, UNITS

MOST_TRIED = 20  # values of a list for which structures are built
BUILT = ("structure.", "structures[")  # beginnings of keys for which blocks are built
RUN_SCENE = Path("scene.toml")  # what messages call the scene of a run


def scene_of_run(tables: dict[str, Any], path: Path = RUN_SCENE) -> Scene:
    """The scene of a run, from its tables.

    Raises:
        InputError: as for a scene file.
    """
    text = dump_toml(tables)
    return scene_of(tables, text, path, Origin("", path))


def check_varied(study: ReadStudy, space: Space) -> None:
    """Try each value that a key may take, those at the ends of distributions, on the scene.

    Raises:
        InputError: names the key, the value, and what the scene says of it.
    """
    maker = Maker(study, space)
    ida = study.tables.ida
    motion, level = space.motions[0], next(iter(space.levels)) or (None if ida is None else ida.start)
    for key, value, of in _tried(space):
        if key == ROTATE:
            _check_rotation(study, value)
            continue
        try:
            tables = maker.tables(DesignedRun(motion, level, values={key: value}))
            _try(tables, key)
        except InputError as error:
            shown = f"{value:.6g}" if isinstance(value, float) else str(value)
            place = f'vary."{key}"'
            said = error.faults[0].text if error.place == place else error.unsourced()
            with study.locating():
                raise InputError(place, f"{of}{shown} is refused by the scene: {said}") from None
    if study.tables.records is not None and study.tables.records.rotate:
        _check_rotation(study, study.tables.records.rotate)


def check_first(plan: StudyPlan) -> tuple[str, ...]:
    """Prepare the first run as a worker would, which compiles the kernels: what is wrong with all runs is found before they begin.

    Returns:
        what the run would warn of: values that are likely in another unit, steps that are too coarse.

    Raises:
        InputError: anything wrong with the structure, the material or the loads.
    """
    study = plan.maker.study
    try:
        made = prepare(scene_of_run(plan.maker.tables(plan.runs[0].asked), study.path)).warnings
    except InputError as error:
        raise InputError(study.path, f"the first run: {error.unsourced()}") from None
    return (*bound_doubts(study.tables.limit_states), *made)


def bound_doubts(states: Mapping[str, LimitStateTable]) -> list[str]:
    """A line on each bound of a limit state that is likely in another unit."""
    out = []
    for name, state in states.items():
        if state.above is not None and UNITS.get(state.quantity) == "m" and not BOUND.holds(state.above):
            meant = BOUND.meant(state.above, "m")
            out.append("; ".join(filter(None, [f"limit_states.{name}.above = {state.above:g} m: {BOUND.reason}", meant])))
    return out


def _tried(space: Space) -> Iterator[tuple[str, Any, str]]:
    """Keys with the values to try, and what to call these."""
    for key, values in space.varied.lists.items():
        for value in values[:MOST_TRIED] if key.startswith(BUILT) else values:
            yield key, value, ""
    for key, distribution in space.varied.random.items():
        for value in distribution.extremes():
            yield key, value, "its distribution reaches values where "


def _try(tables: dict[str, Any], key: str) -> None:
    """Read the tables as those of a scene; where the structure varies, build it."""
    import loads

    scene = scene_of_run(tables)
    for i, table in enumerate(scene.loads):
        loads.parse_load(table, f"loads[{i}]")
    if key.startswith(BUILT):
        structure_of(scene)


def _check_rotation(study: ReadStudy, value: object) -> None:
    """Check that there is a pair to turn by an angle."""
    table = study.tables.records
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not number or table is None or not (table.x and table.y):
        why = "should be an angle in degrees" if not number else "turns a horizontal pair: records.x and records.y are both needed"
        with study.locating():
            raise InputError(ROTATE, why)
