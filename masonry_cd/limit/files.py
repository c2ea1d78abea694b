# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of ``masonry-cd limit``: limit.json, tables, pictures and the page with all of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.foundation import own_files
from masonry_cd.foundation.json_files import write_json
from masonry_cd.limit.curve import curve_lines, write_curve
from masonry_cd.limit.facts import facts
from masonry_cd.limit.kept import NAME
from masonry_cd.limit.vehicle import write_crossing
from masonry_cd.limit.words import found_lines
from reports.limit.page import LimitPage, damage_by_group, write_limit_page
from reports.limit.tables import write_check, write_limit_ties, write_mechanisms, write_tables

if TYPE_CHECKING:
    from masonry_cd.limit.case import LimitCase
    from masonry_cd.limit.whole import WholeAnalysis

EVERY = files_of("limit")  # that a folder of an analysis may hold


def write(case: LimitCase, folder: Path, pictures: bool = True, view: str = "auto", run: Path | None = None) -> list[Path]:
    """Write limit.json, the tables, the pictures and the page into a folder, which is created if missing.

    Args:
        case: the analysis.
        folder: for the files.
        pictures: draw them.
        view: of the pictures.
        run: the folder of a run, whose damage stands next to the parts.

    Raises:
        InputError: an unknown view, no off-screen OpenGL for the pictures, a run without damage.csv; the tables are written by then.
    """
    from masonry_cd.limit.pictures import PARTS, draw_parts, draw_spectra, draw_whole

    damage = {} if run is None else _damage(case, run)
    own_files.begin(folder, EVERY)
    own_files.remove(folder, (name for name in EVERY if name != NAME))
    if case.parts or (folder / PARTS).exists():
        own_files.begin(folder / PARTS, ("*.png",))
        own_files.remove(folder / PARTS, ("*.png",))
    found, whole = facts(case), case.whole
    write_json(folder / "limit.json", found)
    written = [folder / "limit.json", *write_mechanisms(found["mechanisms"], folder)]
    if whole is not None:
        written += [*write_tables(whole.collapse, whole.assembly, whole.joints, folder), *write_limit_ties(whole.ties, folder)]
    if found["check"] is not None:
        write_json(folder / "check.json", found["check"])
        write_check(found["check"], folder / "check.csv")
        written += [folder / "check.json", folder / "check.csv"]
    if case.crossing is not None:
        written += write_crossing(case.crossing, folder, case.scene.title, pictures)
    drawn: dict[Path, str] = {}
    if pictures:
        drawn |= {} if whole is None else dict.fromkeys(draw_whole(whole, case.scene.title, folder, view), "")
        drawn |= dict.fromkeys(draw_spectra(case, folder), "")
        drawn |= draw_parts(case, folder / PARTS, view)
    if whole is not None and whole.curve is not None:
        written += write_curve(whole.curve, whole.assembly.names, folder)
    page = LimitPage(
        found, [*found_lines(case), *_curve_lines(whole)], case.scene.text, _options(case),
        case.scene.report.model_dump(exclude_unset=True), damage,
    )  # fmt: skip
    write_limit_page(page, drawn, folder / "limit.html")
    return [*written, *drawn, folder / "limit.html"]


def _curve_lines(whole: WholeAnalysis | None) -> list[str]:
    return [] if whole is None or whole.curve is None else curve_lines(whole.curve, whole.assembly.names)


def _options(case: LimitCase) -> list[str]:
    """The options of the command in addition to what the scene asks for."""
    curve = case.whole is not None and case.whole.curve is not None and "curve" not in case.scene.limit
    return [*(["--curve"] if curve else []), *(["--macro-elements"] if case.wanted.parts else [])]


def _damage(case: LimitCase, run: Path) -> dict[str, str]:
    """The damage of a run to the groups of each part, by its name."""
    known, assembly, out = damage_by_group(run), case.structure.assembly, {}
    for part in case.parts:
        groups = [assembly.groups[g] for g in sorted(set(assembly.group_of[part.element.blocks].tolist()))]
        out[part.element.name] = ", ".join(f"{group} {known[group]}" for group in groups if group in known)
    return out
