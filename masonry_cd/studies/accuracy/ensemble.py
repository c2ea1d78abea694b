# SPDX-License-Identifier: GPL-3.0-or-later
r"""Error against run time where the motion amplifies rounding: ensembles of a run at every time step, tolerance and solver.

Under strong shaking one run is one sample, and two single runs say nothing of the setting between them. Here the size of the loads, or
the first velocities where they have none, is changed by 1e-9 from member to member, below what any tolerance resolves. A setting has the
median and the quartiles of its members,

    bias      median - median of the finest setting
    spread    difference of the quartiles, of the setting or of the finest, whichever is larger
    chance    that two samples of one distribution lie as far apart (the rank test of Mann & Whitney, Ann. Math. Stat. 18, 1947)

and shows a bias where the chance is below one in twenty and the bias more than 2 % of the finest median (and than 10 um, or 0.001 % of
drift): where nothing is chaotic all members agree, and any difference is beyond chance, also one that matters to nobody. A setting that
shows no bias may still have one, too small for so few members: of n members in either ensemble, a shift of 1.96 sqrt(2 / n) standard
deviations is seen every other time.

The finest setting has the smallest time step and the tightest tolerance, with the first solver. Seconds are of the processor (others may
use the machine) and include what a run writes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.analysis.outputs import NUMBERS, STUDY, SUMMARY, lengths_in
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.app.case import prepare
from masonry_cd.app.result import Result, Say
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.csv_files import write_rows
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.json_files import write_json
from masonry_cd.foundation.quantities import in_words, length
from masonry_cd.studies.accuracy.picture import Measurement, PanelSheet, Point, TimePanel, exponent, nine_digits
from masonry_cd.studies.study.checks import scene_of_run
from masonry_cd.studies.study.designs import DesignedRun
from masonry_cd.studies.study.plan import SIZE, Maker, StudyPlan, space_of, tables_of
from masonry_cd.studies.study.study_case import RunActions, StudyOptions, make_runs
from masonry_cd.studies.study.table import Rows

DESIGN = "accuracy"
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
LEAST = 4  # members: with three even samples that lie wholly apart have a chance of one in ten
SHOWN = 0.05  # a chance below this shows a bias ...
MATTERS = 0.02  # ... that is larger than this share of the finest median
LEAST_LENGTH = 1e-5  # [m], a tenth of the smallest crack that counts: biases below do not matter
LEAST_DRIFT = 1e-5  # its like of a drift
LENGTHS = lengths_in(SUMMARY)
MEASURES = LENGTHS | {"drift": NUMBERS["residual_drift"]}  # by the keys that tables of this study have
COLUMNS = {number.keys.get(SUMMARY, key): number.keys.get(STUDY, key) for key, number in NUMBERS.items()} | {"drift": "residual_drift"}
OF_MEMBER = (*LENGTHS, "collapsed_blocks", "steps", "drift", "grade", "steps_missed", "error_max")  # columns of members.csv
JSON, MEMBERS = "accuracy.json", "members.csv"


class Setting(NamedTuple):
    """How a scene is run."""

    solver: str
    dt: float  # [s]
    tolerance: float

    def __str__(self) -> str:
        return f"{self.solver}, dt {1e3 * self.dt:g} ms, tolerance {self.tolerance:g}"

    @property
    def values(self) -> dict[str, Any]:
        """Values by the keys of a scene."""
        return {f"run.{key}": value for key, value in self._asdict().items()}


class EnsembleSpread(NamedTuple):
    """A measure over the members of a setting."""

    low: float  # lower quartile
    median: float
    high: float  # upper quartile
    bias: float  # against the finest setting
    spread: float
    chance: float
    matters: float  # biases below do not

    @property
    def is_biased(self) -> bool:
        """Return True if a bias shows that matters."""
        return self.chance < SHOWN and abs(self.bias) > self.matters

    @property
    def within(self) -> bool:
        """Return True if the bias is smaller than the spread."""
        return abs(self.bias) <= self.spread


@dataclass(frozen=True, eq=False)
class EnsembleRow:
    """Result of a setting."""

    setting: Setting
    members: tuple[RunRow, ...]
    spreads: dict[str, EnsembleSpread]  # by measure
    finest: bool

    @property
    def is_biased(self) -> bool:
        """Return True if a bias shows in any measure."""
        return any(spread.is_biased for spread in self.spreads.values())

    @property
    def seconds(self) -> tuple[float, float, float]:
        """Seconds of the processor: lower quartile, median, upper quartile."""
        return quartiles([seconds_of(row) for row in self.members])

    @property
    def missed(self) -> int:
        """Steps of all members that missed the tolerance."""
        return sum(row.numbers["steps_missed"] for row in self.members)

    @property
    def steps(self) -> int:
        """Number of steps of all members."""
        return sum(row.numbers["steps"] for row in self.members)

    @property
    def grades(self) -> str:
        """``3 D1, 5 D2``"""
        grades = [row.numbers["grade"] for row in self.members]
        return ", ".join(f"{grades.count(grade)} {grade}" for grade in sorted(set(grades)))

    @property
    def cells(self) -> dict[str, Any]:
        """Its row of accuracy.csv."""
        out: dict[str, Any] = self.setting._asdict() | {"members": len(self.members)}
        for key, spread in self.spreads.items():
            out |= {key: spread.median, f"{key}_low": spread.low, f"{key}_high": spread.high}
            out |= {f"{key}_bias": spread.bias, f"{key}_spread": spread.spread, f"{key}_chance": spread.chance}
        low, middle, high = self.seconds
        out |= {"seconds": middle, "seconds_low": low, "seconds_high": high, "steps_missed": self.missed}
        out |= {"collapsed": sum(row.numbers["collapsed_blocks"] > 0 for row in self.members), "grades": self.grades}
        return out | {"biased": self.is_biased, "finest": self.finest}

    @property
    def read(self) -> dict[str, Any]:
        """Its row of accuracy.md: medians, quartiles and chances."""
        out: dict[str, Any] = {"solver": self.setting.solver, "dt [ms]": 1e3 * self.setting.dt, "tolerance": f"{self.setting.tolerance:g}"}
        for key, number in MEASURES.items():
            spread, (unit, factor) = self.spreads[key], number.shown
            text = f"{factor * spread.median:.3g} ({factor * spread.low:.3g} to {factor * spread.high:.3g})"
            out[f"{number.name} [{unit}], chance"] = text if self.finest else f"{text}, {spread.chance:.2g}"
        missed = 100.0 * self.missed / max(1, self.steps)
        return out | {"grades": self.grades, "steps missed [%]": missed, "CPU per run [s]": self.seconds[1]}


class EnsemblePlan(StudyPlan):
    """The runs: the first member of every setting, then the second of every one, and so on.

    Args:
        scene: checked.
        settings: the finest last.
        count: members of each.

    Raises:
        InputError: a setting that the scene cannot have; blocks or loads that are wrong.
    """

    def __init__(self, scene: Scene, settings: Sequence[Setting], count: int) -> None:
        tables = tables_of(scene)
        tables["run"] = {key: value for key, value in tables["run"].items() if key != "longest"} | {"until_still": False}
        maker = Maker(*space_of(scene, tables))
        for setting in settings:  # what is wrong with one of them is reported before any runs
            scene_of_run(maker.tables(DesignedRun(values=setting.values)))
        prepare(scene)  # and what is wrong with its blocks or loads; kernels are compiled once
        self.settings, self.count = settings, count
        asked = (DesignedRun(member=k or None, change=SIZE * k, values=one.values) for k in range(count) for one in settings)
        super().__init__(maker, asked, DESIGN)

    def groups(self, rows: Rows) -> list[EnsembleRow]:
        """Return the results of the settings, once all runs are done."""
        found = [rows[run.name] for run in self.runs]
        groups = [tuple(found[i :: len(self.settings)]) for i in range(len(self.settings))]
        return [
            EnsembleRow(setting, group, spreads_of(group, groups[-1]), group is groups[-1])
            for setting, group in zip(self.settings, groups, strict=True)
        ]


def ensembles(plan: EnsemblePlan, folder: Path, options: StudyOptions, say: Say) -> Result[Measurement | None]:
    """Make the runs that are missing, and write what they say.

    Raises:
        InputError: the folder of another scene, or a run that has no result.
    """
    made = make_runs(plan, folder, options, say, RunActions(lambda *_: None))
    if made.stopped:
        return made.ended_early()
    if lost := made.warnings(folder / "rows"):
        raise InputError(folder, f"{lost[0]}; an ensemble needs all of its runs; the same command makes these again")
    rows = plan.groups(made.rows)
    found = measured(plan.maker.study.title, rows)
    facts = {"format": 1, "title": plan.maker.study.title, "settings": found.rows, "lines": found.lines, "warnings": found.warnings}
    write_json(folder / JSON, facts)
    members = [one.setting._asdict() | {"member": k} | member_cells(row) for one in rows for k, row in enumerate(one.members)]
    write_rows(folder / MEMBERS, nine_digits(members))
    return Result(found, found.lines, found.warnings, [*found.write(folder), folder / JSON, folder / MEMBERS])


def settings_of(solvers: Sequence[str], dts: Sequence[float], tolerances: Sequence[float]) -> list[Setting]:
    """All settings, the finest of the first solver last."""
    asked = [
        Setting(solver, dt, tolerance) for solver in solvers for dt in sorted(dts, reverse=True) for tolerance in sorted(tolerances)[::-1]
    ]
    finest = Setting(solvers[0], min(dts), min(tolerances))
    return [*(setting for setting in asked if setting != finest), finest]


def seconds_of(row: RunRow) -> float:
    """Return the seconds of the processor."""
    return row.timing["processor"]


def member_cells(row: RunRow) -> dict[str, Any]:
    """A row of members.csv."""
    return {key: row.number(COLUMNS[key]) for key in OF_MEMBER} | {"seconds": seconds_of(row)}


def quartiles(values: Sequence[float] | np.ndarray) -> tuple[float, float, float]:
    """Lower quartile, median, upper quartile."""
    low, median, high = np.percentile(values, [25.0, 50.0, 75.0])
    return float(low), float(median), float(high)


def spreads_of(members: Sequence[RunRow], finest: Sequence[RunRow]) -> dict[str, EnsembleSpread]:
    """Medians, quartiles and biases of a setting's members."""
    out = {}
    for key in MEASURES:
        own, best = (np.array([row.number(COLUMNS[key]) for row in group], dtype=float) for group in (members, finest))
        (low, median, high), (least, aim, most) = quartiles(own), quartiles(best)
        matters = max(MATTERS * abs(aim), LEAST_DRIFT if key == "drift" else LEAST_LENGTH)
        out[key] = EnsembleSpread(low, median, high, median - aim, max(high - low, most - least), chance(own, best), matters)
    return out


