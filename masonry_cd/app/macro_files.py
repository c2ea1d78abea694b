# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``masonry-cd limit --macro-elements`` writes: table, page, pictures."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.analysis import Collapse
from masonry_cd.analysis.limit.macro import FREE, PartMechanism
from masonry_cd.analysis.limit.mechanism import Mechanism
from masonry_cd.analysis.limit.part import BED
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.app.limit_macro import MacroCase, least_rows, lines
from masonry_cd.app.macro_verdicts import MacroRow, way_words
from masonry_cd.foundation import own_files
from masonry_cd.mechanics.model.joints import Joints
from reports.limit.page import CSV, JSON, PAGE, PICTURES, MacroPage, damage_by_group, write_macro_csv, write_macro_page

if TYPE_CHECKING:
    from reports.limit.picture import Subject

MACRO_OUTPUTS = files_of("limit --macro-elements")


def macro_summary(case: MacroCase) -> dict[str, Any]:
    """What macro_elements.json holds."""
    from masonry_cd import __version__
    from masonry_cd.app.limit_table import limit_table

    table = limit_table(case.scene.limit).check
    return {
        "title": f"{case.scene.title}: macro-elements",
        "version": __version__,
        "blocks": case.assembly.count,
        "elements": len({one.element.name for one in case.parts}),
        "verdict": None if case.verdict is None else case.verdict.numbers(),
        "mechanisms": [asdict(row) for row in case.rows],
        "parts": [_part(case, k) for k in range(len(case.parts))],
        "left_open": list(_left_open(table)),
        "lines": lines(case),
        "modelled": list(case.modelled),
        "notes": list(case.notes),
        "seconds": case.seconds,
    }


def _left_open(table: Any) -> tuple[str, ...]:
    """What the clauses leave open, as a check of the whole says it."""
    if table is None:
        return ()
    found: tuple[str, ...] = table.by.left_open(table.at(table.building_height) if table.building else table)
    return found


def _part(case: MacroCase, k: int) -> dict[str, Any]:
    """A part under a push: its blocks, the search within it, what holds it."""
    part, least = case.parts[k], case.parts[k].least
    search = None
    if least is not None:
        search = {"least": least.optimum.factor, "starts": least.starts, "agreeing": least.agreeing, "spread": least.spread}
    return {
        "element": part.element.name, "kind": part.element.kind, "push": way_words(part.direction), "points": part.points,
        "interlock_n": part.interlock, "search": search, "held": not part.mechanisms, "remarks": list(part.remarks),
        "blocks": [case.assembly.names[b] for b in part.element.blocks],
    }  # fmt: skip


def write_macro(case: MacroCase, folder: Path, pictures: bool = True, view: str = "auto", run: Path | None = None) -> list[Path]:
    """Write macro_elements.csv, .json and .html, and a picture of the least mechanism of each part into ``macro_elements``.

    Args:
        case: what was found.
        folder: for the files, made if need be.
        pictures: draw them.
        view: of the pictures.
        run: the folder of a run, whose damage stands beside the parts.

    Raises:
        InputError: an unknown view, no off-screen OpenGL; a run without damage.csv.
    """
    from masonry_cd.foundation.json_files import write_json

    damage = {} if run is None else _damage(case, run)
    own_files.begin(folder, MACRO_OUTPUTS)
    own_files.begin(folder / PICTURES, ("*.png",))
    own_files.remove(folder / PICTURES, ("*.png",))
    facts, least = macro_summary(case), least_rows(case.rows)
    write_json(folder / JSON, facts)
    write_macro_csv(facts["mechanisms"], folder / CSV)
    drawn = _draw(case, least, folder / PICTURES, view) if pictures else {}
    held = [f"{one.element.name} {way_words(one.direction)}" for one in case.parts if not one.mechanisms]
    command = "masonry-cd limit scene.toml -o out --macro-elements"
    page = MacroPage(
        facts, [asdict(row) for row in least], held, case.scene.text, command, case.scene.report.model_dump(exclude_unset=True), damage
    )
    write_macro_page(page, drawn, folder / PAGE)
    return [folder / JSON, folder / CSV, *drawn, folder / PAGE]


