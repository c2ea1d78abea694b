# SPDX-License-Identifier: GPL-3.0-or-later
"""Calibrations of a column whose properties are known: how often they lie in the range of 90 % that is found.

    python -m benchmarks.calibration                                        # three frequencies, in rounds that adapt
    python -m benchmarks.calibration --cracks --samples 400 --rounds 6      # an opening, a slip and a displacement as well, by runs
    python -m benchmarks.calibration --study examples/attribute_columns.toml --samples 100    # which pulse

In each repetition modulus, shear modulus, friction and bond are drawn from what is thought possible. The column is observed with random
errors as large as stated, and shaken for one cycle where cracks count. Of a study file all that varies is drawn, and observed as it says.
A range of 90 % should have the truth in it in 18 of 20 repetitions.
All share a folder, so that the first round of samples is made once.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from masonry_cd.analysis.calibration.observations import SEEN, Observation
from masonry_cd.analysis.calibration.posterior import Posterior
from masonry_cd.app.result import silent
from masonry_cd.studies.calibrate.command import calibrate
from masonry_cd.studies.calibrate.plan import Calibration
from masonry_cd.studies.calibrate.predicted import PREDICTED, calibrate_task
from masonry_cd.studies.study.clusters import RunPlace, connected
from masonry_cd.studies.study.study_case import StudyOptions
from masonry_cd.studies.study.study_file import CalibrationTable, ReadStudy, parse_study, read_study
from masonry_cd.studies.study.task import Task

STUDY = """
title = "Column"
design = "calibrate"
samples = {samples}
seed = 1
calibration = {{ rounds = {rounds}, wanted = 80.0, least = 20.0 }}
[scene.structure]
kind = "column"
height = 1.5
diameter = 0.5
top_diameter = 0.5
drums = 3
sides = 4
plinth = 0.0
capital = 0.0
[scene.material]
friction = 0.35
masonry = {{ kind = "squared stone", E = 3e8, G = 1e8 }}
joints = {{ tension = 1e4, cohesion = 4e4, damping = 0.03 }}
[[scene.loads]]
kind = "sinusoidal"
direction = "x"
amplitude = 0.35
frequency = 2.5
cycles = 1
[scene.run]
dt = 4e-3
duration = 0.5
tolerance = 1e-6
[scene.output]
point = [{{ block = "drum3", name = "top" }}]
[vary]
"material.masonry.E" = {{ distribution = "lognormal", median = 3e8, beta = 0.25 }}
"material.masonry.G" = {{ distribution = "lognormal", median = 1e8, beta = 0.25 }}
"material.friction" = {{ distribution = "uniform", low = 0.25, high = 0.45 }}
"material.joints.tension" = {{ distribution = "uniform", low = 1e4, high = 6e4 }}
"""
FREQUENCIES = tuple(("frequency", f"mode = {k}", "share = {share}") for k in (1, 3, 4))
CRACKS = (
    ("quantity", 'quantity = "max_opening"', 'spread = "lognormal"\nshare = 0.2'),
    ("quantity", 'quantity = "max_sliding"', 'spread = "lognormal"\nshare = 0.3'),
    ("gauge", 'gauge = "top"\ncolumn = "ux"\nat = "largest"', "share = 0.2"),
)


def study(asked: argparse.Namespace) -> ReadStudy:
    """The study of a file, or of the column."""
    if asked.study is not None:
        given = read_study(asked.study)
        table = (given.tables.calibration or CalibrationTable()).model_copy(update={"rounds": asked.rounds})
        return replace(given, tables=given.tables.model_copy(update={"samples": asked.samples, "calibration": table}))
    text = STUDY.format(samples=asked.samples, rounds=asked.rounds)
    for what, of, error in FREQUENCIES + (CRACKS if asked.cracks else ()):
        text += f'[[observations]]\nwhat = "{what}"\n{of}\n{error.format(share=asked.share)}\n'
    return parse_study(text, Path("calibration.toml").absolute(), "calibration")


def observing(of: ReadStudy, values: Sequence[float | bool | None]) -> Calibration:
    """The calibration with other values of its observations; None where one is only predicted."""
    pairs = zip(of.tables.observations, values, strict=True)
    observations = [one.model_copy(update={"value": value}) for one, value in pairs]
    return Calibration.of(replace(of, tables=of.tables.model_copy(update={"observations": observations})))


def truth(of: ReadStudy, repetition: int) -> tuple[dict[str, float], list[float | bool]]:
    """The properties of a repetition, and what is observed then."""
    draw = np.random.default_rng((repetition, 7))
    blank = observing(of, [None] * len(of.tables.observations))
    asked = blank.asked(draw.random(len(blank.places)))
    row = calibrate_task(blank.wanted, Task("truth", blank.maker.tables(asked), 600.0)).row
    predicted = row.number(PREDICTED)
    observed = [_with_error(one, float(predicted[one.title]), draw) for one in blank.wanted.observations]
    return {name: float(value) for name, value in asked.values.items()}, observed


def _with_error(one: Observation, value: float, draw: np.random.Generator) -> float | bool:
    """A value as it is observed."""
    if one.what in SEEN:
        return bool(value) != bool(draw.random() < one.deviation(0.0))
    s, error = one.deviation(value), draw.standard_normal()
    return float(value * np.exp(s * error) if one.spread == "lognormal" else value + s * error)


def main() -> None:
    """Print a line for each repetition, and how often the truth was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--study", type=Path, help="a study file instead of the column")
    parser.add_argument("--repetitions", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="number of the first repetition")
    parser.add_argument("--samples", type=int, default=60, help="of a round")
    parser.add_argument("--rounds", type=int, default=8, help="at most")
    parser.add_argument("--share", type=float, default=0.03, help="error of the frequencies")
    parser.add_argument("--cracks", action="store_true", help="observe cracks as well")
    parser.add_argument("--folder", type=Path, help="of the runs, which are not made again")
    asked = parser.parse_args()
    inside, answered = dict[str, int](), 0
    with TemporaryDirectory() as scratch, connected(RunPlace(workers=2)) as (client, _):
        folder = asked.folder or Path(scratch) / "out"
        of = study(asked)
        samples = of.tables.samples or 1
        for k in range(asked.first, asked.first + asked.repetitions):
            begin, (values, observed) = time.perf_counter(), truth(of, k)
            plan = observing(of, observed)
            found = calibrate(
                plan, folder, StudyOptions(RunPlace(scheduler=str(client.scheduler_info()["address"])), quiet=True), silent
            ).value
            if not isinstance(found, Posterior):
                raise SystemExit(f"{k}: interrupted")
            if found.refused:
                print(f"{k}: refused, {found.refused}", flush=True)
                continue
            answered += 1
            seen = {name: found.ranges[name]["low"] <= value <= found.ranges[name]["high"] for name, value in values.items()}
            inside = {name: inside.get(name, 0) + there for name, there in seen.items()}
            before = {name: float(np.std(values[:samples])) for name, values in found.numbers.items()}
            narrowed = ", ".join(f"{name.rpartition('.')[2]} {one['std'] / before[name]:.2f}" for name, one in found.ranges.items())
            off, size = [name for name, there in seen.items() if not there], f"{found.sizes[-1]:.0f} of {len(found.weights)} samples"
            took = time.perf_counter() - begin
            missed = f"outside: {', '.join(off) or 'none'}"
            print(f"{k}: {size}, misfit {found.misfit:.2f}; std after over before: {narrowed}; {missed}; {took:.0f} s", flush=True)
    print(f"inside of {answered} answers: " + ", ".join(f"{name} {count}" for name, count in inside.items()))


if __name__ == "__main__":
    main()
