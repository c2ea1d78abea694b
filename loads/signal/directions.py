# SPDX-License-Identifier: GPL-3.0-or-later
r"""Which number of a motion in several components counts: that of one axis, or one of both horizontal components, x and y.

    x, y, z             the component along this axis
    geometric_mean      sqrt(m_x m_y)
    larger              max(m_x, m_y)
    rotd50, rotd100     the median and the largest of m over all directions: of a(theta) = a_x cos(theta) + a_y sin(theta),
                        theta = 0, 1 .. 179 degrees (Boore, Bull. Seism. Soc. Am. 100(4), 2010)

Both components begin at the same instant and have the same time step. RotD is taken period by period where a measure has several:
no single direction need be the median one at all of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Annotated

import numpy as np
from pydantic import AfterValidator

from loads.signal.baseline import GroundHistory
from masonry_cd.foundation.errors import InputError, suggest

ANGLES = np.radians(np.arange(180.0))
AXES = ("x", "y", "z")

PAIRS: dict[str, Callable[[float, float], float]] = {"geometric_mean": lambda x, y: math.sqrt(x) * math.sqrt(y), "larger": max}
ROTATED: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "rotd50": lambda values: np.sort(values, axis=-1)[..., 89:91].mean(axis=-1),
    "rotd100": lambda values: values.max(axis=-1),
}
RULES = (*AXES, *PAIRS, *ROTATED)


def _known(value: str) -> str:
    if value not in RULES:
        raise ValueError(f'unknown "{value}"{suggest(value, RULES)}; one of {", ".join(RULES)}')
    return value


Rule = Annotated[str, AfterValidator(_known)]

Components = Mapping[str, GroundHistory]
"""The components of a motion by their axes, "x", "y", "z"."""


def component(motion: Components, axis: str, what: str) -> GroundHistory:
    """The component along an axis.

    Raises:
        InputError: the motion has none; names the measure it is wanted for.
    """
    if axis not in motion:
        raise InputError(what, f"the motion has no component {axis}, only {', '.join(motion) or 'none'}")
    return motion[axis]


def horizontal(motion: Components, what: str) -> tuple[GroundHistory, GroundHistory]:
    """The components x and y, alike in time step and length.

    Raises:
        InputError: one is missing, or they differ; names the measure they are wanted for.
    """
    x, y = component(motion, "x", what), component(motion, "y", what)
    if x.step != y.step or len(x.acceleration) != len(y.acceleration):
        sizes = [f"{len(c.acceleration)} samples of {c.step:g} s" for c in (x, y)]
        raise InputError(what, f"the components x and y differ, {sizes[0]} and {sizes[1]}: give both the same window and time step")
    return x, y


def rotated(x: GroundHistory, y: GroundHistory, angle: float) -> GroundHistory:
    """The motion along a direction of the horizontal plane, ``angle`` [rad] from x towards y."""
    c, s = math.cos(angle), math.sin(angle)
    return GroundHistory(
        x.step,
        c * x.acceleration + s * y.acceleration,
        c * x.velocity + s * y.velocity,
        c * x.displacement + s * y.displacement,
    )
