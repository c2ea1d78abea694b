# SPDX-License-Identifier: GPL-3.0-or-later
r"""Fragilities as OpenQuake reads them: NRML 0.5, a continuous lognormal ``fragilityModel``.

The format is that of the OpenQuake Engine's reference manual, section on fragility models. Its parameters are mean and standard deviation
of the intensity at which a limit state is exceeded, not of its logarithm:

    mean = theta exp(beta^2 / 2),      stddev = mean sqrt(exp(beta^2) - 1)
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as Xml

from masonry_cd.analysis.fragility.measures import Imt
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import one_line

SPACE = "http://openquake.org/xmlns/nrml/0.5"


class Curve(NamedTuple):
    """A limit state with its lognormal, in the unit of the measure as OpenQuake takes it."""

    limit_state: str
    theta: float
    beta: float


def mean_and_stddev(theta: float, beta: float) -> tuple[float, float]:
    """Mean and standard deviation of a lognormal variable of a median and a standard deviation of its logarithm."""
    mean = theta * math.exp(0.5 * beta**2)
    return mean, mean * math.sqrt(math.expm1(beta**2))


def write_nrml(path: Path, title: str, curves: Sequence[Curve], imt: Imt, range_of: tuple[float, float]) -> None:
    """Write the limit states of one structure, from the one that is reached first.

    Args:
        path: of the file.
        title: of the study.
        curves: one per limit state.
        imt: the intensity measure.
        range_of: least and largest intensity of the runs, in the unit of ``imt``.
    """
    Xml.register_namespace("", SPACE)
    root = Xml.Element(f"{{{SPACE}}}nrml")
    name = re.sub(r"\W+", "_", title).strip("_") or "study"
    model = Xml.SubElement(root, f"{{{SPACE}}}fragilityModel", id=name, assetCategory="buildings", lossCategory="structural")
    Xml.SubElement(model, f"{{{SPACE}}}description").text = f"{one_line(title)}; {imt.name} in {imt.unit}"
    ordered = sorted(curves, key=lambda curve: curve.theta)
    names = [re.sub(r"\W+", "_", curve.limit_state) for curve in ordered]
    Xml.SubElement(model, f"{{{SPACE}}}limitStates").text = " ".join(names)
    function = Xml.SubElement(model, f"{{{SPACE}}}fragilityFunction", id=name, format="continuous", shape="logncdf")
    low, high = range_of
    Xml.SubElement(function, f"{{{SPACE}}}imls", imt=imt.name, noDamageLimit="0", minIML=f"{low:.6g}", maxIML=f"{high:.6g}")
    for word, curve in zip(names, ordered, strict=True):
        mean, stddev = mean_and_stddev(curve.theta, curve.beta)
        Xml.SubElement(function, f"{{{SPACE}}}params", ls=word, mean=f"{mean:.6g}", stddev=f"{stddev:.6g}")
    Xml.indent(root)
    with replacing(path) as part:
        Xml.ElementTree(root).write(part, encoding="utf-8", xml_declaration=True)
