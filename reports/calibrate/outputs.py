# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that the reports give to a calibration: calibrate.json, samples.csv, the picture and the page."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.analysis.calibration.observations import SEEN
from masonry_cd.analysis.calibration.posterior import Posterior
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.foundation import own_files
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.json_files import write_json
from masonry_cd.foundation.quantities import counted
from reports.calibrate.motion_picture import MAP, draw_motion_likelihood
from reports.calibrate.picture import PICTURE, draw_posterior
from reports.page.document import Head, pictures, rows_of_many, write_document
from reports.study.tables import DIGITS

JSON, CSV, PAGE = "calibrate.json", "samples.csv", "calibrate.html"
FILES = files_of("calibrate")
CAPTION = (
    "On the diagonal: each unknown before (grey) and after (blue) the observations, with its 5, 50 and 95 % quantiles. Below it: the "
    "samples of each pair of unknowns, larger where their weight is larger. To the right: each observation in standard deviations of its "
    "error; grey is the prediction before, blue that of the posterior, 5 to 95 %, and the diamond with its bar is the observation."
)
OF_MAP = (
    "The likelihood of the motion relative to its largest value, averaged over all other unknowns. The lines enclose 50 and 90 % of the "
    "posterior; the cross is the likeliest motion within the first, and dots are the samples, larger where their weight is larger. White: "
    "no samples."
)
UNKNOWN = ("unknown", "unit", "5 %", "50 %", "95 %", "mean", "std", "before: 5 %", "95 %", "learnt")
OBSERVED = ("observation", "observed", "error", "predicted: 5 %", "50 %", "95 %", "before: 5 %", "95 %", "off [std]", "helps [%]")
READ = (
    "The weight of a sample is its prior times its likelihood over the density from which it was drawn, of all rounds together. Off: the "
    "distance of an observation from the mean prediction, over the standard deviation of error and prediction. Helps: the share of the "
    "variance of the unknowns, on average, that one more such observation would remove if the model were linear."
)


def write_posterior(found: Posterior, folder: Path) -> list[Path]:
    """Write what a posterior says; the picture only where it is an answer."""
    own_files.begin(folder, FILES)
    own_files.remove(folder, (PICTURE, MAP))
    write_json(folder / JSON, found.as_dict(), DIGITS)
    titles = [one.title for one in found.observations]
    columns = [found.rounds.tolist(), found.weights.tolist(), *found.unknowns.values(), *found.predicted.T.tolist()]
    write_csv(folder / CSV, ["round", "weight", *found.unknowns, *titles], zip(*columns, strict=True), DIGITS)
    drawn = {} if found.refused else {folder / PICTURE: CAPTION}
    if drawn:
        draw_posterior(found, folder / PICTURE)
    if drawn and found.map is not None:
        draw_motion_likelihood(found, found.map, folder / MAP)
        drawn = {folder / MAP: OF_MAP} | drawn
    write_page(found, drawn, folder / PAGE)
    return [folder / name for name in (JSON, CSV, PICTURE, MAP, PAGE) if (folder / name).exists()]


def write_page(found: Posterior, drawn: Mapping[Path, str], path: Path) -> None:
    """Write calibrate.html."""
    tiles = [
        ("samples", len(found.weights), f" in {counted(len(found.sizes), 'round')}"),
        ("effective", f"{found.sizes[-1]:.3g}", f" at least {found.enough:g}"),
        ("probability of a misfit this large", "none" if found.misfit is None else f"{found.misfit:.2g}", ""),
    ]
    varied = ", ".join(found.unknowns)
    write_document(
        path,
        "calibrate.html",
        title=f"{found.title}: what explains the observations",
        page=Head(
            found.title,
            ["Results", *found.lines[1:]],
            found.warnings,
            tiles,
            rows_of_many(found.scene, found.program, varied),
            found.verdict,
        ),
        drawn=pictures(drawn),
        unknown=UNKNOWN,
        unknowns=[_unknown(found, name, one) for name, one in found.ranges.items()],
        keys=("", *found.numbers),
        correlation=[[name, *(f"{value:.2f}" for value in row)] for name, row in zip(found.numbers, found.correlation, strict=True)],
        shares=[(name, ", ".join(f"{value} {100 * share:.0f} %" for value, share in of.items())) for name, of in found.shares.items()],
        observed=OBSERVED,
        observations=[_observation(one) for one in found.checks],
        assumed=[("how to read it", READ)],
    )


def _unknown(found: Posterior, name: str, one: Mapping[str, float]) -> list[str]:
    """The row of an unknown."""
    unit, factor = found.shown(name)
    numbers = (f"{factor * one[key]:.4g}" for key in ("low", "median", "high", "mean", "std", "prior_low", "prior_high"))
    return [name, unit, *numbers, "nothing" if name in found.unlearnt else "yes"]


def _observation(one: Mapping[str, Any]) -> list[str]:
    """The row of an observation."""
    value = "not yet" if one["value"] is None else ("yes" if one["value"] else "no") if one["what"] in SEEN else f"{one['value']:.4g}"
    numbers = [f"{one[key]:.4g}" for key in ("error", "low", "median", "high", "prior_low", "prior_high")]
    off, gain = (
        "" if one[key] is None else f"{factor * one[key]:{form}}" for key, factor, form in (("off", 1, "+.1f"), ("gain", 100, ".0f"))
    )
    return [one["name"], value, *numbers, off, gain]
