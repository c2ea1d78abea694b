# SPDX-License-Identifier: GPL-3.0-or-later
"""The tiny change of a scene by which a member of an ensemble differs from the scene itself."""

from __future__ import annotations

from typing import Any

from masonry_cd.foundation.errors import InputError


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
    from loads import KINDS, kind_of

    given = tables.get("loads", [])
    grown = [None if (kind := kind_of(load)) is None else kind.grown for load in given]
    tables["loads"] = [load if grow is None else grow(load, 1.0 + change) for load, grow in zip(given, grown, strict=True)]
    if not any(grown):
        kinds = ", ".join(name for name, kind in KINDS.items() if kind.grown is not None)
        raise InputError("ensemble.perturb", f'no load is one of {kinds}; perturb = "friction" or "velocities" is for any scene')


def _times(friction: Any, factor: float) -> Any:
    """Friction, a number or one for each pair of groups, times a factor."""
    if isinstance(friction, dict):
        return {pair: _times(value, factor) for pair, value in friction.items()}
    if friction is None:
        raise InputError("ensemble.perturb", "the scene gives no material.friction")
    return float(friction) * factor
