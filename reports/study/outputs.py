# SPDX-License-Identifier: GPL-3.0-or-later
"""What a study's folder gets from the reports: tables, pictures and the page, as far as its design and its runs allow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.fragility.fits import Fit, Fits, fit_study
from masonry_cd.analysis.fragility.folder import Study, read_study
from masonry_cd.analysis.fragility.sensitivity import Correlation, correlations
from masonry_cd.analysis.fragility.verdict import verdict_of
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.foundation.errors import InputError
from reports.study.fragility_picture import fragility_picture
from reports.study.joint_maps import draw_joint_maps
from reports.study.page import PAGE, Said, write_page
from reports.study.run_pictures import cloud_picture, ida_picture, quantities_of, spread_picture, stripes_picture
from reports.study.tables import (
    first_fits,
    row_of,
    write_fragility_csv,
    write_fragility_json,
    write_json,
    write_openquake,
    write_sensitivity,
)
from reports.study.tornado_picture import tornado_picture
from reports.study.words import counts, lines_of, spreads, warnings_of

MADE = ("runs.csv", "runs.parquet", "limits.csv")  # by the study itself, run by run
FILES = tuple(name for name in files_of("study") if name not in MADE)
MAPS = "probability_*.png"


@dataclass(eq=False)
class Written:
    """What has been written, and what there is to say of it."""

    pictures: list[Path] = field(default_factory=list)
    tables: list[Path] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


def write_study(folder: Path) -> dict[str, Any]:
    """Fit, draw and write all that a study's design and its runs allow; what an earlier call wrote and this one does not is removed.

    Args:
        folder: of a study: study.json, runs.csv, and, for the maps, joints/ and reference/.

    Returns:
        what summary.json holds, with ``lines`` and ``warnings``.

    Raises:
        InputError: something in the folder is missing or broken.
    """
    study = read_study(folder)
    fits, rows = fit_study(study), correlations(study)
    for path in [folder / name for name in FILES] + sorted(folder.glob(MAPS)):
        path.unlink(missing_ok=True)
    out = Written(lines=lines_of(study, fits.fits, rows), warnings=[*warnings_of(study), *fits.warnings])
    _write_tables(study, fits, rows, out)
    _draw(study, fits, rows, out)
    _draw_maps(study, out)
    summary = _summary(study, fits.fits, rows, out)
    found = verdict_of(study, fits.fits)
    write_page(study, fits.fits, out.pictures, Said(found, out.lines, out.warnings))
    summary = {"format": summary["format"], "verdict": found.as_dict()} | summary
    write_json(folder / "summary.json", summary)
    return summary


def _write_tables(study: Study, fits: Fits, rows: Sequence[Correlation], out: Written) -> None:
    """fragility.csv, .json and .xml, sensitivity.csv."""
    folder = study.folder
    if fits.fits:
        write_fragility_csv(folder / "fragility.csv", fits.fits)
        write_fragility_json(folder / "fragility.json", fits)
        out.tables += [folder / "fragility.csv", folder / "fragility.json"]
        out.warnings += write_openquake(folder / "fragility.xml", str(study.asked["title"]), fits.fits)
        out.tables += [path for path in (folder / "fragility.xml",) if path.exists()]
    if rows:
        write_sensitivity(folder / "sensitivity.csv", rows)
        out.tables.append(folder / "sensitivity.csv")


def diagrams(study: Study, fits: Fits, rows: Sequence[Correlation]) -> dict[str, Callable[[Path], None]]:
    """The diagrams that a study's design and its runs allow: of each its file's name, and what draws it there."""
    title, quantities = str(study.asked["title"]), quantities_of(study)
    levels = study.numbers("level")[study.done]
    in_stripes = study.asked["design"] != "ida" and len(np.unique(levels[np.isfinite(levels)])) > 1
    drawn = any(fit.runs for fit in fits.fits)
    known: list[tuple[str, bool, Callable[[Path], None]]] = [
        ("fragility.png", drawn, lambda path: fragility_picture([fit for fit in fits.fits if fit.runs], f"{title}: fragility", path)),
        ("ida.png", bool(fits.curves and quantities), lambda path: ida_picture(study, fits.curves, path)),
        ("cloud.png", bool(fits.clouds), lambda path: cloud_picture(study, fits.clouds, path)),
        ("stripes.png", in_stripes and bool(quantities), lambda path: stripes_picture(study, path)),
        ("spread.png", not drawn and not in_stripes and bool(quantities), lambda path: spread_picture(study, path)),
        ("tornado.png", bool(rows), lambda path: tornado_picture(rows, title, path)),
    ]
    return {name: draw for name, allowed, draw in known if allowed}


def _draw(study: Study, fits: Fits, rows: Sequence[Correlation], out: Written) -> None:
    """The diagrams."""
    for name, draw in diagrams(study, fits, rows).items():
        draw(study.folder / name)
        out.pictures.append(study.folder / name)


def _draw_maps(study: Study, out: Written) -> None:
    """The maps of the joints; without off-screen OpenGL, a warning."""
    try:
        written, lines, warnings = draw_joint_maps(study)
    except InputError as failure:
        if "OpenGL" not in str(failure):
            raise
        out.warnings.append(str(failure))
        return
    out.pictures += [path for path in written if path.suffix == ".png"]
    out.tables += [path for path in written if path.suffix != ".png"]
    out.lines += lines
    out.warnings += warnings


def _summary(study: Study, fits: Sequence[Fit], rows: Sequence[Correlation], out: Written) -> dict[str, Any]:
    """What summary.json holds."""
    return {
        "format": 1,
        "title": study.asked["title"],
        "design": study.asked["design"],
        "measure": study.asked["measure"],
        "runs": counts(study),
        "records": len(study.motions),
        "collapsed": int((study.collapsed & study.done).sum()),
        "fragility": [row_of(fit) | dict(fit.betas.as_dict()) for fit in first_fits(fits)],
        "spread": spreads(study),
        "sensitivity": [row._asdict() for row in rows if row.kind == "varied"],
        "files": [path.name for path in (*out.tables, *out.pictures)] + [PAGE],
        "lines": out.lines,
        "warnings": out.warnings,
    }
