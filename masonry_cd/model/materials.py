"""What happens in the joints between groups of blocks: coefficients of friction and joint laws by pair of groups, as tables.

A scene gives one value for all joints, or values by pair of groups, ``arch-base``, with ``default`` for the rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from masonry_cd.app.scene import JointLaw
from masonry_cd.errors import InputError, suggest

Value = TypeVar("Value")


@dataclass(frozen=True, eq=False)
class JointLaws:
    """The joint laws between G groups, (G, G) symmetric tables; zeros: rigid and dry."""

    normal_stiffness: np.ndarray  # [N/m3]; 0: rigid
    tangential_stiffness: np.ndarray  # [N/m3]
    tension: np.ndarray  # tensile strength [Pa]
    apex: np.ndarray  # tension at the tip of the Mohr-Coulomb cone, cohesion / mu [Pa]; 0: no bond
    theta: np.ndarray  # of the spring over the step, 1/2 to 1

    @property
    def by_area(self) -> np.ndarray:
        """(G, G) bool: joints whose law goes by area, elastic ones and bonded ones."""
        return (self.normal_stiffness > 0.0) | (self.apex > 0.0)

    @property
    def stretch(self) -> float:
        """How far an intact joint can be drawn apart at the most [m]."""
        elastic = self.normal_stiffness > 0.0
        return float((self.apex[elastic] / self.normal_stiffness[elastic]).max(initial=0.0))


def friction_table(friction: float | Mapping[str, float], groups: Sequence[str]) -> np.ndarray:
    """Return the (G, G) symmetric table of friction coefficients between groups.

    Raises:
        InputError: an unknown group, a negative value, or a pair left without a value.
    """
    table = np.full((len(groups), len(groups)), np.nan)
    pairs = friction if isinstance(friction, Mapping) else {"default": friction}
    for i, j, value in _by_pair(pairs, groups, "material.friction"):
        table[i, j] = value
    if np.isnan(table).any():
        i, j = np.argwhere(np.isnan(table))[0]
        raise InputError(f"material.friction: no value for {groups[i]}-{groups[j]}; add it or a default")
    if (table < 0).any():
        raise InputError(f"material.friction: a coefficient must not be negative, got {table.min():g}")
    return table


def joint_table(laws: Mapping[str, JointLaw], groups: Sequence[str], friction: np.ndarray) -> JointLaws:
    """The joint laws between groups; a pair without an entry is rigid and dry.

    Args:
        laws: by pair of groups ``"arch-base"``, with ``"default"`` for the rest.
        groups: G names.
        friction: (G, G) coefficients, which with the cohesion fix the tip of the cone.

    Raises:
        InputError: an unknown group, cohesion without friction, or a tensile strength beyond the tip of the cone.
    """
    out = JointLaws(*(np.zeros((len(groups), len(groups))) for _ in JointLaws.__dataclass_fields__))
    for i, j, law in _by_pair(laws, groups, "material.joints"):
        out.normal_stiffness[i, j], out.tangential_stiffness[i, j] = law.stiffness
        out.apex[i, j] = _apex(law, float(friction[i, j]), f"{groups[i]}-{groups[j]}")
        out.tension[i, j] = out.apex[i, j] if law.tension is None else law.tension
        out.theta[i, j] = law.theta
    return out


def _apex(law: JointLaw, mu: float, pair: str) -> float:
    """Tension at the tip of the cone [Pa]: where the line of Mohr-Coulomb, mu p + c, comes to zero."""
    if mu == 0.0 and law.cohesion > 0.0:
        raise InputError(f"material.joints: the joint {pair} has cohesion but no friction; give it a coefficient of friction above 0")
    apex = law.cohesion / mu if mu > 0.0 else law.tension or 0.0
    if (law.tension or 0.0) > apex:
        raise InputError(
            f"material.joints: the tension {law.tension:g} Pa of the joint {pair} is above its cohesion over its friction, "
            f"{law.cohesion:g} Pa / {mu:g} = {apex:g} Pa, where the line of Mohr-Coulomb ends"
        )
    return apex


def _by_pair(pairs: Mapping[str, Value], groups: Sequence[str], key: str) -> list[tuple[int, int, Value]]:
    """Entries (i, j, value) of a symmetric table: those of the default first, so that those of pairs replace them."""
    count = range(len(groups))
    out = [(i, j, pairs["default"]) for i in count for j in count] if "default" in pairs else []
    for pair, value in pairs.items():
        if pair != "default":
            i, j = (groups.index(group) for group in _split_pair(pair, groups, key))
            out += [(i, j, value), (j, i, value)]
    return out


def _split_pair(pair: str, groups: Sequence[str], key: str) -> tuple[str, str]:
    """Split ``"a-b"`` where the names themselves may hold a dash."""
    for i, letter in enumerate(pair):
        if letter == "-" and pair[:i] in groups and pair[i + 1 :] in groups:
            return pair[:i], pair[i + 1 :]
    unknown = next((word for word in pair.split("-") if word not in groups), pair)
    raise InputError(f'{key}.{pair}: "{unknown}" is no group of blocks{suggest(unknown, groups)}; groups: {", ".join(groups)}')
