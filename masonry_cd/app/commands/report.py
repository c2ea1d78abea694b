# SPDX-License-Identifier: GPL-3.0-or-later
"""The reports of a run, redone: what ``masonry-cd report`` does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.analysis.outputs.measured import in_short
from masonry_cd.app.closing_lines import damage_line, part_lines, verdict_lines
from masonry_cd.app.folders import is_run, names_of_run
from masonry_cd.app.result import Result
from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.io.results import Results
from masonry_cd.io.summary import NAME, Newer, Summary, read_summary


def report(
    folder: Path,
    settings: Mapping[str, Any],
    *,
    crack_map: bool = True,
    time: float | None = None,
    times: str | None = None,
    energy: bool = False,
    stress_map: bool = False,
    page: bool = False,
    pdf: bool = False,
) -> Result[Summary]:
    """Redo the reports of a run from its result.h5.

    Args:
        folder: of the run.
        settings: keys of [report] that are others than the scene's; None: the scene's.
        crack_map: draw it, at ``time``.
        time: of the frame that is drawn [s]; the last by default.
        times: a map at each of these, "1,2,3" [s].
        energy: draw it.
        stress_map: draw it, at ``time`` or of the whole run.
        page: write it.
        pdf: print it as well.

    Raises:
        InputError: no run, settings that do not fit it, or a library that is missing.
    """
    if crack_map or times is not None or stress_map or settings.get("animation") or settings.get("vector"):
        require("a picture", "pyvista", "matplotlib", "PIL", without=" (or go without: --no-crack-map)")
    if page or pdf:
        require("the page", "matplotlib")
    from reports import damage as damage_files
    from reports import outputs
    from reports.files import Job
    from reports.settings import report_of

    with Results.open(folder / "result.h5") as results:
        made = report_of(results.tables, **settings, **({"energy": True} if energy else {}))
        outputs.check_again(made, results)
        chosen = outputs.parse_times(results, times) if times is not None else []
        made = made.model_copy(update={"times": tuple(chosen)})
        own_files.begin(folder, set(names_of_run()) - {NAME}, is_run)  # a damaged summary.json is replaced
        summary, words = _summary_of(results, folder)
        summary |= damage_files.write_joint_damage(results, folder, made)
        wanted = {"damage": True, "crack_map": crack_map, "stress": stress_map or results.has_stress, "stress_map": stress_map}
        job = Job(results, folder, made, summary, time, wanted | {"html": page or pdf, "pdf": pdf})
        lines = [*verdict_lines(summary), damage_line(summary), *part_lines(in_short(job.damage.parts))]
        written = [folder / "joints.csv", *job.write()]
        if not (folder / NAME).exists() and results.closing is not None:
            job.summary.write(folder)
            written.append(folder / NAME)
        return Result(summary, lines, [*results.words, *words], written)


def _summary_of(results: Results, folder: Path) -> tuple[Summary, list[str]]:
    """summary.json of a run, or what its results hold of it where a kill came before it was written; and lines on what is damaged.

    Raises:
        InputError: one of a newer format.
    """
    words, known = list[str](), results.closing
    try:
        found = read_summary(folder)
    except Newer:
        raise
    except InputError as reason:
        found, words = None, [f"{reason}; {'the report is written without it' if known is None else 'it is written again'}"]
        if known is not None:
            (folder / NAME).unlink()
    return found or known or Summary(), words
