# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``build`` writes of a building's plan: plan.json, from which one can go on by hand, plan.svg, and what was not understood."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.app.scene import Scene
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing

NAMES = tuple(name for name in files_of("build") if name.startswith("plan"))  # plan.json, plan.svg, plan_left.csv


def write_plan_files(scene: Scene, folder: Path, picture: bool) -> list[Path]:
    """Write the plan from which a structure is built; the paths of what was written, none for a kind without a plan.

    Args:
        scene: of a structure that can be built.
        folder: which gets the files.
        picture: whether plan.svg is asked for.

    Raises:
        InputError: a file cannot be written.
    """
    from structures.plans.json_plan import write_json
    from structures.tables import own_keys

    kind = scene.kind
    if kind is None or kind.plan is None:
        return []
    tables, left = kind.plan(own_keys(scene.structure), scene.folder)
    own_files.remove(folder, NAMES[1:])  # of a former build
    written = [folder / NAMES[0]]
    write_json(written[0], tables)
    if picture:
        written.append(folder / NAMES[1])
        _draw(tables, written[-1], scene.title)
    if left:
        written.append(folder / NAMES[2])
        with replacing(written[-1]) as part, part.open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([("handle", "layer", "drawn_as", "why"), *left])
    return written


def _draw(tables: dict[str, Any], path: Path, title: str) -> None:
    from reports.drawing.plan_picture import plan_picture
    from structures.plans.outlines import outline_of

    walls = [outline_of(wall) for wall in tables["walls"]]
    others = [(vault["shape"], np.array(vault["corners"], dtype=float)) for vault in tables.get("vaults", ()) if vault.get("corners")]
    for column in tables.get("columns", ()):
        at, half = np.array(column["at"], dtype=float), 0.5 * float(column.get("size", 0.6))
        others += [("", place + half * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])) for place in at.reshape(-1, 2)]
    plan_picture(walls, others, path, title)
