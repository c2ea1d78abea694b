# SPDX-License-Identifier: GPL-3.0-or-later
"""The loads in the model: forces, pushes, motions that are given to single supports, and how each support moved."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from masonry_cd.foundation.quantities import force
from masonry_cd.foundation.units import begins_as_number
from reports.drawing.figure import in_metres
from reports.page.section import Section
from reports.page.words import PageContext, number

MOST = 40  # rows of a table
NAMED = 6  # supports of a load that are named


def loads(context: PageContext) -> Mapping[str, Any]:
    """What acts on the structure beside its weight and shaking, and the motions of the supports."""
    tables, amounts = context.tables.get("loads", []), context.summary.get("loads", {}).get("tables", [])
    rows = []
    for k, load in enumerate(tables):
        known = amounts[k] if k < len(amounts) and amounts[k].get("kind") == load.get("kind") else {}
        if load.get("kind") in ROWS:
            said = ROWS[load["kind"]]({**load, **known}, known) if known or not any(map(_has_unit, load.values())) else _as_written(load)
            rows.append([f"load {k + 1}, {load['kind']}", *said])
    motions = _motions(context)
    return {"rows": rows, "motions": motions, "most": MOST} if rows or motions else {}


def point_loads(context: PageContext) -> int:
    """How many point loads the scene has."""
    return sum(load.get("kind") == "point" for load in context.tables.get("loads", []))


def _has_unit(value: object) -> bool:
    """Whether a value of a scene is a text with a unit; the summary of a run has its number."""
    return (isinstance(value, str) and begins_as_number(value)) or (isinstance(value, list) and any(map(_has_unit, value)))


def _as_written(load: Mapping[str, Any]) -> list[str]:
    """The keys of a load of a run without a summary."""
    return ["", ", ".join(f"{key} {value}" for key, value in load.items() if key != "kind"), ""]


def _motions(context: PageContext) -> list[list[str]]:
    """Each motion of the supports, where they do not all move alike."""
    rows = []
    for motion in context.motions if len(context.motions) > 1 else ():
        last = ", ".join(number(1e3 * value, digits=3) for value in motion.displacement[-1]).replace("-", "−")
        rows.append([motion.called, *([in_metres(motion.largest), last] if motion.moves else ["at rest", "–"])])
    return rows


def _point(load: Mapping[str, Any], _: Mapping[str, Any]) -> list[str]:
    """A force on a block."""
    vector = [float(value) for value in load["force"]]
    at = f" at ({', '.join(f'{value:.4g}' for value in load['point'])}) m" if load.get("point") else " at its centre of mass"
    start, ramp = float(load.get("start", 0.0)), float(load.get("ramp", 0.0))
    when = f"grows from {start:g} to {start + ramp:g} s" if ramp else f"in full from {start:g} s on"
    if load.get("stages"):
        shares = ", ".join(f"{100.0 * float(stage):g}" for stage in load["stages"])
        when = f"{shares} % of it one after the other from {start:g} s on, over {ramp:g} s each, held {float(load.get('hold', 0.0)):g} s"
    return [f"{load['block']}{at}", f"{force(math.hypot(*vector))} {_along(vector)}", when]


def _ground(load: Mapping[str, Any], known: Mapping[str, Any]) -> list[str]:
    """A settlement or a spreading of supports."""
    names = known.get("supports") or load.get("supports") or ["all supports"]
    names = [names] if isinstance(names, str) else list(names)
    on = ", ".join(map(str, names[:NAMED])) + (f" and {len(names) - NAMED} more" if len(names) > NAMED else "")
    start = float(load.get("start", 0.0))
    sign = "−" if load["displacement"] < 0 else ""
    much = f"{sign}{in_metres(abs(load['displacement']))} {_along(load['direction'])}"
    return [on, much, f"{start:g} to {start + float(load['duration']):g} s"]


def _body(load: Mapping[str, Any], known: Mapping[str, Any]) -> list[str]:
    """A push or a tilt of all blocks, or a push of some by displacement."""
    if load.get("control") == "displacement":
        return _moved(load, known)
    unit = "°" if load["kind"] == "tilt" else " of the weight"
    end = known.get("angle" if load["kind"] == "tilt" else "peak")
    up_to = "" if end is None else f" to {end:.4g}{unit}"
    along = known.get("direction") or load.get("direction")
    much = f"from {float(load.get('initial', 0.0)):g}{up_to} at {float(load['rate']):g}{unit} per second"
    return ["all free blocks", f"{much}{f' {_along(along)}' if along else ''}", f"from {float(load.get('start', 0.0)):g} s on"]


def _moved(load: Mapping[str, Any], known: Mapping[str, Any]) -> list[str]:
    """A push by displacement."""
    targets = load["targets"] if isinstance(load["targets"], (list, tuple)) else [load["targets"]]
    ways = ", ".join(f"{1e3 * float(way):.4g}" for way in targets[:NAMED]).replace("-", "−") + (" …" if len(targets) > NAMED else "")
    turns = ", held from turning" if load.get("rotation") == "held" else ""
    names = known.get("name") or load.get("blocks")
    when = (
        f"{float(load.get('start', 0.0)):g} to {known['end']:.4g} s" if "end" in known else f"from {float(load.get('start', 0.0)):g} s on"
    )
    return [names if isinstance(names, str) else ", ".join(names or ()), f"to {ways} mm {_along(load['direction'])}{turns}", when]


def _prop(load: Mapping[str, Any], known: Mapping[str, Any]) -> list[str]:
    """A prop."""
    names = load["blocks"] if isinstance(load["blocks"], str) else ", ".join(load["blocks"])
    return [names, f"held {_along(load['direction'])}", "throughout"]


def _pulse(load: Mapping[str, Any], _: Mapping[str, Any]) -> list[str]:
    """A body force that ends."""
    start, shape = float(load.get("start", 0.0)), load.get("shape", "half-sine")
    much = f"{shape}, {float(load['acceleration']):.4g} m/s² {_along(load['direction'])}"
    return ["all free blocks", much, f"{start:g} to {start + float(load['duration']):g} s"]


def _tie(load: Mapping[str, Any], _: Mapping[str, Any]) -> list[str]:
    """A bar between two blocks."""
    first, second = load["blocks"]
    area = load.get("section") or load.get("area") or 0.25 * math.pi * float(load["diameter"]) ** 2
    section_of = f"diameter {in_metres(math.sqrt(4.0 * area / math.pi))}" if "diameter" in load else f"section {1e6 * area:.4g} mm²"
    yields = f", yields at {force(load['yield_force'])}" if load.get("yield_force") else ""
    return [f"{first} to {second}", f"{section_of}, {force(load.get('tension', 0.0))} at the start{yields}", "throughout"]


def _along(direction: object) -> str:
    """``along −z``, whether it was given as an axis or as a vector."""
    if isinstance(direction, str):
        return f"along {direction.replace('-', '−')}"
    vector = [float(value) for value in direction] if isinstance(direction, (list, tuple)) else []
    size = math.hypot(*vector)
    axes = [(axis, value) for axis, value in zip("xyz", vector, strict=False) if abs(value) > 1e-9 * size]
    if len(axes) == 1:
        return f"along {'−' if axes[0][1] < 0 else ''}{axes[0][0]}"
    return f"along ({', '.join(f'{value / size:.3g}' for value in vector)})" if size else ""


ROWS = {
    "point": _point,
    "settlement": _ground,
    "spreading": _ground,
    "push": _body,
    "tilt": _body,
    "tie": _tie,
    "prop": _prop,
    "pulse": _pulse,
}

SECTIONS = {"loads": Section("Loads in the model", loads, -40)}
