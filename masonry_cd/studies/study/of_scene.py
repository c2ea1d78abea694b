# SPDX-License-Identifier: GPL-3.0-or-later
"""The study that another command makes of one scene, by the engine of studies: its runs, and what members of an ensemble differ by."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

from masonry_cd.app.scene import Scene, scene_of
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.app.scene_units import scene_in_si
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.designs import Space
from masonry_cd.studies.study.plan import perturb
from masonry_cd.studies.study.study_file import EnsembleTable, RunTable, Study, StudyTables
from masonry_cd.studies.study.varied import Varied

SIZE = 1e-9  # by which amplitudes of neighbouring members of an ensemble differ, relative; [m/s] of velocities in their place
TIMEOUT = 6 * 3600.0  # of a run [s]: small blocks and half a time step take several times as long as the scene itself
OWN_DRAW = ("velocities", "friction")  # what members differ by, instead of loads that have no size


def tables_of(scene: Scene) -> dict[str, Any]:
    """The tables of a scene as numbers, without what only an assessment reads.

    Raises:
        InputError: a scene without [run].
    """
    scene.refuse_static()
    with scene.locating():
        tables = scene_in_si(scene.tables)
    tables.pop("assess", None)
    return tables


def space_of(scene: Scene, tables: dict[str, Any]) -> tuple[Study, Space]:
    """The study of a scene and its tables, and what its runs choose from: nothing by itself."""
    own = replace(scene_of(tables, scene.text, scene.path, scene.origin), quiet_checks=scene.quiet_checks)
    ensemble = EnsembleTable(perturb=_perturbs(tables), size=SIZE)
    top = StudyTables(scene=tables, design="ensemble", title=scene.title, ensemble=ensemble, run=RunTable(timeout=TIMEOUT))
    study = Study(scene.path, dump_toml(tables), top, own, tables, scene.path.name, Varied({}, {}, []), scene.origin)
    return study, Space(top, None, study.varied)


def _perturbs(tables: dict[str, Any]) -> Any:
    """What the members of an ensemble differ by: the loads where they have a size, else first velocities, else friction."""
    try:
        perturb(copy.deepcopy(tables), "loads", SIZE)
    except InputError:
        return OWN_DRAW["first_velocities" in tables["run"]]
    return "loads"
