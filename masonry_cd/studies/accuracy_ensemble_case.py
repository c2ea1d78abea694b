# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd accuracy SCENE --ensemble N``: run the ensembles, write their tables and picture, and say which setting is good enough."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from masonry_cd import __version__
from masonry_cd.app.case import prepare
from masonry_cd.app.inputs import file_digests
from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.foundation.files import is_file
from masonry_cd.foundation.quantities import in_words, length
from masonry_cd.io.lock import locked
from masonry_cd.studies.accuracy_case import markdown, numbers_asked, solvers_asked, tolerances_asked, write_rows
from masonry_cd.studies.accuracy_ensemble import (
    LEAST,
    LENGTHS,
    MATTERS,
    MEASURES,
    PERTURBED,
    SHOWN,
    TOLERANCES,
    EnsembleRow,
    ensemble_rows,
    good_enough,
    run_member,
    settings_of,
)
from masonry_cd.studies.kept_runs import KeptRuns
from masonry_cd.studies.study.folder import digest_of

OUTPUTS = ("accuracy.csv", "accuracy.json", "accuracy.md", "accuracy.png", "members.csv")
KEPT = "runs.jsonl"  # what has ended

Say = Callable[[str], None]


def ensemble_case(source: Path, asked: Mapping[str, Any], overrides: Sequence[str], folder: Path, say: Say) -> dict[str, Any]:
    """Measure a scene by ensembles and write the outputs into a folder, which is made if need be.

    Args:
        source: a scene (TOML).
        asked: ``solvers``, ``tolerances``, ``dts`` as typed or None; ``duration`` or None; ``ensemble``, ``workers``; ``force`` to begin
            anew where the folder holds runs of the scene, which are continued otherwise.
        overrides: changes to the scene, ``key=value``.
        folder: for the outputs.
        say: called with a line on how far it is.

    Returns:
        ``lines`` to print, ``warnings`` and the paths ``written``.

    Raises:
        InputError: a bad scene or option; nothing is written then.
    """
    require("the picture of accuracy", "matplotlib")  # before the runs
    if not is_file(source):
        raise InputError(source, "no such file")
    if source.suffix != ".toml":
        raise InputError("--ensemble", f"{source.name} is a friction problem; ensembles are of a scene")
    if asked["ensemble"] < LEAST:
        raise InputError("--ensemble", f"{asked['ensemble']} members show no bias, however large; at least {LEAST} do")
    changes = [*overrides, *([] if asked["duration"] is None else [f"run.duration={asked['duration']!r}"])]
    scene = read_scene(source, changes)
    dts = numbers_asked(asked["dts"], "--dts", 0.1)
    if dts is None and scene.run.adaptive:
        raise InputError(source, 'run.dt is "auto"; name the time steps to compare by --dts')
    solvers = solvers_asked(asked["solvers"]) or (scene.run.solver,)
    settings = settings_of(solvers, dts or (scene.run.dt,), tolerances_asked(asked["tolerances"]) or TOLERANCES)
    for setting in settings:  # what is wrong with one of them is reported before any runs
        read_scene(source, [*changes, f"run.dt={setting.dt!r}", f"run.tolerance={setting.tolerance!r}"])
    prepare(scene)  # what is wrong with its blocks or loads is reported before anything is written, and kernels are compiled once
    with locked(folder):
        own_files.begin(folder, (*OUTPUTS, KEPT), is_ensemble)
        kept = KeptRuns(folder / KEPT, _identity(scene, changes), asked["force"])

        def ended(name: str, found: Mapping[str, Any], left: int) -> None:
            say(f"{name}: {found['seconds']:.3g} s; {left} of {len(settings) * asked['ensemble']} runs left")

        try:
            rows = ensemble_rows(
                source, changes, settings, asked["ensemble"], lambda members: kept.make(run_member, members, asked["workers"], ended)
            )
        except KeyboardInterrupt:
            say(f"the runs that have ended are in {folder / KEPT}; the same command goes on")
            raise
        return _write(scene.title, rows, folder)


def _identity(scene: Scene, changes: Sequence[str]) -> str:
    """What makes runs those of this scene, their time step, tolerance and solver apart."""
    files = file_digests([scene.structure, *scene.structures, *scene.loads], scene.folder)
    return digest_of([__version__, scene.text, list(changes), files])


def is_ensemble(folder: Path) -> bool:
    """Whether a folder that has no list of its files is that of an ensemble of an earlier version: by the runs that it keeps."""
    return (folder / KEPT).is_file()


def _write(title: str, rows: Sequence[EnsembleRow], folder: Path) -> dict[str, Any]:
    """Write the outputs."""
    from masonry_cd.studies.accuracy_ensemble_picture import ensemble_picture

    written = [folder / name for name in OUTPUTS]
    lines, warnings, flat = lines_of(title, rows), _warnings(rows), [_flat(row) for row in rows]
    write_rows(flat, written[0])
    with replacing(written[1]) as part:
        found = {"format": 1, "title": title, "settings": [_plain(row) for row in flat], "lines": lines, "warnings": warnings}
        part.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    sections = [f"# Error against run time, by ensembles: {title}", "", markdown([_for_reading(row) for row in rows])]
    sections += [*(f"- {line}" for line in lines), *(f"- **{line}**" for line in warnings)]
    with replacing(written[2]) as part:
        part.write_text("\n".join(sections) + "\n", encoding="utf-8")
    ensemble_picture(rows, title, written[3])
    every = [row.setting._asdict() | {"member": k} | member for row in rows for k, member in enumerate(row.members)]
    write_rows(every, written[4])
    return {"lines": lines, "warnings": warnings, "written": written}


