# SPDX-License-Identifier: GPL-3.0-or-later
"""The load factor without what is assumed of a structure: the bond of its joints, their crushing, the fill that resists.

Each is left out by itself, and the associated factor found again, a programme each: how far a verdict rests on an assumption is then seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.analysis import Options, analyse
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import BARS

if TYPE_CHECKING:
    from masonry_cd.analysis.limit.problem import Loads
    from masonry_cd.limit.whole import WholeAnalysis

ALONE = Options(starts=0)


@dataclass(frozen=True)
class Without:
    """The associated factor without an assumption."""

    assumed: str  # bond, crushing or fill
    words: str  # what is left out
    factor: float | None  # None where there is no finite one, 0 where the structure does not stand without it
    why: str = ""  # why there is none

    @property
    def line(self) -> str:
        """The line that is shown."""
        if self.factor is None:
            return f"without {self.words}: {self.why}"
        return f"without {self.words}: {f'load factor {self.factor:.4g}' if self.factor else 'it does not stand'}"

    def numbers(self) -> dict[str, Any]:
        """For limit.json."""
        return asdict(self) | {"line": self.line}


def without_assumptions(whole: WholeAnalysis) -> tuple[Without, ...]:
    """The associated factors of a structure without each of its assumptions; none of one that has no factor, or assumes nothing."""
    if not whole.has_factor or whole.analysis.bears_nothing or whole.analysis.problem.moves_support:
        return ()
    return tuple(
        Without(assumed, words, *_factor(whole, assembly, loads)) for assumed, words, assembly, loads in _left_out(whole, whole.loads.at())
    )


def _left_out(whole: WholeAnalysis, loads: Loads) -> Iterator[tuple[str, str, Assembly, Loads]]:
    """Each assumption, what is left out, and blocks and loads without it."""
    assembly, laws, names = whole.assembly, whole.assembly.laws, whole.loads.tie_names
    if laws.apex.any():
        yield "bond", "the bond of its joints", replace(assembly, laws=laws.unbonded()), loads
    if laws.crushing.any():
        yield "crushing", "crushing, of joints of any strength", replace(assembly, laws=replace(laws, crushing=0.0 * laws.crushing)), loads
    kept = np.array([not name.startswith(BARS) for name in names], dtype=bool)
    if not kept.all():
        bars = replace(loads.bars, **{key: getattr(loads.bars, key)[kept] for key in ("blocks", "points", "strength")})
        yield "fill", "fill that resists", assembly, replace(loads, bars=bars)


def _factor(whole: WholeAnalysis, assembly: Assembly, loads: Loads) -> tuple[float | None, str]:
    """The associated factor of blocks under loads, 0 where they do not stand; or None, and why there is no finite one."""
    try:
        found = analyse(assembly, whole.joints, loads, ALONE)
    except InputError as failure:
        return None, f"no answer, {failure}"
    if not found.stands:
        return 0.0, ""
    return (None, "no finite load factor") if found.unlimited else (found.associated.factor, "")
