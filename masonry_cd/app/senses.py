# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of a usual size that point the wrong way, belong to another code, or leave a joint open: :mod:`masonry_cd.app.doubts` says them.

Each is ``(key, words)``: its place in the scene, and what is doubtful.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from loads import kind_of, parse_load
from loads.motion import STEEP, lifts, parse_direction
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import counted, length
from masonry_cd.mechanics.contact.find_joints import gaping

if TYPE_CHECKING:
    from masonry_cd.mechanics.model.blocks import Assembly
    from masonry_cd.mechanics.model.joints import Joints


def astray(tables: Mapping[str, Any], gravity: Sequence[float], built: tuple[Assembly, Joints] | None = None) -> Iterator[tuple[str, str]]:
    """All that is doubtful in this way of checked tables; of gaps where the blocks and joints as ``built`` are known."""
    size = math.hypot(*gravity)
    if size and -gravity[2] < STEEP * size:
        way = [float(f"{part:.3g}") for part in gravity]
        yield "run.gravity", f"run.gravity = {way} m/s2 does not act along -z: heights, courses, floors and what stands on what are along z"
    down = np.asarray(gravity) / size if size else np.zeros(3)
    for i, table in enumerate(tables.get("loads", [])):
        kind = kind_of(table)
        if kind is not None and kind.senses is not None:
            yield from kind.senses(parse_load(table, f"loads[{i}]"), down, f"loads[{i}]")
    limit = tables.get("limit", {})
    if "push" in limit and lifts(_along(limit["push"]), down):
        yield "limit.push", "limit.push lifts the blocks: it acts against gravity"
    yield from _code(limit.get("check", {}))
    if built is not None:
        yield from _open(tables, *built)


def _along(direction: object) -> np.ndarray:
    """The unit vector (3,) of a direction as a scene gives it; zero of none."""
    try:
        return np.asarray(parse_direction(direction).vector)
    except (InputError, ValueError, TypeError):
        return np.zeros(3)


def _code(check: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """A spectrum of another code than that of the check."""
    if check.get("code") == "EC8" and check.get("spectrum") == "NTC":
        words = 'Eurocode 8 with its own ag and ground has spectrum = "EC8", the Italian check code = "NTC2018"'
        yield "limit.check.spectrum", f'limit.check.spectrum = "NTC" stands beside code = "EC8": {words}'


def _open(tables: Mapping[str, Any], assembly: Assembly, joints: Joints) -> Iterator[tuple[str, str]]:
    """Faces that lie against one another and do not touch."""
    pairs, gaps = gaping(assembly, joints)
    if not len(pairs):
        return
    key, names = "structure" if "structure" in tables else "structures", [assembly.names[b] for b in pairs[0]]
    which = f'{counted(len(pairs), "pair")} of blocks, as "{names[0]}" and "{names[1]}",'
    apart = (
        f"face one another {length(float(gaps.max()))} apart at most"
        if len(pairs) > 1
        else f"face one another {length(float(gaps[0]))} apart"
    )
    yield key, f"{key}: {which} {apart} and share no joint: they bear nothing there until they have closed"
