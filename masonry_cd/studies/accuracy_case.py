# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd accuracy``: measure, write accuracy.csv, accuracy.md and accuracy.png, and say what came out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.app.scene import read_scene
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.extras import require
from masonry_cd.foundation.files import is_file
from masonry_cd.foundation.quantities import in_words

OUTPUTS = ("accuracy.csv", "accuracy.md", "accuracy.png")
PROBLEM_REPEATS, SCENE_REPEATS = 5, 1

Say = Callable[[str], None]


def accuracy_case(source: Path, asked: Mapping[str, Any], overrides: Sequence[str], folder: Path, say: Say) -> dict[str, Any]:
    """Measure a problem file or a scene and write the outputs into a folder, which is made if need be.

    Args:
        source: .npz or FCLIB HDF5, or a scene (TOML).
        asked: ``solvers``, ``tolerances``, ``dts`` as typed or None; ``repeats``, ``duration`` or None.
        overrides: changes to a scene, ``key=value``.
        folder: for the outputs.
        say: called with a line on how far it is.

    Returns:
        ``lines`` to print, ``warnings`` and the paths ``written``.

    Raises:
        InputError: a bad file, scene or option; nothing is written then.
    """
    require("the picture of accuracy", "matplotlib")  # before the runs
    if not is_file(source):
        raise InputError(source, "no such file")
    measured = _scene(source, asked, overrides, say) if source.suffix == ".toml" else _problem(source, asked, overrides, say)
    return _write(measured, folder)


def _problem(source: Path, asked: Mapping[str, Any], overrides: Sequence[str], say: Say) -> dict[str, Any]:
    """Measure the solvers on a problem file."""
    for option, given in (("--dts", asked["dts"]), ("--duration", asked["duration"]), ("--set", overrides)):
        if given:
            raise InputError(option, f"{source.name} is a friction problem; time steps and changes are for a scene")
    solvers, tolerances = solvers_asked(asked["solvers"]), tolerances_asked(asked["tolerances"])
    from masonry_cd.io.problem_files import read_problem
    from masonry_cd.studies.accuracy import PROBLEM_TOLERANCES, solver_rows, solvers_for

    problem = read_problem(source)
    names = solvers_for(problem, solvers)
    rows = solver_rows(problem, names, tolerances or PROBLEM_TOLERANCES, asked["repeats"] or PROBLEM_REPEATS, say)
    lines = [f"{source.name}: {problem.contacts} contacts, errors by the natural map, median times"]
    lines += [_best(name, [row for row in rows if row.solver == name]) for name in names]
    if solvers is None and "interior" not in names:
        lines.append("interior: left out, it needs a problem over bodies")
    if solvers is None and "pivoting" not in names:
        lines.append("pivoting: left out, it needs a problem over bodies in a plane")
    return {"kind": "problem", "title": source.name, "rows": rows, "lines": lines, "warnings": []}


def _best(name: str, rows: Sequence[Any]) -> str:
    """What one solver reached."""
    last = rows[-1]
    cost = f"{1e3 * last.seconds:.3g} ms, {last.iterations} iterations"
    if last.reached:
        return f"{name}: reached all, the tightest, {last.tolerance:g}, with an error of {last.error:.1e} in {cost}"
    return f"{name}: missed {last.tolerance:g} with an error of {last.error:.1e} in {cost}; tighter ones would end there too"


def _scene(source: Path, asked: Mapping[str, Any], overrides: Sequence[str], say: Say) -> dict[str, Any]:
    """Measure the runs of a scene."""
    changes = [*overrides, *([] if asked["duration"] is None else [f"run.duration={asked['duration']!r}"])]
    scene = read_scene(source, changes)
    if scene.run.adaptive:
        raise InputError(source, 'run.dt is "auto", and accuracy compares fixed time steps; give it a scene with a number there')
    solvers, tolerances = solvers_asked(asked["solvers"]) or (scene.run.solver,), tolerances_asked(asked["tolerances"])
    from masonry_cd.studies.accuracy import DT_FACTORS, SCENE_TOLERANCES, run_rows

    dts = numbers_asked(asked["dts"], "--dts", 0.1) or tuple(factor * scene.run.dt for factor in DT_FACTORS)
    rows = run_rows(source, changes, solvers, dts, tolerances or SCENE_TOLERANCES, asked["repeats"] or SCENE_REPEATS, say)
    return {"kind": "scene", "title": scene.title, "rows": rows, "lines": _run_lines(scene.title, rows), "warnings": _run_warnings(rows)}


