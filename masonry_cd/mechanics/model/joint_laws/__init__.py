# SPDX-License-Identifier: GPL-3.0-or-later
"""The laws of joints, a module each, and what follows from all of them together: the table ``[material.joints]`` and its arrays.

A scene gives one law for all joints, or laws by pair of groups, ``arch-base``, with ``default`` for the rest. Either group of a pair may be
a pattern, ``*arch-*base``; a pair by name holds before one by patterns. A new law is a module here, its keys among those of
:class:`JointLaw`, its :class:`Law` in ``LAWS``, and its arrays in :class:`JointLaws`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.by_group import by_pair
from masonry_cd.mechanics.model.joint_laws import bonded, crushing, elastic, softening
from masonry_cd.mechanics.model.joint_laws.law import JointHistory, Law
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws

KEY = "material.joints"
LAWS: tuple[Law, ...] = (elastic.LAW, bonded.LAW, softening.LAW, crushing.LAW)


class JointLaw(crushing.CrushingKeys, softening.SofteningKeys):
    """The law of a joint, a table ``[material.joints]`` or ``[material.joints.arch-base]``."""


def joint_table(
    laws: Mapping[str, JointLaw], groups: Sequence[str], friction: np.ndarray, moduli: tuple[float, float] | None = None
) -> JointLaws:
    """The joint laws between groups; a pair without an entry is dry, and rigid where no moduli are given.

    Args:
        laws: by pair of groups ``"arch-base"``, with ``"default"`` for the rest.
        groups: G names.
        friction: (G, G) coefficients, which with the cohesion fix the tip of the cone.
        moduli: E and G of the masonry [Pa], by which joints without a stiffness of their own are elastic.

    Raises:
        InputError: an unknown group, cohesion without friction, or a tensile strength beyond the tip of the cone.
    """
    out = JointLaws.none(len(groups), moduli)
    for i, j, given in by_pair(laws if moduli is None else {"default": JointLaw(), **laws}, groups, KEY):
        for law in LAWS:
            for name, value in law.tables(given, float(friction[i, j]), f"{groups[i]}-{groups[j]}").items():
                getattr(out, name)[i, j] = value
    return out


def held(laws: JointLaws) -> tuple[Law, ...]:
    """The laws that some joint has."""
    return tuple(law for law in LAWS if law.holds(laws))


def histories(laws: JointLaws | None = None) -> tuple[JointHistory, ...]:
    """The histories that runs record of laws that some joint has; of all laws for None."""
    return tuple(law.history for law in (LAWS if laws is None else held(laws)) if law.history is not None)


def at_start_only(laws: JointLaws) -> str:
    """Why limit analysis does not follow these joints at finite displacements; empty where it does."""
    return "; ".join(law.at_start_only for law in held(laws) if law.at_start_only)


def law_in_words(given: JointLaw, otherwise: str) -> str:
    """The law of a joint with its numbers; ``otherwise`` says what one without a stiffness of its own is."""
    words = [law.words(given) for law in LAWS]
    return ", ".join(filter(None, [words[0] or otherwise, *words[1:]]))


def refuse_in_a_run(laws: Mapping[str, JointLaw], moduli: tuple[float, float] | None) -> None:
    """Refuse laws that a run lacks a key for, which limit analysis takes.

    Raises:
        InputError: names the pair of groups, and the key that is missing.
    """
    for pair, given in laws.items():
        for law in LAWS:
            lacks = None if law.needs is None else law.needs(given, moduli is not None)
            if lacks is not None:
                raise InputError(f"{KEY}.{pair}.{lacks[0]}", lacks[1])


def refuse_unfelt(laws: Mapping[str, JointLaw], groups: Sequence[str], felt: np.ndarray) -> None:
    """Refuse laws that no joint can have; ``felt`` (G, G): whether blocks of two groups can touch with faces.

    Raises:
        InputError: a pair, or pattern, all of whose joints are with spheres.
    """
    for pair, law in laws.items():
        if not any(felt[i, j] for i, j, _ in by_pair({pair: law}, groups, KEY)):
            raise InputError(f"{KEY}.{pair}", "spheres touch in points, without springs and bonds, and no other joint has this law")
