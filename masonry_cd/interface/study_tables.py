# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of a study that is made in Python: its scene inside them, and its arrays as files beside study.toml."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.scenes import scene
from masonry_cd.interface.values import plain
from masonry_cd.studies.study.folder import StudyFolder
from masonry_cd.studies.study.plan import Plan
from masonry_cd.studies.study.study_case import plan_of_study, require_own
from masonry_cd.studies.study.study_file import parse_study

CALLED = "study"  # one made in Python, in messages
FILE = "study.toml"


def plan_of_tables(tables: Mapping[str, Any], folder: Path, force: bool) -> Plan:
    """The plan of a study made in Python; the files that hold its arrays are written into its folder, once all is checked.

    Args:
        tables: of a study file; ``scene`` may be anything that :func:`masonry_cd.scene` takes.
        folder: of the study.
        force: write over files of other arrays.

    Raises:
        InputError: anything wrong with the study or its scene; another study in the folder.
    """
    if "scene" not in tables:
        raise InputError(CALLED, "scene: missing")
    asked = scene(tables["scene"])
    inside, arrays = asked.portable()
    given = {name: value for name, value in tables.items() if name != "scene"}
    own = plain(given | ({"title": asked.title} if "title" not in given else {}), "")
    records = own.get("records")
    if isinstance(records, dict) and isinstance(records.get("folder"), str):
        records["folder"] = str(Path(records["folder"]).absolute())
    text = dump_toml(own | {"scene": inside})
    if not arrays:
        return plan_of_study(parse_study(text, folder / FILE, CALLED))
    plan = plan_of_study(parse_study(text, asked.checked.folder / FILE, CALLED))  # where the arrays lie now
    if not force:
        require_own(plan, folder)
    StudyFolder(folder).hold(arrays)
    for name, content in arrays.items():
        with replacing(folder / name) as part:
            part.write_bytes(content)
    return plan_of_study(parse_study(text, folder / FILE, CALLED))