def chance(sample: np.ndarray, other: np.ndarray) -> float:
    """The chance that two samples of one distribution lie as far apart, 1 where they are the same."""
    from scipy.stats import mannwhitneyu

    if np.array_equal(np.sort(sample), np.sort(other)):
        return 1.0
    return float(mannwhitneyu(sample, other).pvalue)


def good_enough(rows: Sequence[EnsembleRow]) -> EnsembleRow:
    """The cheapest setting that shows no bias; the finest one shows none by itself."""
    return min((row for row in rows if not row.is_biased), key=lambda row: row.seconds[1])


def measured(title: str, rows: Sequence[EnsembleRow]) -> Measurement:
    """Return the measurement of ensembles; filled points show no bias against the finest setting, whose quartiles are the pale strip."""
    heading, count = f"Error against run time, by ensembles: {title}", len(rows[0].members)
    facts = f"{count} members each: median and quartiles; strip: quartiles of the finest setting; hollow: a bias shows; labels: tolerance"
    panels = [_panel(rows, key) for key in LENGTHS]
    diagram = PanelSheet(f"Error against run time: {title}", facts, "processor time of a run, median [s]", panels)
    return Measurement(heading, [row.cells for row in rows], [row.read for row in rows], lines_of(title, rows), _warnings(rows), diagram)