def _damage(case: MacroCase, run: Path) -> dict[str, str]:
    """What a run did to the groups of each part."""
    known, assembly = damage_by_group(run), case.assembly
    out = {}
    for part in case.parts:
        groups = [assembly.groups[g] for g in np.unique(assembly.group_of[part.element.blocks])]
        out[part.element.name] = ", ".join(f"{group} {known[group]}" for group in groups if group in known)
    return out


def _draw(case: MacroCase, least: list[MacroRow], folder: Path, view: str) -> Mapping[Path, str]:
    """A picture of the least mechanism of each part, by what it shows."""
    from reports.drawing.figure import Sheet
    from reports.limit.picture import mechanism_scene

    drawn: dict[Path, str] = {}
    seen: set[str] = set()
    for row in least:
        one = case.parts[row.part].mechanisms[row.number]
        if row.element in seen or one.found is None:
            continue
        seen.add(row.element)
        path = folder / f"{len(seen):02d}_{re.sub('[^a-z0-9]+', '_', row.element.lower()).strip('_')}.png"
        facts = f"push {row.push} · {_named(row.mechanism)} · α0 {row.alpha0:.4g}"
        Sheet.drawn(mechanism_scene(_subject(case, one), f"{case.scene.title}: {row.element}", facts, view)).save(path)
        drawn[path] = row.words
    return drawn


def _named(mechanism: str) -> str:
    """A mechanism without the counts of its joints, of which a picture shows some only and counts those."""
    return FREE if mechanism.startswith(FREE) else mechanism


def _under(case: MacroCase, moves: Mechanism) -> np.ndarray:
    """Blocks at rest under joints at work, whose hinges and slips would not be seen without them."""
    joints = case.joints
    works, up = moves.state > 0, joints.normal[:, 2]
    lower = np.where(up > BED, joints.block_a, np.where(up < -BED, joints.block_b, -1))
    upper = joints.block_a + joints.block_b - lower
    some = np.flatnonzero(works & (lower >= 0))
    return np.unique(lower[some][moves.moving[upper[some]] & ~moves.moving[lower[some]]])


def _subject(case: MacroCase, one: PartMechanism) -> Subject:
    """The blocks of a part, those that move with it and those on which they stand, in their mechanism; what else is held would hide them.

    Without forces.
    """
    from reports.limit.picture import Subject

    assert one.found is not None
    moves, joints = one.found.mechanism, case.joints
    shown = np.union1d(np.union1d(one.element.blocks, np.flatnonzero(moves.moving)), _under(case, moves))
    number = np.full(case.assembly.count, -1)
    number[shown] = np.arange(len(shown))
    between = np.flatnonzero((number[joints.block_a] >= 0) & (number[joints.block_b] >= 0))
    corners = [np.arange(joints.polygon_start[j], joints.polygon_start[j + 1]) for j in between]
    some = Joints(
        number[joints.block_a[between]], number[joints.block_b[between]], joints.area[between], joints.normal[between],
        np.cumsum([0, *map(len, corners)]), joints.polygon[np.concatenate([*corners, np.zeros(0, dtype=np.int64)])],
    )  # fmt: skip
    of_joints = ("opening", "least_opening", "sliding", "rotation", "hinge", "state", "closing")
    part = replace(
        moves, velocity=moves.velocity[shown], speed=moves.speed[shown], **{name: getattr(moves, name)[between] for name in of_joints}
    )
    nothing = np.zeros(some.count)
    collapse = Collapse(part, nothing, nothing, np.full((some.count, 3), np.nan), np.zeros(0), np.full(some.count, np.nan))
    return Subject(collapse, [case.assembly.blocks[b] for b in shown], some)