def _flat(row: EnsembleRow) -> dict[str, Any]:
    """A setting as a row of accuracy.csv."""
    out: dict[str, Any] = row.setting._asdict() | {"members": len(row.members)}
    for key, spread in row.spreads.items():
        out |= {key: spread.median, f"{key}_low": spread.low, f"{key}_high": spread.high}
        out |= {f"{key}_bias": spread.bias, f"{key}_spread": spread.spread, f"{key}_chance": spread.chance}
    low, middle, high = row.quartiles("seconds")
    out |= {"seconds": middle, "seconds_low": low, "seconds_high": high, "steps_missed": sum(m["steps_missed"] for m in row.members)}
    out |= {"collapsed": sum(m["collapsed_blocks"] > 0 for m in row.members), "grades": grades_of(row)}
    return out | {"biased": row.biased, "finest": row.finest}


def _plain(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row as JSON can hold it."""
    return {key: None if isinstance(value, float) and not math.isfinite(value) else value for key, value in row.items()}


def grades_of(row: EnsembleRow) -> str:
    """``3 D1, 5 D2``"""
    grades = [member["grade"] for member in row.members]
    return ", ".join(f"{grades.count(grade)} {grade}" for grade in sorted(set(grades)))


def _for_reading(row: EnsembleRow) -> dict[str, Any]:
    """A setting as a row of accuracy.md: medians, quartiles and chances."""
    out: dict[str, Any] = {"solver": row.setting.solver, "dt [ms]": 1e3 * row.setting.dt, "tolerance": f"{row.setting.tolerance:g}"}
    for key in MEASURES:
        spread, (unit, factor) = row.spreads[key], MEASURES[key].shown
        text = f"{factor * spread.median:.3g} ({factor * spread.low:.3g} to {factor * spread.high:.3g})"
        out[f"{MEASURES[key].name} [{unit}], chance"] = text if row.finest else f"{text}, {spread.chance:.2g}"
    missed = sum(member["steps_missed"] for member in row.members) / max(1, sum(member["steps"] for member in row.members))
    return out | {"grades": grades_of(row), "steps missed [%]": 100.0 * missed, "CPU per run [s]": row.seconds}


def lines_of(title: str, rows: Sequence[EnsembleRow]) -> list[str]:
    """The ensembles in words, the last line says which setting is good enough."""
    finest, count, best = rows[-1], len(rows[0].members), good_enough(rows)
    seen = 1.96 * math.sqrt(2.0 / count)
    lines = [
        f"{title}: {len(rows)} settings of {count} members, whose amplitudes differ by {PERTURBED:g}",
        "; ".join([f"finest, {finest.setting}", *(_spread(finest, key) for key in LENGTHS), f"{in_words(finest.seconds)} of CPU a run"]),
    ]
    lines += [_bias_line(row) for row in rows[:-1]]
    lines.append(
        f"a bias shows where the chance is below {SHOWN:g} and it is more than {100 * MATTERS:g} %; {count} members miss one of {seen:.1f} "
        "standard deviations every other time"
    )
    if best is finest:
        lines.append(f"good enough: only the finest, {finest.setting}; all others show a bias" if len(rows) > 1 else "one setting: no bias")
        return lines
    costs = f"{in_words(best.seconds)} of the processor a run, where the finest takes {in_words(finest.seconds)}"
    return [*lines, f"good enough: {best.setting}: no bias shows, {costs}"]


def _spread(row: EnsembleRow, key: str) -> str:
    """``largest opening 2 mm (1.8 mm to 2.1 mm)``"""
    found = row.spreads[key]
    return f"{MEASURES[key].name} {length(found.median)} ({length(found.low)} to {length(found.high)})"


def _bias_line(row: EnsembleRow) -> str:
    """Where a setting is biased, and how that compares with its spread."""
    shown = [(MEASURES[key], spread) for key, spread in row.spreads.items() if spread.biased]
    if not shown:
        return f"{row.setting}: no bias shows"
    found = [
        f"{number.name} {'+' if spread.bias > 0 else '-'}{length(abs(spread.bias))}"
        if number.unit
        else f"{number.name} {100.0 * spread.bias:+.2g} %"
        for number, spread in shown
    ]
    larger = sum(not spread.within for _, spread in shown)
    words = "more than its spread" if larger == len(shown) else "less than its spread" if not larger else f"{larger} beyond their spread"
    return f"{row.setting}: a bias shows, {', '.join(found)}, {words}"


def _warnings(rows: Sequence[EnsembleRow]) -> list[str]:
    """Settings that missed their tolerance."""
    out = []
    for row in rows:
        missed, steps = (sum(member[key] for member in row.members) for key in ("steps_missed", "steps"))
        if missed:
            largest = max(member["error_max"] for member in row.members)
            out.append(f"{row.setting}: {missed} of {steps} steps missed the tolerance, the largest error is {largest:.1e}")
    return out
