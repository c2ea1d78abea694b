# SPDX-License-Identifier: GPL-3.0-or-later
"""How many runs a fragility takes: stripes chosen one batch after the other, whole stripes of fewer motions, and the fit to all runs.

    python -m benchmarks.adaptive_fragility STUDY FOLDER [--limit-state collapse] [--seeds 100]

STUDY is a study file with the design "stripes", such as that of ``benchmarks.study_arch``, FOLDER what ``masonry-cd study`` made of it.
Nothing is run: the choice is made again from the rows there, once for each seed, which shuffles the motions. The error is that of theta
and beta against the fit to all rows, root mean square over the seeds; the run from which on it stays below 5 and 10 % is said. In a second
part the outcomes are draws of the lognormal that was fitted, so that all runs together are no truth; where rows are missing it is the only
one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.special import ndtr

from benchmarks.sitting import head
from masonry_cd.analysis.fragility.fragility import fit_counts
from masonry_cd.analysis.fragility.limits import LimitState
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.adaptive import AdaptiveStripes
from masonry_cd.studies.study.designs import Space
from masonry_cd.studies.study.folder import StudyFolder
from masonry_cd.studies.study.study_case import plan_of
from masonry_cd.studies.study.study_file import AdaptiveTable

Pair = tuple[str, float]  # of a motion and a level
Outcome = Callable[[Pair], bool | None]
STRICT = 1e-6  # accuracy at which the choice never ends of itself
BOUNDS = (0.05, 0.10)


def fitted(levels: np.ndarray, known: dict[Pair, bool | None]) -> np.ndarray:
    """Theta and beta (2,) by some runs; nan where they carry no fit."""
    exceeded = [sum(over is True for (_, at), over in known.items() if at == level) for level in levels]
    runs = [sum(over is not None for (_, at), over in known.items() if at == level) for level in levels]
    found = fit_counts(levels, np.array([exceeded], dtype=float), np.array([runs], dtype=float))
    return np.array([found.theta[0], found.beta[0]])


def adaptive(space: Space, table: AdaptiveTable, outcome: Outcome) -> dict[int, np.ndarray]:
    """Theta and beta after each batch, by the number of runs."""
    chosen = AdaptiveStripes(space, table)
    batch, out = chosen.first(), {}
    while batch:
        following = []
        for asked in batch:
            assert asked.level is not None
            following = chosen.after(asked, outcome((asked.motion, asked.level)))
        out[len(chosen.known)] = fitted(chosen.levels, chosen.known)
        batch = following
    return out


def whole(space: Space, outcome: Outcome, seed: int) -> dict[int, np.ndarray]:
    """Theta and beta of every level under the first motions of a shuffled list, by the number of runs."""
    levels = np.array([level for level in space.levels if level is not None])
    known: dict[Pair, bool | None] = {}
    out = {}
    for motion in np.random.default_rng(seed).permutation(space.motions):
        known |= {(str(motion), float(level)): outcome((str(motion), float(level))) for level in levels}
        out[len(known)] = fitted(levels, known)
    return out


def enough(errors: dict[int, np.ndarray], bound: float) -> list[str]:
    """The number of runs from which on the errors of theta and of beta stay below a bound."""
    counts = sorted(errors)
    out = []
    for which in range(2):
        above = [n for n in counts if not errors[n][which] <= bound]
        rest = [n for n in counts if not above or n > above[-1]]
        out.append(str(rest[0]) if rest else f"over {counts[-1]}")
    return out


def root_mean_square(found: list[dict[int, np.ndarray]], truth: np.ndarray) -> dict[int, np.ndarray]:
    """Relative errors (2,) of theta and beta over the seeds, by the number of runs; a run without a fit is off by all of it."""
    common = set.intersection(*(set(one) for one in found))
    return {
        n: np.sqrt(np.mean([np.nan_to_num(np.minimum(np.abs(one[n] / truth - 1.0), 1.0), nan=1.0) ** 2 for one in found], axis=0))
        for n in sorted(common)
    }


def main() -> int:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Runs that a fragility takes.")
    parser.add_argument("study", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--limit-state", default="collapse")
    parser.add_argument("--seeds", type=int, default=100)
    given = parser.parse_args()
    try:
        plan = plan_of(given.study)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    rows, space = StudyFolder(given.folder).finished(False), plan.maker.space
    done = {name for name, row in rows.items() if row.done}
    state = LimitState.of(given.limit_state, space.tables.limit_states[given.limit_state])
    made = {(run.asked.motion, float(run.asked.level or 0.0)): state.exceeded_by(rows[run.name]) for run in plan.runs if run.name in done}
    every = [(run.asked.motion, float(run.asked.level or 0.0)) for run in plan.runs]
    levels = np.array([level for level in space.levels if level is not None])
    truth = fitted(levels, made)
    print(f"{given.limit_state}, {len(made)} of {len(every)} runs: theta {truth[0]:.4g}, beta {truth[1]:.3g}")
    table = AdaptiveTable(limit_state=given.limit_state, theta=STRICT, beta=STRICT)
    print(head("outcomes", "choice", *(f"{name} to {100 * bound:g} %" for bound in BOUNDS for name in ("theta", "beta"))))
    for name in ("rows", "draws") if len(made) == len(every) else ("draws",):
        found: dict[str, list[dict[int, np.ndarray]]] = {"adaptive": [], "whole stripes": []}
        for seed in range(given.seeds):
            rng = np.random.default_rng(seed)
            drawn = {pair: bool(rng.random() < ndtr(np.log(pair[1] / truth[0]) / truth[1])) for pair in every}
            known = made if name == "rows" else drawn
            own = replace(space, tables=space.tables.model_copy(update={"seed": seed}))
            found["adaptive"].append(adaptive(own, table, known.__getitem__))
            found["whole stripes"].append(whole(own, known.__getitem__, seed))
        for choice, each in found.items():
            errors = root_mean_square(each, truth)
            cells = [count for bound in BOUNDS for count in enough(errors, bound)]
            print(f"| {' | '.join([name, choice, *cells])} |", flush=True)
            for n in (40, 80, 120, 160, 200, 240, 320, 400):
                if n in errors:
                    print(f"  {n} runs: theta {100 * errors[n][0]:.1f} %, beta {100 * errors[n][1]:.1f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
