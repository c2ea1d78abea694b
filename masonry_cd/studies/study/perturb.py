# SPDX-License-Identifier: GPL-3.0-or-later
"""The tiny change of a scene by which a member of an ensemble differs from the scene itself."""

from __future__ import annotations

from typing import Any

from masonry_cd.foundation.errors import InputError

SIZES = {"sinusoidal": ("amplitude",), "record": ("scale", "target_pga")}  # keys by which loads grow, by kind
UNSCALED = "scale"  # of a record that has neither key


def set_in_motion(tables: dict[str, Any], size: float, member: int) -> None:
    """Have the blocks begin with velocities of at most ``size`` in each direction [m/s], those of a member, in place."""
    tables["run"]["first_velocities"] = {"size": size, "seed": member}


def perturb(tables: dict[str, Any], what: str, change: float) -> None:
    """Multiply the size of all motions of the base, or the friction, by 1 + change, in place.

    Raises:
        InputError: no load of the scene has a size that can be changed.
    """
    if what == "friction":
        material = tables["material"]
        material["friction"] = _times(material.get("friction"), 1.0 + change)
        return
    changed = False
    for load in tables.get("loads", []):
        for table in load.get("shocks", []) if load.get("kind") == "sequence" else [load]:
            changed |= _grow(table, "record" if table is not load else str(load.get("kind")), 1.0 + change)
    if not changed:
        raise InputError(
            "ensemble.perturb", 'no load is sinusoidal, a record or a sequence; perturb = "friction" or "velocities" is for any scene'
        )


def _grow(table: dict[str, Any], kind: str, factor: float) -> bool:
    """Multiply the size of a load; whether it has one."""
    for key in SIZES.get(kind, ()):
        if key in table:
            table[key] = float(table[key]) * factor
            return True
    if kind == "record":
        table[UNSCALED] = factor
        return True
    return False


def _times(friction: Any, factor: float) -> Any:
    """Friction, a number or one for each pair of groups, times a factor."""
    if isinstance(friction, dict):
        return {pair: _times(value, factor) for pair, value in friction.items()}
    if friction is None:
        raise InputError("ensemble.perturb", "the scene gives no material.friction")
    return float(friction) * factor
