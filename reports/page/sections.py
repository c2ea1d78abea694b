# SPDX-License-Identifier: GPL-3.0-or-later
"""Sections of the page: damage, loads and ties, the model, the checks of the run, and the tables it carries."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.joint_damage import JointDamage
from masonry_cd.analysis.damage.part_damage import PartDamage
from masonry_cd.analysis.damage.verdict import BEDS, END, ENERGY, FALSE_MOTION, FORCES, LAWS, LOADS, MODEL, OVERLAP, TIME_STEP
from masonry_cd.analysis.verdict import GOOD, NOT_GRADED
from masonry_cd.foundation.quantities import force
from masonry_cd.io.results import Results
from masonry_cd.io.summary_tables import LimitBracket
from reports.damage import write_joints_csv, write_part_damage
from reports.drawing.figure import in_metres
from reports.files import known_files
from reports.page.document import Badge
from reports.page.section import Section
from reports.page.words import PageContext, capital, number, sensible, terms
from reports.settings import OUTPUTS

G = 9.80665  # [m/s2]
MOST = 40  # lines, and rows of a table
JOINTS = "joints.csv"
PREFIX = "file/"  # of the names of files among the packed arrays
COUNTS = ("only_opened", "only_slid", "opened_and_slid", "separated", "lost_blocks")
SAID = {  # what a check means, and what to do
    END: (
        "Residual cracks, slips and drifts, and the grades, are final once all standing blocks are at rest.",
        "They are provisional here: let the run continue (run.until_still, run.longest, or --resume).",
    ),
    FORCES: (
        "Each time step finds all contact forces together, so that no joint pulls, no closed joint closes further, and friction obeys "
        "Coulomb's law. The error is the residual of these conditions as a share of what the step has to balance: 10⁻³ is a thousandth.",
        "Look at the plot of the solver's error: single steps during an impact hardly matter, sequences of missed steps do. Raise "
        "run.max_iterations, or halve run.dt. Where steps left contacts closing, the forces are meaningless: find out what pushes the "
        "blocks together there.",
    ),
    FALSE_MOTION: (
        "The error of the contact forces lets joints slip that friction should hold, and lets compressed joints part. The slip "
        "accumulates; the value is that of the single worst contact. It should be small compared with the largest displacement.",
        "Lower run.tolerance until it is.",
    ),
    ENERGY: (
        "The work of the base, of gravity and of other forces either remains as motion or was dissipated by friction and impacts. The rest "
        "is an error of the computation.",
        "Halve run.dt and compare; if the error remains, lower run.tolerance.",
    ),
    OVERLAP: (
        "Blocks should not penetrate each other. Openings and slidings below this value are meaningless.",
        "Halve run.dt and lower run.tolerance; blocks that jam between moving supports also cause overlap.",
    ),
    LOADS: ("At least 95 % of each load should have acted by the end of the run.", "Use a longer run.duration, or an earlier start."),
    LAWS: ("Beyond this limit the law of a joint does not describe masonry.", "Check its stiffness, its strength and its loads."),
    MODEL: (
        "Values that are probably in another unit, and blocks without support, describe a structure other than the intended one.",
        "Correct them, or list the keys whose values are intended in quiet_checks.",
    ),
    TIME_STEP: ("It must resolve the shaking, the rocking of the smallest block, and the fastest motion.", "Use a smaller run.dt."),
    BEDS: (
        "An elastic joint that opens carries load on part of its depth. Where a single row of points represents that part, it lies at the "
        "very edge, and the joint is stronger than its bed.",
        "Raise material.joints.joint_points, or leave the key out.",
    ),
}


def parts(context: PageContext) -> Mapping[str, Any]:
    """The damage of the named parts, the structure first, then the gravest; empty where there is none."""
    damage = context.parts
    if damage is None:
        return {}
    rows = [damage.parts[-1], *sorted(damage.parts[:-1], key=lambda row: str(row["grade"]), reverse=True)]
    times = sorted({row["time"] for row in damage.history})
    return {
        "rows": [_part(row, k == 0, context) for k, row in enumerate(rows)],
        "thresholds": damage.settings.thresholds.in_words(),
        "of_steps": damage.of_steps,
        "frames": len(times),
        "apart": number(1e3 * (times[-1] - times[0]) / (len(times) - 1), "ms", 3) if len(times) > 1 else "",
        "provisional": context.provisional,
    }


def _part(row: Mapping[str, Any], whole: bool, context: PageContext) -> list[str | Badge]:
    """A row of the table of parts; the verdict stands for the grades of a run that cannot be relied on, once, in the row of the whole."""
    grade, reason = row["grade"], row["grade_reason"]
    if not context.checks.is_reliable:
        grade, reason = NOT_GRADED, context.verdict.words if whole else ""
    lengths = [1e3 * row["residual_opening"], 1e3 * row["residual_sliding"]]
    drifts = [1e2 * row["residual_drift"], 1e2 * row["max_drift"]]
    counts = [str(row[key]) for key in COUNTS]
    return [row["part"], Badge.grade(grade), reason, row["mechanism"], *counts, *map(sensible, [*lengths, *drifts])]


def capacity(context: PageContext) -> Mapping[str, Any]:
    """Return the load on the structure, and the load factor that it bore where a push or a tilt sought it."""
    factor, shaking = _load_factor(context), _shaking(context)
    return {"factor": factor, "shaking": shaking} if factor or shaking else {}


def _load_factor(context: PageContext) -> dict[str, Any]:
    """The load factor at which the structure gave way."""
    found = context.summary.load_factor
    if found is None:
        return {}
    tilted = any(load.get("kind") == "tilt" for load in context.tables.get("loads", []))
    stood, place, bracket = found.given_way is None, found.given_way_displacement, found.limit_analysis or LimitBracket()
    at = found.end if found.given_way is None else found.given_way
    return {
        "stood": stood,
        "at": f"λ = {number(at, digits=3)}" + (f" ({math.degrees(math.atan(at)):.3g}°)" if tilted else ""),
        "time": "" if found.given_way_time is None else number(found.given_way_time, "s"),
        "place": "" if place is None else in_metres(place),
        "limit": in_metres(found.limit),
        "end": number(found.end),
        "rigid": found.rigid,
        "upper": "" if bracket.associated is None else number(bracket.associated, digits=3),
        "least": "" if bracket.least_found is None else number(bracket.least_found, digits=3),
        "one": bracket.one,
    }


def _shaking(context: PageContext) -> list[list[str]]:
    """The peaks of each base motion."""
    rows = []
    for name, direction, peaks in _motions(context.summary.loads.tables):
        pga, (pgv, pgd) = peaks.get("pga", math.nan), (in_metres(peaks.get(key, 0.0)) for key in ("pgv", "pgd"))
        rows.append([name, direction, f"{number(pga, digits=3)} ({pga / G:.2g} g)", f"{pgv}/s", pgd])
    return rows


def _motions(tables: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """Name, direction and peaks of each motion of the base, those of shocks in a row one by one."""
    for k, load in enumerate(tables, start=1):
        name = f"load {k}, {load.get('kind', '')}" + (f" {load['path']}" if "path" in load else "")
        if isinstance(load.get("after"), Mapping):
            yield name, _direction(load.get("direction", ())), load["after"]
        for shock in load.get("shocks", ()):
            for component in shock.get("components", ()):
                if isinstance(component.get("after"), Mapping):
                    yield shock["name"], _direction(component.get("direction", ())), component["after"]


def _direction(vector: Sequence[float]) -> str:
    """``x`` for (1, 0, 0), ``−x`` for (-1, 0, 0), else the numbers."""
    along = [f"{'−' if value < 0 else ''}{axis}" for axis, value in zip("xyz", vector, strict=False) if abs(value) > 1e-9]
    if len(along) == 1:
        return along[0]
    return f"({', '.join(f'{value:.3g}' for value in vector)})"


def ties(context: PageContext) -> Mapping[str, Any]:
    """Return the tension of each tie."""
    rows = [
        [
            tie.name or " to ".join(tie.blocks),
            force(tie.tension_max),
            number(tie.stress_max / 1e6, digits=3),
            number(tie.tension_max_time, digits=3),
            force(tie.tension_end),
            "–" if tie.yield_time is None else number(tie.yield_time, digits=3),
        ]
        for tie in context.summary.ties
    ]
    return {"rows": rows} if rows else {}


def loads(context: PageContext) -> Mapping[str, Any]:
    """The lines that a run prints before it begins, and each motion of the supports where they do not all move alike."""
    lines = [re.sub(r"loads\[(\d+)\]", lambda k: f"load {int(k[1]) + 1}:", line) for line in context.summary.modelled]
    if not lines:  # of a run that left no summary
        for k, load in enumerate(context.tables.get("loads", [])):
            keys = ", ".join(" ".join(term) for term in terms(load) if term[0] != "kind")
            lines.append(f"load {k + 1}: {load.get('kind', '')}, {keys}")
    motions = []
    for motion in context.motions if len(context.motions) > 1 else ():
        last = ", ".join(number(1e3 * value, digits=3) for value in motion.displacement[-1]).replace("-", "−")
        motions.append([motion.called, *([in_metres(motion.largest), last] if motion.moves else ["at rest", "–"])])
    return {"lines": lines, "motions": motions, "most": MOST} if lines or motions else {}


def trust(context: PageContext) -> Mapping[str, Any]:
    """The checks with what they come to; what to do is said where one is not good."""
    checks, columns = context.checks.findings, ["check", "found", "verdict", "what it means"]
    rows = [[one.name, capital(one.why), Badge(f"verdict {one.verdict}", one.verdict), SAID[one.name][0]] for one in checks]
    if context.checks.worst != GOOD:
        columns.append("what to do")
        for row, one in zip(rows, checks, strict=True):
            row.append(Badge("wanted", SAID[one.name][1]) if one.verdict != GOOD else "")
    return {"columns": columns, "rows": rows, "words": context.verdict.words}


def carried_tables(results: Results, table: JointDamage, parts: PartDamage | None) -> dict[str, np.ndarray]:
    """The bytes of each table by its name among the packed arrays; they are those of the files in the run's folder."""
    carried = [name for output in OUTPUTS.values() for name in output.carried]
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        write_joints_csv(table, here / JOINTS, end_state(results, parts.settings.thresholds if parts else None).provisional)
        if parts is not None:
            write_part_damage(parts, here)
        return {PREFIX + name: np.frombuffer((here / name).read_bytes(), np.uint8) for name in carried if (here / name).exists()}


def downloads(context: PageContext) -> Mapping[str, Any]:
    """The tables that the page carries, and what each holds."""
    meanings = known_files()
    return {"files": [(name, meanings[name]) for name in (name.removeprefix(PREFIX) for name in context.carried)]}


SECTIONS = {
    "parts": Section("Damage by part", parts, -50),
    "loads": Section("Masses, ties and loads in the model", loads, -40),
    "capacity": Section("Loads and capacity", capacity, -30),
    "ties": Section("Ties", ties, -20),
    "trust": Section("How far the numbers can be trusted", trust, 20),
    "tables": Section("Tables", downloads, 40),
}