def _panel(rows: Sequence[EnsembleRow], key: str) -> TimePanel:
    """A length over the processor time, a line per solver and time step."""
    factor = LENGTHS[key].shown[1]
    best, lines = rows[-1].spreads[key], dict[str, list[Point]]()
    for row in sorted(rows, key=lambda row: -row.setting.tolerance):
        spread, (low, middle, high) = row.spreads[key], row.seconds
        bar = (factor * spread.low, factor * spread.high)
        point = Point(middle, factor * spread.median, spread.is_biased, exponent(row.setting.tolerance), (low, high), bar)
        lines.setdefault(f"{row.setting.solver}, dt {1e3 * row.setting.dt:g} ms", []).append(point)
    return TimePanel(LENGTHS[key].title, list(lines.items()), (factor * best.low, factor * best.median, factor * best.high))


def lines_of(title: str, rows: Sequence[EnsembleRow]) -> list[str]:
    """The ensembles as text, the last line says which setting is good enough."""
    finest, count, best = rows[-1], len(rows[0].members), good_enough(rows)
    seen = 1.96 * math.sqrt(2.0 / count)
    lines = [
        f"{title}: {len(rows)} settings of {count} members, whose amplitudes differ by {SIZE:g}",
        "; ".join([f"finest, {finest.setting}", *(_spread(finest, key) for key in LENGTHS), f"{in_words(finest.seconds[1])} of CPU a run"]),
    ]
    lines += [_bias_line(row) for row in rows[:-1]]
    lines.append(
        f"a bias shows where the chance is below {SHOWN:g} and it is more than {100 * MATTERS:g} %; {count} members miss one of {seen:.1f} "
        "standard deviations every other time"
    )
    if best is finest:
        lines.append(f"good enough: only the finest, {finest.setting}; all others show a bias" if len(rows) > 1 else "one setting: no bias")
        return lines
    costs = f"{in_words(best.seconds[1])} of the processor a run, where the finest takes {in_words(finest.seconds[1])}"
    return [*lines, f"good enough: {best.setting}: no bias shows, {costs}"]


def _spread(row: EnsembleRow, key: str) -> str:
    """``largest opening 2 mm (1.8 mm to 2.1 mm)``"""
    found = row.spreads[key]
    return f"{MEASURES[key].name} {length(found.median)} ({length(found.low)} to {length(found.high)})"


def _bias_line(row: EnsembleRow) -> str:
    """Where a setting is biased, and how that compares with its spread."""
    shown = [(MEASURES[key], spread) for key, spread in row.spreads.items() if spread.is_biased]
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
    return [
        f"{row.setting}: {row.missed} of {row.steps} steps missed the tolerance, the largest error is "
        f"{max(one.numbers['error_max'] for one in row.members):.1e}"
        for row in rows
        if row.missed
    ]
