# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd select``: a set of records that matches the spectrum of a site, for studies to take.

selected.toml   the table [records] of a study, with a factor for each record of the set
selection.csv   a row for each of them          selection.json   the set in numbers, and what was left out and why
selection.png   its spectra and the target
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.analysis.record_sets import Pool, choose
from masonry_cd.app.folders import free_folder
from masonry_cd.app.result import Result, Say, silent
from masonry_cd.app.scene_text import dump_toml, toml_key
from masonry_cd.foundation import libm, own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.json_files import plain, write_json
from masonry_cd.studies.selection.candidates import Candidate, ChosenSet, Grid, find
from masonry_cd.studies.selection.catalogue import COLUMNS, EVENT
from masonry_cd.studies.selection.picture import draw
from masonry_cd.studies.selection.tables import Selection

DIGITS = 6
MOST_NAMED = 10  # motions left out that lines name; selection.json has all


def select(selection: Selection, folder: Path | None, force: bool = False, say: Say = silent) -> Result[dict[str, Any]]:
    """Choose a set of records, and write it into a folder.

    Args:
        selection: whose tables are checked.
        folder: created if missing; nothing is written where there is none.
        force: overwrite the files that are there.
        say: called with lines while records are read.

    Returns:
        what selection.json holds, and ``records``, the table for a study.

    Raises:
        InputError: a folder that holds results, no records, too few that may be chosen.
    """
    if folder is not None:
        free_folder(folder, files_of("select"), force)
    with selection.origin.locating():
        grid = Grid.of(selection)
        candidates, left = find(selection, grid, say)
        made = _chosen(selection, grid, candidates, left)
    found, place = _summary(selection, made, left), (selection.path.parent / selection.given["folder"]).resolve()
    records = {**selection.given, "folder": str(place), "factors": {row["motion"]: row["factor"] for row in made.rows()}}
    if folder is not None:
        own_files.begin(folder, files_of("select"))
        _write_records(records, folder)
        write_csv(folder / "selection.csv", found["motions"][0], (row.values() for row in found["motions"]), DIGITS)
        write_json(folder / "selection.json", found, 2 * DIGITS)
        draw(selection, made, folder / "selection.png")
    written = [] if folder is None else [folder / name for name in files_of("select")]
    return Result(found | {"records": records}, [*_lines(selection, made, left)], _warnings(selection, made), written)


def _chosen(selection: Selection, grid: Grid, candidates: list[Candidate], left: Mapping[str, str]) -> ChosenSet:
    """The best set, scaled up where that is required.

    Raises:
        InputError: too few candidates.
    """
    tables, asked, periods = selection.tables, selection.tables.candidates, grid.periods[grid.compared]
    names = [str(one.row[EVENT]) if asked.per_event else one.name for one in candidates]
    most = sum(min(names.count(name), asked.per_event or 1) for name in {*names})
    if most < tables.n:
        why = "; ".join(f"{name}: {reason}" for name, reason in list(left.items())[:MOST_NAMED])
        text = f"{tables.n} records are required, and {most} of {len(candidates) + len(left)} may be chosen"
        raise InputError(
            "n", text + (f" with {asked.per_event} of an event at most" if asked.per_event else "") + (f": {why}" if why else "")
        )
    logs = libm.log(np.array([one.spectrum[grid.compared] for one in candidates]) / grid.target[grid.compared])
    least, most_scaled = libm.log(np.array(asked.factor))
    events = np.unique(names, return_inverse=True)[1]
    pool = Pool(periods, logs, tables.target.deviations(periods), (least, most_scaled), events, asked.per_event or 1)
    best = choose(pool, tables.n, tables.seed)
    order = np.argsort(best.members)
    made = ChosenSet(grid, [candidates[k] for k in best.members[order]], libm.exp(best.factors[order]), 1.0, len(candidates))
    lift = max(1.0, made.rule.lift) if tables.meet_rule else 1.0
    return replace(made, factors=lift * made.factors, lift=lift)


def _summary(selection: Selection, made: ChosenSet, left: Mapping[str, str]) -> dict[str, Any]:
    """Return the contents of selection.json."""
    tables, d, rule = selection.tables, made.differences, made.rule
    spectra = {"period_s": made.grid.periods, "target_m_s2": made.grid.target, "mean_m_s2": made.spectra.mean(axis=0)}
    spectra |= {"median_m_s2": made.grid.target * libm.exp(d.mean(axis=0))} | ({"sigma": d.std(axis=0, ddof=1)} if len(d) > 1 else {})
    found = {"title": selection.title, "n": tables.n, "seed": tables.seed, "candidates": made.pool, "lift": made.lift}
    found |= {"target": tables.target.model_dump(exclude_none=True), "band_s": tables.target.band, "fit": made.fit(tables.target)}
    found |= {
        "en_1998_1": {"holds": all(rule.holds), **asdict(rule)},
        "motions": [*made.rows()],
        "left_out": dict(left),
        "spectra": spectra,
    }
    return dict(plain(found))


def _write_records(records: Mapping[str, Any], folder: Path) -> None:
    """Write the table for a study, whose folder is relative to the file."""
    place = Path(os.path.relpath(records["folder"], folder.resolve())).as_posix()
    keys = dump_toml({"records": {key: value for key, value in records.items() if key != "factors"} | {"folder": place}})
    factors = "".join(f"{toml_key(motion)} = {factor!r}\n" for motion, factor in records["factors"].items())
    with replacing(folder / "selected.toml") as part:
        part.write_text(f'# in a study: records = "DIR/selected.toml"\n{keys}\n[records.factors]\n{factors}', encoding="utf-8")


def _lines(selection: Selection, made: ChosenSet, left: Mapping[str, str]) -> Iterator[str]:
    """The closing lines."""
    target = selection.tables.target
    fit, (low, high) = made.fit(target), target.band
    yield f"{selection.title}: {len(made.members)} of {made.pool} motions, for Sa ({target.of}) from {low:g} to {high:g} s"
    for row in made.rows():
        about = "".join(f", {name} {row[name]}" for name in COLUMNS.values() if row[name] is not None)
        yield f"  {row['motion']}: factor {row['factor']:.4g}, misfit {row['misfit']:.3f}, PGA {row['pga_m_s2']:.3g} m/s2{about}"
    yield f"mean of ln Sa less that of the target: rms {fit['mean_rms']:.3f}, largest {fit['mean_largest']:+.3f} at {fit['at_s']:.3g} s"
    if fit["sigma"] is not None:
        wanted = "" if fit["sigma_rms"] is None else f"; less what is required: rms {fit['sigma_rms']:.3f}"
        yield f"standard deviation of ln Sa: {fit['sigma']:.3f} on average{wanted}"
    yield from made.rule.lines()
    if left:
        yield f"left out: {len(left)} motions"
        yield from [f"  {name}: {why}" for name, why in left.items()][:MOST_NAMED]
    if len(left) > MOST_NAMED:
        yield f"  and {len(left) - MOST_NAMED} more, all in selection.json"


def _warnings(selection: Selection, made: ChosenSet) -> list[str]:
    """Return the warnings."""
    out, most = [], selection.tables.candidates.factor[1]
    if made.lift > 1.0:
        out.append(f"all factors are raised by {made.lift:.4g}, so that the set meets EN 1998-1, 3.2.3.1.2(4) b) and c)")
    if made.factors.max() > most * (1.0 + 1e-9):
        out.append(f"the largest factor is then {made.factors.max():.4g}, above {most:g} (candidates.factor)")
    return out
