# SPDX-License-Identifier: GPL-3.0-or-later
"""Series that come in pieces, as archives of networks keep them and obspy holds them: which channel, and its pieces put together.

A channel may be cut into pieces that follow each other without a gap. Its code says whether the sensor follows the acceleration or the
velocity, unless what was done to it since says otherwise. Files and objects in memory pass the same checks.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from loads.readers.channels import code_of, pick
from loads.readers.quantity import Stated, of_channel
from loads.readers.source import RawRecord
from masonry_cd.foundation.errors import InputError

SLACK = 0.5  # of a step: by how much pieces may be off the times of one series
LADDER = ("displacement", "velocity", "acceleration")
OUTPUT = re.compile(r"\b(?:output|quantity)\s*=\s*['\"]?(ACC|VEL|DISP)\w*", re.IGNORECASE)
STEPS = {"differentiate": 1, "integrate": -1}

Error = Callable[[str], InputError]


class ChannelPiece(NamedTuple):
    """Samples of a channel at even times."""

    name: str  # of the channel, whole: "IV.AQK..HNE"
    begin: float  # [s], of the same clock for all pieces
    step: float  # [s]
    values: np.ndarray  # (n,)
    counts: bool = False  # whole numbers, as a digitiser writes them
    done: tuple[str, ...] = ()  # to the samples since they were recorded, as obspy writes it
    unit: str | None = None  # as it is written next to them


def of_traces(traces: Sequence[Any], error: Error) -> list[ChannelPiece]:
    """Pieces of traces of obspy, or of anything that has ``data`` and ``stats`` with ``delta`` as these do.

    Raises:
        InputError: a trace whose samples are masked, as obspy does in gaps, or no row of numbers.
    """
    starts = [getattr(trace.stats, "starttime", 0.0) for trace in traces]
    return [_of_trace(trace, float(start - starts[0]), error) for trace, start in zip(traces, starts, strict=True)]


def _of_trace(trace: Any, begin: float, error: Error) -> ChannelPiece:
    stats = trace.stats
    name = str(getattr(trace, "id", "") or getattr(stats, "channel", "")) or "a trace"
    if np.ma.isMaskedArray(trace.data) and np.ma.getmaskarray(trace.data).any():
        raise error(f"{name} has gaps")
    data = np.asarray(trace.data)
    if data.ndim != 1 or data.dtype.kind not in "iuf":
        raise error(f"{name}: a row of real numbers is needed, got {data.dtype.name} of shape {data.shape}")
    done = tuple(map(str, getattr(stats, "processing", ()) or ()))
    return ChannelPiece(name, begin, float(stats.delta), data.astype(float), data.dtype.kind in "iu", done)


def of_channel_asked(pieces: Sequence[ChannelPiece], column: str | int | None, error: Error) -> list[ChannelPiece]:
    """The pieces of the channel that the user asks for, in order of time.

    Raises:
        InputError: several channels and none named, or no such channel.
    """
    names = list(dict.fromkeys(piece.name for piece in pieces))
    name = names[pick(names, column, error)]
    return sorted((piece for piece in pieces if piece.name == name), key=lambda piece: piece.begin)


def joined(pieces: Sequence[ChannelPiece], error: Error, calibration: float | None = None) -> RawRecord:
    """The pieces of one channel as one series, times a calibration.

    Raises:
        InputError: a gap, an overlap, another step or unit in one of them, samples that are no numbers.
    """
    first = pieces[0]
    for earlier, later in pairwise(pieces):
        end = earlier.begin + earlier.step * (len(earlier.values) - 1)
        lag = later.begin - end - first.step
        if later.step != first.step:
            raise error(f"the sampling of {first.name} changes from {first.step:g} to {later.step:g} s")
        if later.unit != first.unit:
            raise error(f"the unit of {first.name} changes from {first.unit} to {later.unit}")
        if abs(lag) > SLACK * first.step:
            what = "a gap" if lag > 0.0 else "an overlap"
            raise error(f"{what} of {abs(lag):g} s in {first.name} at {end - first.begin:g} s")
    values = np.concatenate([piece.values for piece in pieces])
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise error(f"sample {bad[0] + 1} of {first.name} is not a finite number")
    counts = calibration is None and all(piece.counts for piece in pieces)
    factor = 1.0 if calibration is None else calibration
    stated = of_processing(first.done, of_channel(code_of(first.name)))
    return RawRecord(factor * values, first.step, 0.0, first.unit, first.name, stated=stated, counts=counts)


def of_processing(done: Iterable[str], stated: Stated | None) -> Stated | None:
    """Return the quantity of a series after the processing that obspy lists: its response taken out, differentiated, integrated."""
    for line in done:
        if output := OUTPUT.search(line):
            found = next(quantity for quantity in LADDER if quantity.startswith(output[1].lower()))
            stated = Stated(found, f"what was done to it, {output[0]}", firm=False)
        call = re.search(r"\b(differentiate|integrate)\(", line)
        if call and stated and stated.quantity in LADDER:
            place = LADDER.index(stated.quantity) + STEPS[call[1]]
            found = LADDER[place] if 0 <= place < len(LADDER) else ""
            stated = Stated(found, f"{stated.by}, to which {call[1]} was done", firm=False)
    return stated
