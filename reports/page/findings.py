# SPDX-License-Identifier: GPL-3.0-or-later
"""What came of the structure, the gravest first: damage of its parts, what it was loaded by and what it bore, its ties."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from masonry_cd.analysis.limit.outcome import one_factor
from masonry_cd.analysis.verdict import NOT_GRADED
from masonry_cd.foundation.quantities import force
from reports.drawing.figure import in_metres
from reports.page.section import Section
from reports.page.words import PageContext, number, sensible

G = 9.80665  # [m/s2]
COUNTS = ("only_opened", "only_slid", "opened_and_slid", "separated", "lost_blocks")


def parts(context: PageContext) -> Mapping[str, Any]:
    """The damage of the named parts, the structure first, then the gravest; empty where there is none."""
    damage = context.parts
    if damage is None:
        return {}
    whole = damage.parts[-1]
    rows = [whole, *sorted(damage.parts[:-1], key=lambda row: str(row["grade"]), reverse=True)]
    times = sorted({row["time"] for row in damage.history})
    return {
        "rows": [_part(row, row is whole, context) for row in rows],
        "thresholds": damage.settings.thresholds.in_words(),
        "of_steps": damage.of_steps,
        "frames": len(times),
        "apart": number(1e3 * (times[-1] - times[0]) / (len(times) - 1), "ms", 3) if len(times) > 1 else "",
        "provisional": context.provisional,
    }


def _part(row: Mapping[str, Any], whole: bool, context: PageContext) -> dict[str, Any]:
    """A row of the table of parts; the verdict stands for the grades of a run that cannot be relied on, once, in the row of the whole."""
    grade, reason = row["grade"], row["grade_reason"]
    if not context.checks.reliable:
        grade, reason = NOT_GRADED, context.verdict.words if whole else ""
    lengths = [1e3 * row["residual_opening"], 1e3 * row["residual_sliding"]]
    drifts = [1e2 * row["residual_drift"], 1e2 * row["max_drift"]]
    cells = [*(str(row[key]) for key in COUNTS), *map(sensible, [*lengths, *drifts])]
    return {"whole": whole, "part": row["part"], "grade": grade, "by": reason, "mechanism": row["mechanism"], "cells": cells}


def capacity(context: PageContext) -> Mapping[str, Any]:
    """What the structure was loaded by, and the load factor that it bore where a push or a tilt sought it."""
    factor, shaking = _load_factor(context), _shaking(context)
    return {"factor": factor, "shaking": shaking} if factor or shaking else {}


def _load_factor(context: PageContext) -> dict[str, Any]:
    """The load factor at which the structure gave way."""
    found = context.summary.get("load_factor")
    if not found:
        return {}
    tilted = any(load.get("kind") == "tilt" for load in context.tables.get("loads", []))
    stood = found["given_way"] is None
    place = found.get("given_way_displacement")
    bracket = found.get("limit_analysis") or {}
    return {
        "stood": stood,
        "at": _factor(found["end"] if stood else found["given_way"], tilted),
        "time": "" if stood else number(found["given_way_time"], "s"),
        "place": "" if place is None else in_metres(place),
        "limit": in_metres(found["limit"]),
        "end": number(found["end"]),
        "rigid": bool(found.get("rigid")),
        "upper": number(bracket["associated"], digits=3) if bracket.get("associated") is not None else "",
        "least": number(bracket["least_found"], digits=3) if bracket.get("least_found") is not None else "",
        "one": one_factor(bracket),
    }


def _factor(value: float, tilted: bool) -> str:
    """A load factor, with the angle of a tilt."""
    return f"λ = {number(value, digits=3)}" + (f" ({math.degrees(math.atan(value)):.3g}°)" if tilted else "")


def _shaking(context: PageContext) -> list[list[str]]:
    """The peaks of each base motion."""
    rows = []
    for name, direction, peaks in _motions(context.summary.get("loads", {}).get("tables", [])):
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
    """What each tie had to bear."""
    rows = [
        [
            tie.get("name") or " to ".join(tie["blocks"]),
            force(tie["tension_max"]),
            number(tie["stress_max"] / 1e6, digits=3),
            number(tie["tension_max_time"], digits=3),
            force(tie["tension_end"]),
            "–" if tie.get("yield_time") is None else number(tie["yield_time"], digits=3),
        ]
        for tie in context.summary.get("ties", ())
    ]
    return {"rows": rows} if rows else {}


SECTIONS = {
    "parts": Section("Damage by part", parts, -50),
    "capacity": Section("Loads and capacity", capacity, -30),
    "ties": Section("Ties", ties, -20),
}
