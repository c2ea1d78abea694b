# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of ``masonry-cd strengthen``: strengthen.json, tables, pictures before and after, page, and the strengthened scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.limit.problem import bar_rows
from masonry_cd.analysis.limit.ties import LimitTie, limit_ties
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.app.scene import Scene
from masonry_cd.app.scene_text import dump_toml, parse_toml, toml_text
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.json_files import write_json
from masonry_cd.foundation.quantities import force
from masonry_cd.limit.case import LimitCase
from masonry_cd.limit.checked import Checked
from masonry_cd.strengthening.design import StrengtheningDesign, counted
from masonry_cd.strengthening.facts import facts, least_row, lines
from reports.drawing.figure import Sheet
from reports.limit.picture import LimitSubject, mechanism_scene
from reports.limit.strengthen_page import write_strengthen_page

EVERY = files_of("strengthen")
SCENE = "strengthened.toml"
STRETCHED = 1e-4  # share of the largest velocity above which a tie that grows longer yields


class ActingTie(LimitTie):
    """A tie in a mechanism, which says of it no more than whether it yields."""

    @property
    def words(self) -> str:
        """As a picture has it."""
        return f"{force(self.total)}, yields" if self.total else "does not yield"


def write(made: StrengtheningDesign, folder: Path, pictures: bool = True, view: str = "auto") -> tuple[dict[str, Any], list[Path]]:
    """Write all files into a folder, which is created if missing; return the contents of strengthen.json, and the paths.

    Raises:
        InputError: an unknown view, no off-screen OpenGL for the pictures.
    """
    own_files.begin(folder, EVERY)
    own_files.remove(folder, EVERY)
    found = facts(made)
    write_json(folder / "strengthen.json", found)
    for name in ("parts", "ties"):
        rows = found[name]
        write_csv(folder / f"{name}.csv", [*rows[0]] if rows else ["name"], [list(row.values()) for row in rows], digits=6)
    head = f"# {made.asked.goal.words}: {len(made.ties)} ties by masonry-cd strengthen, at the end. Keep files that it names next to it.\n"
    with replacing(folder / SCENE) as part:
        part.write_text(head + scene_text(made.asked.scene, made.rows), encoding="utf-8")
    drawn: dict[Path, str] = {}
    for stage, cases in (("before", made.before), ("after", made.after)) if pictures else ():
        drawn |= _draw(made, cases, folder / f"{stage}.png", stage, view)
    write_strengthen_page(found, lines(found), drawn, made.asked.scene.text, folder / "strengthen.html")
    names = ("strengthen.json", "parts.csv", "ties.csv", SCENE, "strengthen.html")
    return found, [*(folder / name for name in names), *drawn]


def _draw(made: StrengtheningDesign, cases: tuple[LimitCase, ...], path: Path, stage: str, view: str) -> dict[Path, str]:
    """Draw the mechanism that starts earliest against what is asked of it, with the ties; the PNG with what it shows."""
    every = [(each, case) for case in cases for each in counted(case) if each.one.mechanism is not None]
    first = least_row(made.asked, [each for each, _ in every])
    if first is None or first.one.mechanism is None:
        return {}
    case = next(case for each, case in every if each is first)
    row, structure = first.row, case.structure
    words = f"{row['element']}, push {row['push']} · load factor {row['alpha0']:.4g}"
    subject = LimitSubject(first.one.mechanism, structure.assembly.blocks, structure.joints, _ties(case, first))
    title = f"{made.asked.scene.title}: the least mechanism {stage}"
    Sheet.drawn(mechanism_scene(subject, title, words, view)).save(path)
    return {path: f"{stage.capitalize()}: {words}, {first.one.name}. Ties that the mechanism stretches yield."}


def _ties(case: LimitCase, each: Checked) -> list[ActingTie]:
    """All ties of a structure; those that a mechanism stretches pull what they yield at."""
    assert each.one.mechanism is not None
    loads = case.structure.loads_of_parts()
    bars, velocity = loads.bars, each.one.mechanism.velocity
    stretched = np.einsum("red,red->r", bar_rows(case.structure.assembly, bars), velocity[bars.blocks]) > STRETCHED
    pulls = np.where(stretched & np.isfinite(bars.strength), bars.strength, 0.0)
    return [ActingTie(**vars(tie)) for tie in limit_ties(loads.tie_names, bars, pulls, case.structure.assembly.names, 0.0)]


def scene_text(scene: Scene, rows: Sequence[Mapping[str, Any]]) -> str:
    """A scene without its table [strengthen], as it was written, with more ties in tables [[structure.ties]] at its end.

    Where these cannot stand there, its tables are written again.
    """
    tables = {key: value for key, value in scene.tables.items() if key != "strengthen"}
    if rows:
        tables["structure"] = {**tables["structure"], "ties": [*tables["structure"].get("ties", ()), *rows]}
    ties = ["\n".join(["", "[[structure.ties]]", *(f"{key} = {toml_text(value)}" for key, value in row.items()), ""]) for row in rows]
    text = _without_question(scene.text).rstrip("\n") + "\n" + "".join(ties)
    try:
        same = parse_toml(text, Path(SCENE)) == tables
    except InputError:
        same = False
    return text if same else dump_toml(tables)


def _without_question(text: str) -> str:
    """A scene without the sections of the table [strengthen]."""
    kept, inside = [], False
    for line in text.splitlines(keepends=True):
        if line.lstrip().startswith("["):
            inside = line.strip().lstrip("[ ").startswith("strengthen")
        if not inside:
            kept.append(line)
    return "".join(kept)
