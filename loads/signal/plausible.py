"""Records that are likely not what the user means: cut off while the ground shakes, or made anew by their correction.

Nothing is refused: parts of records are used on purpose. Each doubt names its likely cause. What is too strong or weak is seen where the
ranges of all keys are, in ``masonry_cd/app/ranges.py``.
"""

from __future__ import annotations

import numpy as np

from loads.signal.accelerogram import Processed

CHANGED = 0.1  # share of PGV or PGD that a correction may change
END_SHARE = 0.02  # of the samples, at either end
SHAKING = 0.1  # of the PGA: a root mean square at an end above it is no rest


def doubts(processed: Processed, correction: str, where: str) -> list[str]:
    """Lines on a record as it is used, and on what its correction did."""
    return [*_cut_off(processed, where), *_made_anew(processed, correction, where)]


def _cut_off(processed: Processed, where: str) -> list[str]:
    """Whether the motion begins or ends while the ground shakes."""
    values = processed.before.acceleration
    some, peak = max(3, round(END_SHARE * len(values))), float(np.abs(values).max())
    ends = (("begins", values[:some]), ("ends", values[-some:]))
    found = [(word, float(np.sqrt(np.mean(part**2))) / peak) for word, part in ends]
    return [
        f"{where} the record {word} while the ground shakes, at {100 * share:.2g} % of its PGA (root mean square): "
        "is the window too narrow, or the file cut?"
        for word, share in found
        if share > SHAKING
    ]


def _made_anew(processed: Processed, correction: str, where: str) -> list[str]:
    """Whether the correction of the baseline has changed what it should leave alone."""
    if correction == "none":
        return []
    before, after = processed.before.numbers(), processed.after.numbers()
    changes = [
        f"{name.upper()} from {before[name]:.3g} to {after[name]:.3g} {unit}"
        for name, unit in (("pgv", "m/s"), ("pgd", "m"))
        if abs(after[name] - before[name]) > CHANGED * before[name]
    ]
    if not changes:
        return []
    return [
        f"{where} the {correction} correction changes {' and '.join(changes)}: the record drifts (it would end at "
        f"{before['end_velocity']:.2g} m/s), as raw or cut ones do; look at it with masonry-cd record, and try window, band or taper"
    ]
