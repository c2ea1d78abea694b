# SPDX-License-Identifier: GPL-3.0-or-later
"""The motions of a study: files of a folder, paired by their names, with their intensity measures.

A motion is measured once, as it shakes the base: cut, corrected, rotated. A run that scales it by f has measures of f^order times these.
What a run gets are [[loads]] tables of kind "record", one for each component that shakes.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from loads.signal.accelerogram import Accelerogram, process
from loads.signal.baseline import GroundHistory
from loads.signal.directions import rotated
from loads.signal.intensity import arias
from loads.signal.measures import Measure, parse
from masonry_cd.foundation.errors import InputError, parse_table, suggest
from masonry_cd.studies.study.record_tables import RecordsTable
from masonry_cd.studies.study.study_file import ReadStudy

COMMON = ("PGA", "PGV", "PGD", "Arias", "CAV", "D5-95")  # measures that cost next to nothing
MOST_NAMED = 4  # files or motions in a message
LONGEST = 10.0  # for the matching of all names, which takes milliseconds [s]
MATCH = (
    "import json, re, sys; pattern, names = json.load(sys.stdin); found = [(n, re.fullmatch(pattern, n)) for n in names]; "
    "print(json.dumps([(n, m['motion'], m['component']) for n, m in found if m]))"
)


@dataclass(frozen=True, eq=False)
class RecordMotion:
    """A motion: its files by axis, or a value of a key of the scene."""

    name: str
    files: dict[str, Path] = field(default_factory=dict)
    value: Any = None
    window: tuple[float, float] | None = None  # where it was trimmed [s]
    duration: float = 0.0  # of what shakes [s]
    histories: dict[str, GroundHistory] = field(default_factory=dict)  # by axis, before any rotation

    def rotated(self, degrees: float) -> dict[str, GroundHistory]:
        """The components, the horizontal pair turned about z."""
        if degrees == 0.0 or not {"x", "y"} <= self.histories.keys():
            return self.histories
        angle, x, y = math.radians(degrees), self.histories["x"], self.histories["y"]
        return self.histories | {"x": rotated(x, y, -angle), "y": rotated(x, y, math.pi / 2.0 - angle)}


class Records:
    """The motions of a study, in the order of their names, and what is measured of them."""

    def __init__(self, table: RecordsTable, motions: Sequence[RecordMotion], measures: Mapping[str, Measure], scaled_by: str) -> None:
        self.table, self.motions, self.measures, self._scaled_by = table, list(motions), dict(measures), scaled_by
        self.by_name = {motion.name: motion for motion in motions}
        self._measured: dict[tuple[str, float], dict[str, float]] = {}

    def measured(self, motion: RecordMotion, degrees: float) -> dict[str, float]:
        """All measures of a motion before it is scaled, by the names of their columns."""
        key = (motion.name, degrees)
        if key not in self._measured:
            histories = motion.rotated(degrees)
            try:
                self._measured[key] = {name: measure.value(histories) for name, measure in self.measures.items()}
            except InputError as error:
                raise error.under(motion.name).under("intensity") from None
        return self._measured[key]

    def factor(self, motion: RecordMotion, degrees: float, level: float | None) -> float:
        """Return the factor by which the motion is multiplied.

        Raises:
            InputError: no factor brings it to the level.
        """
        if level is None:
            return self.table.scale * (self.table.factors or {}).get(motion.name, 1.0)
        measure, value = self.measures[self._scaled_by], self.measured(motion, degrees)[self._scaled_by]
        if measure.order == 0 or not value > 0.0:
            raise InputError("intensity.measure", f"{measure.name}: no factor scales {motion.name} to it, where it is {value:g}")
        return level / value if measure.order == 1 else math.sqrt(level / value)

    def scaled(self, motion: RecordMotion, degrees: float, factor: float, level: float | None) -> dict[str, float]:
        """The measures of the motion times a factor; the one that it was scaled to is the level itself."""
        values = self.measured(motion, degrees)
        found = {name: values[name] * factor**measure.order for name, measure in self.measures.items()}
        return found if level is None else found | {self._scaled_by: level}

    def loads(self, motion: RecordMotion, degrees: float, factor: float) -> list[dict[str, Any]]:
        """The [[loads]] tables that shake the base."""
        shared = self.table.load_keys(motion.window)
        both = set(self.table.shaken) >= {"x", "y"}
        turned = {"rotate": degrees} if both and degrees else {}
        shares = [(axis, axis, 1.0) for axis in self.table.shaken]
        if degrees and not both:  # the base moves along one axis, which both components of the turned pair have a share in
            shares = [share for axis in self.table.shaken for share in _shares(axis, math.radians(degrees), motion)]
        return [
            {"kind": "record", "path": str(motion.files[of]), "direction": along, "scale": factor * share, **shared, **turned}
            for along, of, share in shares
        ]


def _shares(axis: str, angle: float, motion: RecordMotion) -> list[tuple[str, str, float]]:
    """Return the components that move along an axis when the pair is turned: (axis, component, factor), zero factors left out."""
    if axis == "z" or not {"x", "y"} <= motion.files.keys():
        return [(axis, axis, 1.0)]
    c, s = math.cos(angle), math.sin(angle)
    pair = {"x": (c, -s), "y": (s, c)}[axis]
    return [(axis, of, share) for of, share in zip(("x", "y"), pair, strict=True) if abs(share) > 1e-12]


def find_records(study: ReadStudy) -> Records | None:
    """The motions of a study, read and measured; None where it has none.

    Raises:
        InputError: no file fits the pattern, components that do not pair, a file that cannot be read.
    """
    table, intensity = study.tables.records, study.tables.intensity
    if table is None:
        return None
    with study.locating():
        if table.values is not None:
            return Records(table, [RecordMotion(f"{table.key}={value}", value=value) for value in table.values], {}, "")
        named = "PGA" if intensity is None else intensity.measure
        rule = table.axes[0] if intensity is None else intensity.of
        measures = {named: parse(named, "intensity.measure", rule)}
        measures |= {
            name: parse(name, "intensity.also", rule) for name in (*(intensity.also if intensity else ()), *COMMON) if name != named
        }
        dt = study.scene.run.dt
        motions = [paired(table, name, files) for name, files in motions_of(table, study.folder).items()]
        return Records(table, [read_motion(motion, table, dt) for motion in motions], measures, named)


def matched(pattern: str, names: Sequence[str], longest: float = LONGEST) -> list[tuple[str, str, str]]:
    """Names that a regular expression matches as a whole, each with its motion and component.

    Some expressions try a number of ways that doubles with every letter. Nothing in this process could end that, so that another one
    matches, for a ``longest`` time [s].

    Raises:
        InputError: it takes longer.
    """
    command = [sys.executable, "-I", "-S", "-c", MATCH]
    try:
        ended = subprocess.run(command, input=json.dumps([pattern, names]), capture_output=True, text=True, timeout=longest, check=True)
    except subprocess.TimeoutExpired:
        raise InputError(
            "records.pattern",
            f'"{pattern}" is not done with {len(names)} file names in {longest:g} s: a repeat within a repeat, such as '
            "(a+)+, tries more ways than can be counted; write one repeat, or [^_]+ for what lies between underscores",
        ) from None
    return [(name, motion, component) for name, motion, component in json.loads(ended.stdout)]


def motions_of(table: RecordsTable, base: Path) -> dict[str, dict[str, Path]]:
    """The files of each motion of the folder, by component, in the order of the names.

    Raises:
        InputError: no such folder, no file that fits, a component twice, a motion that is named and not there.
    """
    assert table.folder is not None
    folder = (base / table.folder).resolve()
    if not folder.is_dir():
        raise InputError("records.folder", f"{folder}: no such folder")
    found: dict[str, dict[str, Path]] = {}
    names = sorted(path.name for path in folder.iterdir() if path.is_file())
    for name, motion, component in matched(table.pattern, names):
        if component in found.setdefault(motion, {}):
            raise InputError(
                "records.pattern", f'{found[motion][component].name} and {name} are both component "{component}" of "{motion}"'
            )
        found[motion][component] = folder / name
    if not found:
        seen = ", ".join(names[:MOST_NAMED]) + (" ..." if len(names) > MOST_NAMED else "")
        raise InputError("records.pattern", f"no file of {folder} matches {table.pattern} (files there: {seen or 'none'})")
    for key, named in (("exclude", table.exclude), ("factors", table.factors or ())):
        for name in named:
            if not any(fnmatchcase(motion, name) if key == "exclude" else motion == name for motion in found):
                raise InputError(f"records.{key}", f'there is no motion "{name}"{suggest(name, found)}')
    asked = [motion for motion in sorted(found) if table.factors is None or motion in table.factors]
    kept = {motion: found[motion] for motion in asked if not any(fnmatchcase(motion, name) for name in table.exclude)}
    if not kept:
        raise InputError("records.exclude", "leaves no motion")
    return kept


def paired(table: RecordsTable, motion: str, files: Mapping[str, Path]) -> RecordMotion:
    """A motion with a file for each axis.

    Raises:
        InputError: a component that is not there, or is required twice.
    """
    return RecordMotion(motion, {axis: _component(table, axis, motion, files) for axis in table.axes})


def _component(table: RecordsTable, axis: str, motion: str, files: Mapping[str, Path]) -> Path:
    """The file that shakes along an axis."""
    asked = getattr(table, axis)
    chosen = next((name for name in asked if name in files), None)
    if chosen is None:
        raise InputError(f"records.{axis}", f'the motion "{motion}" has components {", ".join(sorted(files))}, none of {", ".join(asked)}')
    taken = [name for other in table.axes if other != axis for name in getattr(table, other)[:1] if name == chosen]
    if taken:
        raise InputError(f"records.{axis}", f'"{chosen}" of the motion "{motion}" is required along two axes')
    return files[chosen]


def read_motion(motion: RecordMotion, table: RecordsTable, dt: float) -> RecordMotion:
    """Read the components of a motion, cut alike.

    Args:
        motion: from :func:`paired`.
        table: how they are treated.
        dt: time step of a run, for ``resample = "run"`` [s].

    Raises:
        InputError: a file that cannot be read, components that differ in their time steps.
    """
    window: tuple[float, float] | None = None
    raw = {axis: _history(path, table, dt, None) for axis, path in motion.files.items()}
    ends = {axis: history.duration for axis, history in raw.items()}
    shortest = min(ends.values())
    if table.trim is not None:
        window = _trimmed(raw, table, shortest)
    elif table.window is None and max(ends.values()) > shortest:
        window = (0.0, shortest)  # the components go on for different times
    histories = raw if window is None else {axis: _history(path, table, dt, window) for axis, path in motion.files.items()}
    if len({history.step for history in histories.values()}) > 1:
        steps = ", ".join(f"{axis} {history.step:g} s" for axis, history in histories.items())
        raise InputError("records", f'the components of "{motion.name}" differ in their time steps, {steps}; resample brings them to one')
    duration = max(histories[axis].duration for axis in table.shaken)
    return RecordMotion(motion.name, motion.files, None, window, duration, histories)


def _history(path: Path, table: RecordsTable, dt: float, window: tuple[float, float] | None) -> GroundHistory:
    """A component as it will shake the base."""
    keys = parse_table(Accelerogram, {"path": str(path), **table.load_keys(window)}, "records")
    return process(keys, path.parent, dt, "records").after


def _trimmed(raw: Mapping[str, GroundHistory], table: RecordsTable, shortest: float) -> tuple[float, float]:
    """The window in which the Arias intensity of the shaking components builds up [s]."""
    assert table.trim is not None
    step = raw[table.shaken[0]].step
    count = min(len(raw[axis].acceleration) for axis in table.shaken)
    built = np.sum([arias(raw[axis])[:count] for axis in table.shaken], axis=0)
    times = step * np.arange(count)
    begin, end = np.interp([share * built[-1] for share in table.trim.arias], built, times)
    whole = [step * round(time / step) for time in (max(0.0, begin - table.trim.before), min(shortest, end + table.trim.after))]
    return round(whole[0], 9), round(whole[1], 9)
