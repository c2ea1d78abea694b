# SPDX-License-Identifier: GPL-3.0-or-later
"""Records that are likely not what the user means: cut off while the ground shakes, flawed, or remade by their correction.

Nothing is refused: parts of records are used on purpose. Each doubt names its likely cause. What is too strong or weak is seen where the
ranges of all keys are, in their fields.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from loads.signal import flaws
from loads.signal.accelerogram import OFFSET, Processed

CHANGED = 0.1  # share of PGV or PGD that a correction may change
SLOW = 0.1  # step [s]; networks sample at 0.02 s and below
END_SHARE = 0.02  # of the samples, at either end
REST = 1e-3  # of the PGA: an end value below it is rest, one as close to the PGA is that of a pulse
SHOWN = 3  # times of flaws in a line
SHAKING = 0.1  # of the PGA: a root mean square at an end above it is not at rest


def doubts(processed: Processed, correction: str, where: str) -> list[str]:
    """Lines on a record as it is used, and on what its correction did."""
    lines = [*_slow(processed, where), *_cut_off(processed, where), *_flawed(processed, where)]
    return [*lines, *_changed_by_correction(processed, correction, where), *_keeps_offset(processed, correction, where)]


def _cut_off(processed: Processed, where: str) -> list[str]:
    """Doubt a motion that begins or ends while the ground shakes."""
    values, raw = processed.about_mean.acceleration, np.abs(processed.before.acceleration)
    some, peak = max(3, round(END_SHARE * len(values))), float(np.abs(values).max())
    ends = (("begins", values[:some], raw[0]), ("ends", values[-some:], raw[-1]))
    found = [(word, float(np.sqrt(np.mean(part**2))) / peak) for word, part, end in ends if not _is_of_pulse(end, float(raw.max()))]
    return [
        f"{where} the record {word} while the ground shakes, at {100 * share:.3g} % of its PGA (root mean square): "
        "is the window too narrow, or the file cut?"
        for word, share in found
        if share > SHAKING
    ]


def _flawed(processed: Processed, where: str) -> list[str]:
    """Spikes, clipped peaks and gaps of the record as it was read, by their times."""
    values, step = processed.before.acceleration, processed.before.step
    spikes, peak = flaws.spikes(values)
    lines = []
    if len(spikes):
        lines.append(
            f"{where} {_many(len(spikes), 'spike')} at {_times(spikes.tolist(), processed)} set{'s' * (len(spikes) == 1)} its PGA of "
            f"{np.abs(values).max():.4g} m/s2, which is {peak:.4g} without: correct the file, or leave it out by window; scale and "
            "target_pga use the PGA"
        )
    tops = flaws.flat_tops(values)
    if tops:
        lines.append(
            f"{where} {_many(len(tops), 'peak')} of the record {'are' if len(tops) > 1 else 'is'} cut off flat, at "
            f"{_times(tops, processed)}: the instrument was at its limit, and the motion was stronger"
        )
    gaps = flaws.gaps(values, step, peak)
    if gaps:
        longest = step * max(last - first for first, last in gaps)
        lines.append(
            f"{where} {_many(len(gaps), 'gap')} in the shaking, of up to {longest:.3g} s of one value, at "
            f"{_times([first for first, _ in gaps], processed)}: samples are missing"
        )
    return lines


def _many(count: int, what: str) -> str:
    return f"{count} {what}s" if count > 1 else f"a {what}"


def _times(places: Sequence[int], processed: Processed) -> str:
    """When samples are, in the time of the record; the first of many."""
    some = ", ".join(f"{processed.begin + processed.before.step * k:.4g}" for k in places[:SHOWN])
    return f"{some}{' ...' if len(places) > SHOWN else ''} s"


def _is_of_pulse(end: float, peak: float) -> bool:
    """Return True if a pulse is as large at one end as a record is there: nothing, or its peak. No record is cut exactly at either."""
    return end <= REST * peak or end >= (1.0 - REST) * peak


def _changed_by_correction(processed: Processed, correction: str, where: str) -> list[str]:
    """Doubt a correction of the baseline that changes what it should leave alone: other than the offset that is a mean."""
    if correction == "none":
        return []
    raw, level, after = processed.before.numbers(), processed.about_mean.numbers(), processed.after.numbers()
    changes = []
    for name, unit in (("pgv", "m/s"), ("pgd", "m")):
        nearest = min(raw[name], level[name], key=lambda value: abs(value - after[name]))
        if abs(after[name] - nearest) > CHANGED * nearest:
            changes.append(f"{name.upper()} from {nearest:.3g} to {after[name]:.3g} {unit}")
    if not changes:
        return []
    return [
        f"{where} the {correction} correction changes {' and '.join(changes)}, with or without the mean of the record: it drifts, "
        "as raw or cut ones do; look at it with masonry-cd record, and try window, band or taper"
    ]


def _keeps_offset(processed: Processed, correction: str, where: str) -> list[str]:
    """Doubt samples in which an offset of the instrument is left."""
    offset = processed.offset() if correction == "none" else None
    mean = abs(float(processed.after.acceleration.mean()))
    if offset is None or mean <= OFFSET * offset["pga"] or _rests(processed):
        return []
    return [
        f'{where} correction "none" keeps a mean of {mean:.3g} m/s2, as the offset of an instrument, in PGA, Arias intensity and the '
        f"motion of the base: PGA {processed.after.numbers()['pga']:.4g} m/s2, {offset['pga']:.4g} without it"
    ]


def _rests(processed: Processed) -> bool:
    """Return True if it is zero at one end for a while, as a pulse is: an offset would be there, too."""
    values = np.abs(processed.before.acceleration)
    some = max(3, round(END_SHARE * len(values)))
    return bool(min(values[:some].max(), values[-some:].max()) <= REST * values.max())


def _slow(processed: Processed, where: str) -> list[str]:
    """Doubt samples that are so far apart that their time is likely in another unit."""
    step = processed.before.step
    if step <= SLOW:
        return []
    return [f"{where} its samples are {step:g} s apart, which holds no shaking above {0.5 / step:.3g} Hz: are its times in seconds?"]
