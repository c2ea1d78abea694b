# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of a study: fragility.csv, fragility.json, sensitivity.csv, and the fragility model that OpenQuake reads.

Numbers have six digits, so that a processor that rounds otherwise writes the same file.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from masonry_cd.analysis.fragility.fits import Fit, Fits
from masonry_cd.analysis.fragility.measures import openquake, unit
from masonry_cd.analysis.fragility.sensitivity import COLUMNS, Correlation
from masonry_cd.analysis.fragility.words import first_fits
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from reports.study.nrml import Curve, mean_and_stddev, write_nrml

COLUMNS_OF_FITS = (
    "limit_state", "measure", "method", "theta", "beta", "theta_low", "theta_high", "beta_low", "beta_high", "runs", "exceeded",
)  # fmt: skip


def row_of(fit: Fit) -> dict[str, Any]:
    """A fit as a row of fragility.csv."""
    numbers = (fit.theta, fit.beta, *fit.theta_band, *fit.beta_band)
    return dict(zip(COLUMNS_OF_FITS, (fit.limit.name, fit.measure, fit.method, *numbers, fit.runs, fit.exceeded), strict=True))


def write_fragility_csv(path: Path, fits: Sequence[Fit]) -> None:
    """Write fragility.csv; what could not be fitted has empty cells."""
    write_csv(path, COLUMNS_OF_FITS, (row_of(fit).values() for fit in fits), digits=6)


def write_sensitivity(path: Path, rows: Sequence[Correlation]) -> None:
    """Write sensitivity.csv."""
    write_csv(path, COLUMNS, rows, digits=6)


def write_fragility_json(path: Path, fits: Fits) -> None:
    """Write fragility.json: the fits, their bands, the parts of beta, quantiles of IDA, and the warnings."""
    found = {"format": 1, "fits": [_entry(fit) for fit in fits.fits], "warnings": list(fits.warnings)}
    write_json(path, found)


def write_json(path: Path, found: Mapping[str, Any]) -> None:
    """Write a file of JSON; what is no finite number becomes null."""
    with replacing(path) as part:
        part.write_text(json.dumps(plain(found), indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")


def plain(value: Any) -> Any:
    """A value as JSON can hold it, floats with six digits."""
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return float(f"{value:.6g}") if math.isfinite(value) else None
    return value


def _entry(fit: Fit) -> dict[str, Any]:
    """A fit in JSON."""
    more: dict[str, Any] = {"state": str(fit.curve.state[0]), "unit": unit(fit.measure), "meaning": fit.limit.in_words()}
    more |= fit.betas.as_dict()
    if fit.found is not None:
        names = ("p16", "p50", "p84")
        more["capacity_quantiles"] = dict(zip(names, fit.quantiles, strict=True))
        more["capacities"] = {"never_exceeded": int(fit.found.above.sum()), "always_exceeded": int(fit.found.below.sum())}
    imt = openquake(fit.measure)
    if fit.fitted and imt is not None:
        mean, stddev = mean_and_stddev(fit.theta * imt.factor, fit.beta)
        more["nrml"] = {"imt": imt.name, "unit": imt.unit, "mean": mean, "stddev": stddev}
    return row_of(fit) | more


def write_openquake(path: Path, title: str, fits: Sequence[Fit]) -> list[str]:
    """Write fragility.xml where there are fits and OpenQuake has their measure; return warnings."""
    chosen = [fit for fit in first_fits(fits) if fit.beta > 0]
    if not chosen:
        return []
    imt = openquake(chosen[0].measure)
    if imt is None:
        return [f"fragility.xml: what OpenQuake calls {chosen[0].measure} is not known: not written"]
    curves = [Curve(fit.limit.name, fit.theta * imt.factor, fit.beta) for fit in chosen]
    every = [value * imt.factor for fit in chosen for value in (float(fit.intensity.min()), float(fit.intensity.max()))]
    write_nrml(path, title, curves, imt, (min(every), max(every)))
    return []
