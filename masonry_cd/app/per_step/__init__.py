# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers that a run records in every step, each one declaration: a dataset of result.h5 and a column of ``run.steps``.

A module here lists its own in ``QUANTITIES``, by the name of the dataset; so a new quantity is one new file here and its test.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from masonry_cd.foundation.extensions import Entries

if TYPE_CHECKING:
    from masonry_cd.mechanics.dynamics.moreau_jean import Stepper, StepReport


class MadeStep(NamedTuple):
    """A step that was made."""

    stepper: Stepper
    report: StepReport
    load_step: int  # the step of the loads that it applied


@dataclass(frozen=True)
class Quantity:
    """A number of a step."""

    value: Callable[[MadeStep], float]
    meaning: str
    unit: str = ""
    whole: bool = False  # a count


QUANTITIES: Entries[Quantity] = Entries("masonry_cd.app.per_step", "QUANTITIES")
