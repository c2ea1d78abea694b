# SPDX-License-Identifier: GPL-3.0-or-later
r"""The tables of a study: fragility.csv, fragility.json, sensitivity.csv, and the fragility model that OpenQuake reads.

OpenQuake reads NRML 0.5, a continuous lognormal
``fragilityModel`` (reference manual of the OpenQuake Engine, fragility models). Its parameters are mean and standard deviation of the
intensity at which a limit state is exceeded, not of its logarithm:

    mean = theta exp(beta^2 / 2),      stddev = mean sqrt(exp(beta^2) - 1)
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from masonry_cd.analysis.fragility.fits import Fit
from masonry_cd.analysis.fragility.measures import Imt, openquake, unit
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import one_line

DIGITS = 6  # of numbers, so that a processor that rounds otherwise writes the same file
CROSSED = 1e-3  # probability by which a graver limit state may be reached more often than a lighter one, less than any study knows
LEVELS = 20  # intensities of a vulnerability function
SPACE = "http://openquake.org/xmlns/nrml/0.5"
COLUMNS_OF_FITS = (
    "limit_state", "measure", "method", "theta", "beta", "theta_low", "theta_high", "beta_low", "beta_high", "runs", "exceeded",
)  # fmt: skip


def row_of(fit: Fit) -> dict[str, Any]:
    """A fit as a row of fragility.csv."""
    numbers = (fit.theta, fit.beta, *fit.theta_band, *fit.beta_band)
    return dict(zip(COLUMNS_OF_FITS, (fit.limit.name, fit.measure, fit.method, *numbers, fit.runs, fit.exceeded), strict=True))


def entry_of(fit: Fit) -> dict[str, Any]:
    """A fit in fragility.json: its band, the parts of beta, quantiles of IDA."""
    more: dict[str, Any] = {"state": str(fit.curve.state[0]), "unit": unit(fit.measure), "meaning": fit.limit.in_words()}
    more |= fit.betas.as_dict()
    if fit.found is not None:
        names = ("p16", "p50", "p84")
        more["capacity_quantiles"] = dict(zip(names, fit.quantiles, strict=True))
        more["capacities"] = {"never_exceeded": int(fit.found.above.sum()), "always_exceeded": int(fit.found.below.sum())}
    imt = openquake(fit.measure)
    if fit.is_fitted and imt is not None:
        mean, stddev = mean_and_stddev(fit.theta * imt.factor, fit.beta)
        more["nrml"] = {"imt": imt.name, "unit": imt.unit, "mean": mean, "stddev": stddev}
    return row_of(fit) | more


def mean_and_stddev(theta: float, beta: float) -> tuple[float, float]:
    """Mean and standard deviation of a lognormal variable of a median and a standard deviation of its logarithm."""
    mean = theta * math.exp(0.5 * beta**2)
    return mean, mean * math.sqrt(math.expm1(beta**2))


def write_openquake(path: Path, title: str, fits: Sequence[Fit]) -> list[str]:
    """Write fragility.xml where there are fits and OpenQuake has their measure, in the order in which they are reached; return warnings."""
    chosen = sorted((fit for fit in fits if fit.beta > 0), key=lambda fit: fit.theta)
    if not chosen:
        return []
    imt = openquake(chosen[0].measure)
    if imt is None:
        return [f"fragility.xml is not written: OpenQuake has no known name for {chosen[0].measure}"]
    root, model, name = _model("fragilityModel", title, imt)
    names = [re.sub(r"\W+", "_", fit.limit.name) for fit in chosen]
    Xml.SubElement(model, f"{{{SPACE}}}limitStates").text = " ".join(names)
    function = Xml.SubElement(model, f"{{{SPACE}}}fragilityFunction", id=name, format="continuous", shape="logncdf")
    low, high = (imt.factor * float(end([end(fit.intensity) for fit in chosen])) for end in (np.min, np.max))
    Xml.SubElement(function, f"{{{SPACE}}}imls", imt=imt.name, noDamageLimit="0", minIML=f"{low:.6g}", maxIML=f"{high:.6g}")
    for word, fit in zip(names, chosen, strict=True):
        mean, stddev = mean_and_stddev(fit.theta * imt.factor, fit.beta)
        Xml.SubElement(function, f"{{{SPACE}}}params", ls=word, mean=f"{mean:.6g}", stddev=f"{stddev:.6g}")
    _write(root, path)
    return []


def write_vulnerability(path: Path, title: str, fits: Sequence[Fit], ratios: Mapping[str, float]) -> list[str]:
    """Write vulnerability.xml: at LEVELS intensities the probability of each loss ratio, that of the gravest limit state reached.

    Nothing without ratios, or where OpenQuake has no name for the measure; return warnings.
    """
    chosen = sorted((fit for fit in fits if fit.beta > 0 and fit.limit.name in ratios), key=lambda fit: ratios[fit.limit.name])
    imt = openquake(chosen[0].measure) if chosen else None
    if not ratios or imt is None:
        return []
    if lost := [name for name in ratios if name not in {fit.limit.name for fit in chosen}]:
        return [f"vulnerability.xml is not written: there is no fit of {', '.join(lost)}"]
    low, high = (float(end([end(fit.intensity) for fit in chosen])) for end in (np.min, np.max))
    levels = np.geomspace(low, high, LEVELS)
    over = np.vstack([np.ones(LEVELS), *(fit.curve.probability(levels)[0] for fit in chosen), np.zeros(LEVELS)])
    shares = -np.diff(np.minimum.accumulate(over, axis=0), axis=0)  # tails of two lognormals cross somewhere
    if (np.diff(over, axis=0) > CROSSED).any():
        return ["vulnerability.xml is not written: the fragilities cross, so a more severe limit state would be reached more often"]
    root, model, name = _model("vulnerabilityModel", title, imt)
    function = Xml.SubElement(model, f"{{{SPACE}}}vulnerabilityFunction", id=name, dist="PM")
    Xml.SubElement(function, f"{{{SPACE}}}imls", imt=imt.name).text = " ".join(f"{imt.factor * level:.6g}" for level in levels)
    for ratio, row in zip([0.0, *(ratios[fit.limit.name] for fit in chosen)], shares, strict=True):
        Xml.SubElement(function, f"{{{SPACE}}}probabilities", lr=f"{ratio:.6g}").text = " ".join(f"{share:.6g}" for share in row)
    _write(root, path)
    return []


def _model(kind: str, title: str, imt: Imt) -> tuple[Xml.Element, Xml.Element, str]:
    """The root of an NRML file, its model of a kind with a description, and the name of both."""
    Xml.register_namespace("", SPACE)
    root = Xml.Element(f"{{{SPACE}}}nrml")
    name = re.sub(r"\W+", "_", title).strip("_") or "study"
    model = Xml.SubElement(root, f"{{{SPACE}}}{kind}", id=name, assetCategory="buildings", lossCategory="structural")
    Xml.SubElement(model, f"{{{SPACE}}}description").text = f"{one_line(title)}; {imt.name} in {imt.unit}"
    return root, model, name


def _write(root: Xml.Element, path: Path) -> None:
    """Write an NRML file."""
    Xml.indent(root)
    with replacing(path) as part:
        Xml.ElementTree(root).write(part, encoding="utf-8", xml_declaration=True)