def _run_lines(title: str, rows: Sequence[Any]) -> list[str]:
    """The runs in words: the finest, the fastest, and how the error falls with the time step."""
    reference, runs = rows[0], rows[1:]
    finest = min(runs, key=lambda row: (row.tolerance, row.dt))
    fastest = min(runs, key=lambda row: row.stepping_seconds)
    lines = [f"{title}: {len(runs)} runs against dt {reference.dt:g} s, tolerance {reference.tolerance:g} ({reference.solver})"]
    for name, row in (("finest", finest), ("fastest", fastest)):
        lines.append(
            f"{name}, dt {row.dt:g} s, tolerance {row.tolerance:g}: displacements within {100 * row.displacement_error:.2g} %, openings "
            f"within {100 * row.opening_error:.2g} %, stepping {in_words(row.stepping_seconds)}"
        )
    lines.append("the reference itself may be as far off as the finest run")
    order = _order([row for row in runs if row.tolerance == finest.tolerance and row.solver == reference.solver])
    if order is not None:
        falls = f"falls as dt to the {order:.2g}" if order > 0.2 else "does not fall with dt over this range"
        lines.append(f"at tolerance {finest.tolerance:g} the displacement error {falls}")
    return lines


def _order(rows: Sequence[Any]) -> float | None:
    """Slope of log error over log dt, by least squares; None with fewer than three runs or an error of nothing."""
    if len(rows) < 3 or min(row.displacement_error for row in rows) <= 0.0:
        return None
    steps, errors = (np.log([getattr(row, key) for row in rows]) for key in ("dt", "displacement_error"))
    return float(np.polyfit(steps, errors, 1)[0])


def _run_warnings(rows: Sequence[Any]) -> list[str]:
    """Runs that missed their tolerance or broke off."""
    broken = [row for row in rows if not row.reached]
    out = []
    for row in broken:
        what = f"{row.steps_missed} of {row.steps} steps missed it" if row.steps_missed else f"the run broke off after {row.steps} steps"
        name = "the reference" if row.reference else f"{row.solver}, dt {row.dt:g} s"
        out.append(f"{name}, tolerance {row.tolerance:g}: {what}, the largest error is {row.error_max:.1e}")
    return out


# --- options --------------------------------------------------------------------------------------------------------------------


def solvers_asked(text: str | None) -> tuple[str, ...] | None:
    """Solvers as typed, in that order."""
    if text is None:
        return None
    from masonry_cd.mechanics.solvers import SOLVERS

    names = [word.strip() for word in text.split(",")]
    for name in names:
        if name not in SOLVERS:
            raise InputError("--solvers", f'"{name}" is unknown{suggest(name, SOLVERS)}; known are {", ".join(SOLVERS)}')
    return tuple(dict.fromkeys(names))


def tolerances_asked(text: str | None) -> tuple[float, ...] | None:
    """Tolerances as typed, from loose to tight."""
    return numbers_asked(text, "--tolerances", 1.0)


def numbers_asked(text: str | None, option: str, below: float) -> tuple[float, ...] | None:
    """Positive numbers as typed, from large to small, each once.

    Raises:
        InputError: something that is no number, or out of range.
    """
    if text is None:
        return None
    found = set()
    for word in text.split(","):
        try:
            value = float(word)
        except ValueError:
            raise InputError(option, f'"{word.strip()}" is no number; write 1e-4,1e-6') from None
        if not 0.0 < value < below:
            raise InputError(option, f"{value:g} should be between 0 and {below:g}")
        found.add(value)
    return tuple(sorted(found, reverse=True))


# --- outputs --------------------------------------------------------------------------------------------------------------------


def _write(measured: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Write the outputs."""
    from masonry_cd.studies.accuracy_picture import problem_picture, scene_picture

    own_files.begin(folder, OUTPUTS)
    rows = [asdict(row) for row in measured["rows"]]
    written = [folder / name for name in OUTPUTS]
    write_rows(rows, written[0])
    warnings = [f"- **{line}**" for line in measured["warnings"]]
    lines = [f"- {line}" for line in measured["lines"]]
    sections = [f"# Error against run time: {measured['title']}", "", markdown(rows), *lines, *warnings]
    with replacing(written[1]) as part:
        part.write_text("\n".join(sections) + "\n", encoding="utf-8")
    draw = problem_picture if measured["kind"] == "problem" else scene_picture
    draw(measured["rows"], measured["title"], written[2])
    return {"lines": measured["lines"], "warnings": measured["warnings"], "written": written}


def write_rows(rows: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Write rows of like keys."""
    write_csv(path, rows[0], ([f"{v:.9g}" if isinstance(v, float) else str(v) for v in row.values()] for row in rows))


def markdown(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as a table in Markdown, aligned, three digits; what was missed stands out."""
    cells = [[key.replace("_", " ") for key in rows[0]], *([_cell(key, value) for key, value in row.items()] for row in rows)]
    width = [max(len(row[k]) for row in cells) for k in range(len(cells[0]))]
    lines = ["| " + " | ".join(cell.ljust(w) for cell, w in zip(row, width, strict=True)) + " |" for row in cells]
    return "\n".join([lines[0], "|" + "|".join("-" * (w + 2) for w in width) + "|", *lines[1:]]) + "\n"


def _cell(key: str, value: Any) -> str:
    """A value for reading."""
    if key == "reached":
        return "yes" if value else "**missed**"
    if isinstance(value, bool):
        return "yes" if value else ""
    return f"{value:.3g}" if isinstance(value, float) else str(value).replace("|", "\\|")
