r"""Which tolerance of the solver leaves no bias: ensembles of the same run, at one tolerance after the other.

    python -m benchmarks.tolerance examples/aqueduct_sinusoidal.toml --tolerances 1e-3 1e-4 1e-5 --members 12 --workers 2

Under strong shaking the motion amplifies rounding, so that one run is one sample and two single runs say nothing of the tolerance between
them. Here the amplitude of the base is changed by 1e-9 from member to member, which is below what any tolerance resolves. What a row says
are medians and quartiles over its members, beside the chance that two samples of one distribution lie as far apart as these members and
those of the tightest tolerance do (the rank test of Mann & Whitney, Ann. Math. Stat. 18, 1947). A small chance, below one in twenty say,
means a bias: the error of the solver shows. A large one means that this many members show none.

Seconds are of the processor (others may use the machine) and include what a run writes.
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.ours import run_and_discard
from benchmarks.sitting import head, sitting
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene

PERTURBED = 1e-9  # of the amplitude, from member to member
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6)
ASKED = ("report.damage=true", "run.until_still=false")  # grades, and runs of one length
MEASURES = {"displacement_max": ("displacement", 1e3), "opening_max": ("opening", 1e3), "sliding_max": ("sliding", 1e3)}  # in [mm]


class Member(NamedTuple):
    """One run, as it is asked for."""

    scene: Path
    changes: tuple[str, ...]  # of its keys
    factor: float  # by which its base is shaken more


def run_member(member: Member) -> dict[str, Any]:
    """Run it; its summary, and the seconds of the processor."""
    case = prepare(read_scene(member.scene, member.changes))
    return run_and_discard(replace(case, loading=replace(case.loading, support_velocity=member.factor * case.loading.support_velocity)))


def members(scene: Path, changes: Sequence[str], tolerance: float, count: int) -> list[Member]:
    """The runs of an ensemble."""
    asked = (*changes, *ASKED, f"run.tolerance={tolerance!r}")
    return [Member(scene, asked, 1.0 + PERTURBED * k) for k in range(count)]


def chance(sample: np.ndarray, other: np.ndarray) -> float:
    """The chance that two samples of one distribution lie as far apart, 1 where they are the same."""
    from scipy.stats import mannwhitneyu

    if np.array_equal(np.sort(sample), np.sort(other)):
        return 1.0
    return float(mannwhitneyu(sample, other).pvalue)


def table_row(tolerance: float, runs: Sequence[dict[str, Any]], tightest: Sequence[dict[str, Any]]) -> str:
    """A line of the table."""
    cells = []
    for name, (_, scale) in MEASURES.items():
        own, best = (np.array([run[name] for run in group]) for group in (runs, tightest))
        low, middle, high = scale * np.percentile(own, [25.0, 50.0, 75.0])
        cells.append(f"{middle:.3g} ({low:.3g} to {high:.3g}), {chance(own, best):.2g}")
    grades = [run["parts"][-1]["grade"] for run in runs]
    counted = ", ".join(f"{grades.count(grade)} {grade}" for grade in sorted(set(grades)))
    missed = f"{100.0 * np.mean([run['solver']['steps_missed'] / run['steps'] for run in runs]):.2g}"
    step = f"{1e3 * np.median([run['processor'] / run['steps'] for run in runs]):.3g}"
    return f"| {tolerance:g} | " + " | ".join((*cells, counted, missed, step)) + " |"


def study(scene: Path, changes: Sequence[str], tolerances: Sequence[float], count: int, workers: int) -> list[str]:
    """The table, the tightest tolerance last."""
    ordered = sorted(tolerances, reverse=True)
    asked = [member for tolerance in ordered for member in members(scene, changes, tolerance, count)]
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        found = list(pool.map(run_member, asked))
    groups = [found[k : k + count] for k in range(0, len(found), count)]
    cells = [f"{words} [mm], chance" for words, _ in MEASURES.values()]
    lines = [head("tolerance", *cells, "grades", "steps missed [%]", "CPU per step [ms]")]
    return lines + [table_row(tolerance, group, groups[-1]) for tolerance, group in zip(ordered, groups, strict=True)]


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Which tolerance leaves no bias.")
    parser.add_argument("scene", type=Path)
    parser.add_argument("--tolerances", type=float, nargs="+", default=list(TOLERANCES))
    parser.add_argument("--members", type=int, default=8, help="of an ensemble")
    parser.add_argument("--workers", type=int, default=1, help="runs at a time")
    parser.add_argument("--set", dest="changes", action="append", default=[], metavar="KEY=VALUE", help="changes of the scene's keys")
    given = parser.parse_args(arguments)
    print(sitting())
    print("\n".join(study(given.scene, given.changes, given.tolerances, given.members, given.workers)))


if __name__ == "__main__":
    main()
