# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``masonry-cd limit`` writes of a structure as a whole: tables, pictures, page."""

from __future__ import annotations

from pathlib import Path

from masonry_cd.app.limit_case import EVERY, LimitCase, found_lines, summary
from masonry_cd.app.limit_curve import curve_lines, draw_curve, write_curve
from masonry_cd.app.limit_vehicle import write_crossing
from masonry_cd.foundation import own_files
from masonry_cd.foundation.quantities import force


def write(case: LimitCase, folder: Path, pictures: bool = True, view: str = "auto") -> list[Path]:
    """Write limit.json, the tables, the pictures and the page into a folder, which is made if need be.

    Raises:
        InputError: an unknown view, no off-screen OpenGL for the pictures; the tables are written by then.
    """
    from masonry_cd.foundation.json_files import write_json
    from reports.limit.page import LimitPage, write_limit_page
    from reports.limit.tables import write_check, write_limit_ties, write_tables

    own_files.begin(folder, EVERY)
    own_files.remove(folder, EVERY)
    facts = summary(case)
    write_json(folder / "limit.json", facts)
    collapse = case.collapse
    written = [folder / "limit.json", *write_tables(collapse, case.assembly, case.joints, folder), *write_limit_ties(case.ties, folder)]
    if case.check is not None:
        write_json(folder / "check.json", case.check.numbers())
        write_check(case.check.numbers(), folder / "check.csv")
        written += [folder / "check.json", folder / "check.csv"]
    if case.crossing is not None:
        written += write_crossing(case.crossing, folder, case.scene.title, pictures)
    drawn = draw(case, folder, view) if pictures else []
    if case.curve is not None:
        written += write_curve(case.curve, case.assembly.names, folder)
    of_curve = [] if case.curve is None else curve_lines(case.curve, case.assembly.names)
    options = ["--curve"] if case.curve is not None and "curve" not in case.scene.limit else []
    found = [*found_lines(case), *of_curve]
    page = LimitPage(facts, found, case.scene.text, options, case.scene.report.model_dump(exclude_unset=True))
    write_limit_page(page, drawn, folder / "limit.html")
    return [*written, *drawn, folder / "limit.html"]


def draw(case: LimitCase, folder: Path, view: str = "auto") -> list[Path]:
    """Draw the mechanism, the forces of a structure that stands, and its capacity curve where one was followed, into a folder.

    Raises:
        InputError: an unknown view, no off-screen OpenGL.
    """
    from reports.drawing.figure import Sheet
    from reports.limit.picture import Subject, mechanism_scene, thrust_scene

    what, facts = Subject(case.collapse, case.assembly.blocks, case.joints, case.ties), _facts(case)
    Sheet.drawn(mechanism_scene(what, f"{case.scene.title}: mechanism", facts, view)).save(folder / "mechanism.png")
    if not case.analysis.stands:
        return [folder / "mechanism.png"]
    Sheet.drawn(thrust_scene(what, f"{case.scene.title}: forces at collapse", facts, view)).save(folder / "thrust.png")
    curve = [draw_curve(case.curve, case.assembly.names, folder, (case.scene.title, case.loads.words), view)] if case.curve else []
    return [folder / "mechanism.png", folder / "thrust.png", *curve]


def _facts(case: LimitCase) -> str:
    """The line below the title of a picture."""
    analysis = case.analysis
    if not analysis.stands:
        return "does not stand under its dead loads"
    if analysis.endless:
        return f"{case.loads.words}: no finite load factor; the forces are those under the dead loads"
    if analysis.problem.moves_support:
        return f"{case.loads.words}: the supports still bear {force(-analysis.associated.factor * analysis.problem.weight)}"
    if analysis.bears_nothing:
        return f"{case.loads.words}: no load factor, the least of this load sets it in motion"
    least = f" · least found without dilation {analysis.least.optimum.factor:.4g}, drawn" if analysis.least else ""
    upper = "no finite associated load factor" if analysis.unlimited else f"load factor {analysis.associated.factor:.4g} (associated)"
    return f"{case.loads.words} · {upper}{least}"
