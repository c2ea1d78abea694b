# SPDX-License-Identifier: GPL-3.0-or-later
"""Records of a scene that likely act along another axis, twice, or at another size than intended.

Which way a channel points is known by its name (:mod:`loads.readers.orientation`). Components that act at the same time along one line
add up, which those of one station do not do. A record is in m/s2 as soon as it is read, so a scale that is the ratio of two units is
likely one conversion too many.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from loads import kind_of
from loads.motion import STANDARD_GRAVITY, STEEP, FromFile
from loads.readers.orientation import Orientation, of_record
from masonry_cd.foundation.units import Usual

USUAL = Usual(0.05, 2.0 * STANDARD_GRAVITY, "records of interest have 0.005 to 2 g; are units and scale those of the file?")
APART = 20.0  # degrees: lines nearer than this are one
ALIKE = 1e-9  # of the numbers of one motion read twice
CLOSE = 2e-3  # of a ratio of units: 9.8, 9.81 and 9.82 are g
RATIOS = {
    "g to m/s2": STANDARD_GRAVITY, "m/s2 to g": 1.0 / STANDARD_GRAVITY, "g to cm/s2": 100.0 * STANDARD_GRAVITY,
    "cm/s2 to g": 0.01 / STANDARD_GRAVITY, "mg to m/s2": 1e-3 * STANDARD_GRAVITY, "m/s2 to mg": 1e3 / STANDARD_GRAVITY,
    "cm/s2 to m/s2": 0.01, "m/s2 to cm/s2": 100.0, "mm/s2 to m/s2": 0.001, "m/s2 to mm/s2": 1000.0,
}  # fmt: skip


class _Acting(NamedTuple):
    """A component and when it acts."""

    where: str
    path: str
    column: str
    direction: np.ndarray  # (3,) a unit vector
    begin: float  # [s]
    end: float
    motion: tuple[float, ...]  # numbers of it that its size does not change

    @property
    def label(self) -> str:
        """Return its name in messages: its file, and the channel of several."""
        return f"{self.path} [{self.column}]" if self.column else self.path

    @property
    def orientation(self) -> Orientation | None:
        return of_record(self.column, self.path)


def record_doubts(loads: Sequence[Mapping[str, Any]], summaries: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    """Keys that are likely wrong, and a line on each.

    Args:
        loads: the tables [[loads]] in SI.
        summaries: of the same as they are built, in their order.
    """
    both = enumerate(zip(loads, summaries, strict=False))
    motions = [motion for i, (load, made) in both for motion in from_files(load, f"loads[{i}]", made)]
    for motion in motions:
        yield from size_doubts(motion.keys, motion.where, [made for _, _, made in motion.components])
    found = [one for motion in motions for one in _acting(motion)]
    for one in found:
        yield from _upright(one)
    for one, other in combinations(found, 2):
        yield from _together(one, other)


def size_doubts(table: Mapping[str, Any], where: str, made: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    """Doubts of the size of the components of a record.

    Args:
        table: the keys, of which some say the size.
        where: the place of these.
        made: the components as they are built.
    """
    if "target_pga" in table:  # which is checked by itself
        return
    key = next((name for name in ("scale", "units", "path") if name in table), "components")  # of which a shock has several
    given = f" = {table[key]:g}" if key == "scale" else ""
    lines = [unusual_pga(max(one["after"]["pga"] for one in made), f"{where}.{key}{given} makes a")]
    lines += [_converted(table["scale"], f"{where}.scale", one) for one in made if key == "scale"]
    yield from ((f"{where}.{key}", line) for line in [line for line in lines if line][:1])


def _converted(scale: float, key: str, made: Mapping[str, Any]) -> str:
    """A line on a scale that is the ratio of two units, of a record whose unit is known without it; empty where it is none."""
    ratio = next((name for name, size in RATIOS.items() if math.isclose(abs(scale), size, rel_tol=CLOSE)), "")
    if not ratio or not made.get("unit"):
        return ""
    return f'{key} = {scale:g} is the factor from {ratio}, but the record is read in its own unit, "{made["unit"]}", and is in m/s2 before'


def unusual_pga(pga: float, what: str) -> str:
    """A line on the peak acceleration [m/s2] that a record has, which begins with ``what`` has it; empty where it is usual."""
    return "" if USUAL.holds(pga) else f"{what} PGA of {pga:.3g} m/s2 ({pga / STANDARD_GRAVITY:.3g} g): {USUAL.reason}"


def from_files(table: Mapping[str, Any], where: str, made: Mapping[str, Any]) -> list[FromFile]:
    """The motions that a load has from files, by its keys in SI and by its summary; none of a kind that has none."""
    kind = kind_of(table)
    return [] if kind is None or kind.recorded is None else kind.recorded(table, made, where)


def _acting(motion: FromFile) -> Iterator[_Acting]:
    """The components of a motion that were read."""
    for where, keys, made in (one for one in motion.components if "path" in one[1] and "before" in one[2]):
        size, before = abs(motion.factor), made["before"]
        numbers = (before["pga"] / size, before["pgv"] / size, before["arias"] / size**2, made["window"][1] - made["window"][0])
        yield _Acting(where, keys["path"], made["column"], np.array(made["direction"]), motion.begin, motion.end, numbers)


def _upright(one: _Acting) -> Iterator[tuple[str, str]]:
    """A vertical channel that acts level, or a horizontal one that acts upwards."""
    points, upright = one.orientation, abs(float(one.direction[2])) > STEEP
    if points is not None and points.vertical != upright:
        is_, acts = ("vertical", "level") if points.vertical else ("horizontal", "along the vertical")
        yield (
            f"{one.where}.direction",
            f"{one.where}.direction: {points.by} is {is_} by its name, and acts {acts}: another channel, or direction?",
        )


def _together(one: _Acting, other: _Acting) -> Iterator[tuple[str, str]]:
    """Two components that act at the same time along one line though they are those of two, or one and the same."""
    cosine = abs(float((one.direction * other.direction).sum()))
    if min(one.end, other.end) <= max(one.begin, other.begin) or cosine < math.cos(math.radians(APART)):
        return
    key = f"{other.where}.direction"
    begins = f"{key}: along the line of {one.where}, at the same time, acts"
    same = np.allclose(one.motion, other.motion, rtol=ALIKE, atol=0.0)
    if same or (one.path, one.column) == (other.path, other.column):
        yield key, f"{begins} the same record once more: both add up"
        return
    a, b = one.orientation, other.orientation
    if a is not None and b is not None and a.azimuth is not None and b.azimuth is not None:
        between = abs(a.azimuth - b.azimuth)
        apart = min(between, 180.0 - between) > APART
    else:
        apart = one.path == other.path or (a is not None and b is not None and a.vertical != b.vertical)
    if apart:
        yield key, f"{begins} another channel, {other.label} and {one.label}: both add up; is one along another axis?"
