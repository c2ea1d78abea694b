# SPDX-License-Identifier: GPL-3.0-or-later
"""The laws that a joint obeys together, and what a module of this package says of its one: a :class:`Law`.

The kernels that solve a law are apart, in ``masonry_cd/mechanics/dynamics``. All else is said here: its keys of ``[material.joints]`` with
their units and bounds, the tables that they fill, what a run records of it, what limit analysis makes of it, and its words.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationInfo

from masonry_cd.foundation.fields import Table
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws


@dataclass(frozen=True)
class JointHistory:
    """A measure of the joints that a run records in its frames as ``joints/NAME`` where some joints have the law."""

    name: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class Law:
    """A law of joints."""

    keys: type[Table]  # its keys of [material.joints]
    tables: Callable[[Any, float, str], dict[str, float]]  # their values of JointLaws, by friction and pair of groups
    where: Callable[[JointLaws], np.ndarray]  # (G, G) bool: joints that have it
    words: Callable[[Any], str]  # the law with its numbers, as the page has it; empty of joints without it
    absent: str = ""  # what a run says whose joints do not have it
    needs: Callable[[Any, bool], tuple[str, str] | None] | None = (
        None  # of a law and whether the masonry is elastic: the key that a run lacks, and why
    )
    history: JointHistory | None = None
    in_limit: str = ""  # what limit analysis makes of it, as a note of its results
    at_start_only: str = ""  # why limit analysis does not follow such joints at finite displacements
    bounds: str = ""  # what it is in a list of all that would end a load that is borne without limit

    def holds(self, laws: JointLaws) -> bool:
        """True where some joint has it."""
        return bool(self.where(laws).any())


def is_of_masonry(info: ValidationInfo) -> bool:
    """True where the scene also names a kind of masonry, which makes the joint elastic."""
    return bool(info.data) and info.data.get("masonry") is not None
