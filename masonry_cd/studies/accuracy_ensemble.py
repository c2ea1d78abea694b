# SPDX-License-Identifier: GPL-3.0-or-later
r"""Error against run time where the motion amplifies rounding: ensembles of a run at every time step, tolerance and solver.

Under strong shaking one run is one sample, and two single runs say nothing of the setting between them. Here the amplitude of the base is
changed by 1e-9 from member to member, below what any tolerance resolves. A setting has the median and the quartiles of its members,

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

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.analysis.outputs import NUMBERS, SUMMARY, lengths_in
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene
from masonry_cd.studies.accuracy import NOTHING_DRAWN
from masonry_cd.studies.discarded import run_and_discard

PERTURBED = 1e-9  # of the amplitude, from member to member
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
LEAST = 4  # members: with three even samples that lie wholly apart have a chance of one in ten
SHOWN = 0.05  # a chance below this shows a bias ...
MATTERS = 0.02  # ... that is larger than this share of the finest median
LEAST_LENGTH = 1e-5  # [m], a tenth of the smallest crack that counts: biases below do not matter
LEAST_DRIFT = 1e-5  # its like of a drift
ASKED = (*NOTHING_DRAWN, "report.damage=true", "run.until_still=false", "run.threads=1")  # grades, runs of one length, a process each
LENGTHS = lengths_in(SUMMARY)
MEASURES = LENGTHS | {"drift": NUMBERS["residual_drift"]}  # by the keys that tables of this study have

Row = dict[str, Any]


class Setting(NamedTuple):
    """How a scene is run."""

    solver: str
    dt: float  # [s]
    tolerance: float

    def __str__(self) -> str:
        return f"{self.solver}, dt {1e3 * self.dt:g} ms, tolerance {self.tolerance:g}"


class Member(NamedTuple):
    """One run, as it is asked for."""

    scene: Path
    changes: tuple[str, ...]  # of its keys
    factor: float  # by which its base is shaken more


class Spread(NamedTuple):
    """A measure over the members of a setting."""

    low: float  # lower quartile
    median: float
    high: float  # upper quartile
    bias: float  # against the finest setting
    spread: float
    chance: float
    matters: float  # biases below do not

    @property
    def biased(self) -> bool:
        """Whether a bias shows that matters."""
        return self.chance < SHOWN and abs(self.bias) > self.matters

    @property
    def within(self) -> bool:
        """Whether the bias is smaller than the spread."""
        return abs(self.bias) <= self.spread


@dataclass(frozen=True, eq=False)
class EnsembleRow:
    """What a setting gave."""

    setting: Setting
    members: tuple[dict[str, Any], ...]  # of each run: MEASURES, grade, collapsed_blocks, steps, steps_missed, error_max, seconds
    spreads: dict[str, Spread]  # by measure
    finest: bool

    @property
    def biased(self) -> bool:
        """Whether a bias shows in any measure."""
        return any(spread.biased for spread in self.spreads.values())

    def quartiles(self, key: str) -> tuple[float, float, float]:
        """Of a number of the members."""
        low, middle, high = np.percentile([member[key] for member in self.members], [25.0, 50.0, 75.0])
        return float(low), float(middle), float(high)

    @property
    def seconds(self) -> float:
        """Of the processor, median of the members."""
        return self.quartiles("seconds")[1]


def settings_of(solvers: Sequence[str], dts: Sequence[float], tolerances: Sequence[float]) -> list[Setting]:
    """All settings, the finest of the first solver last."""
    asked = [
        Setting(solver, dt, tolerance) for solver in solvers for dt in sorted(dts, reverse=True) for tolerance in sorted(tolerances)[::-1]
    ]
    finest = Setting(solvers[0], min(dts), min(tolerances))
    return [*(setting for setting in asked if setting != finest), finest]


def members_of(scene: Path, changes: Sequence[str], setting: Setting, count: int) -> list[Member]:
    """The runs of an ensemble."""
    own = (f'run.solver="{setting.solver}"', f"run.dt={setting.dt!r}", f"run.tolerance={setting.tolerance!r}")
    return [Member(scene, (*changes, *ASKED, *own), 1.0 + PERTURBED * k) for k in range(count)]


def run_member(member: Member) -> Row:
    """Run it; what is kept of it.

    Raises:
        InputError: a scene that is wrong.
    """
    case = prepare(read_scene(member.scene, list(member.changes)))
    loading = replace(case.loading, support_velocity=member.factor * case.loading.support_velocity)
    summary = run_and_discard(replace(case, loading=loading))
    whole = summary["parts"][-1]
    found = {key: summary[key] for key in (*LENGTHS, "collapsed_blocks", "steps")}
    more = {key: summary["solver"][key] for key in ("steps_missed", "error_max")}
    return found | {"drift": whole["residual_drift"], "grade": whole["grade"]} | more | {"seconds": summary["processor"]}


def ensemble_rows(
    scene: Path, changes: Sequence[str], settings: Sequence[Setting], count: int, make: Callable[[Mapping[str, Member]], Mapping[str, Row]]
) -> list[EnsembleRow]:
    """Run ensembles of a scene: the first member of every setting, then the second of every one, and so on.

    Args:
        scene: its file.
        changes: of its keys, ``key=value``.
        settings: the finest last.
        count: members of each.
        make: makes runs, by their names.

    Raises:
        InputError: a scene that is wrong.
    """
    members = [members_of(scene, changes, setting, count) for setting in settings]
    names = [[f"{setting}, member {k + 1}" for k in range(count)] for setting in settings]
    found = make({names[i][k]: members[i][k] for k in range(count) for i in range(len(settings))})
    groups = [tuple(found[name] for name in group) for group in names]
    return [
        EnsembleRow(setting, group, spreads_of(group, groups[-1]), group is groups[-1])
        for setting, group in zip(settings, groups, strict=True)
    ]


def spreads_of(members: Sequence[dict[str, Any]], finest: Sequence[dict[str, Any]]) -> dict[str, Spread]:
    """Medians, quartiles and biases of a setting's members."""
    out = {}
    for key in MEASURES:
        own, best = (np.array([member[key] for member in group], dtype=float) for group in (members, finest))
        low, median, high = (float(value) for value in np.percentile(own, [25.0, 50.0, 75.0]))
        spread = max(high - low, float(np.subtract(*np.percentile(best, [75.0, 25.0]))))
        aim = float(np.median(best))
        matters = max(MATTERS * abs(aim), LEAST_DRIFT if key == "drift" else LEAST_LENGTH)
        out[key] = Spread(low, median, high, median - aim, spread, chance(own, best), matters)
    return out


def chance(sample: np.ndarray, other: np.ndarray) -> float:
    """The chance that two samples of one distribution lie as far apart, 1 where they are the same."""
    from scipy.stats import mannwhitneyu

    if np.array_equal(np.sort(sample), np.sort(other)):
        return 1.0
    return float(mannwhitneyu(sample, other).pvalue)


def good_enough(rows: Sequence[EnsembleRow]) -> EnsembleRow:
    """The cheapest setting that shows no bias; the finest one shows none by itself."""
    return min((row for row in rows if not row.biased), key=lambda row: row.seconds)
