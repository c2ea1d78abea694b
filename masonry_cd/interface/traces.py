# SPDX-License-Identifier: GPL-3.0-or-later
"""Base motions from traces of obspy, or of anything that has ``data`` and ``stats.delta`` as these do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError

AXES = {"X": 0, "E": 0, "1": 0, "Y": 1, "N": 1, "2": 1, "Z": 2, "V": 2, "3": 2}  # by the last letter of a channel


def from_traces(traces: Any, axes: Mapping[str, str] | None = None, scale: float = 1.0, **keys: Any) -> dict[str, Any]:
    """A table of ``loads`` of kind "record" from traces of acceleration [m/s2].

    Args:
        traces: a Trace, or a Stream of up to three whose samples are at the same times. A single one needs the key ``direction``.
        axes: the axis, x, y or z, of each channel; by the last letter of the channel where none are given: E is x, N is y, Z is z.
        scale: a factor on the samples, such as one over the sensitivity; what a trace holds, counts or m/s2, it does not say.
        keys: of the table, ``correction`` and the like.

    Raises:
        InputError: no trace, a channel whose axis is not known, two on one axis, gaps, or samples at other times.
    """
    single = hasattr(traces, "stats")
    every = [traces] if single else list(traces) if isinstance(traces, Iterable) else []
    if not every or not all(hasattr(trace, "stats") and hasattr(trace, "data") for trace in every):
        raise InputError("from_traces", "a Trace of obspy or a Stream of some is needed")
    samples = [_samples(trace) for trace in every]
    grids = {
        (len(data), float(trace.stats.delta), str(getattr(trace.stats, "starttime", "")))
        for data, trace in zip(samples, every, strict=True)
    }
    if len(grids) > 1:
        raise InputError("from_traces", "the traces begin at other times, or have other steps or lengths; trim and resample them first")
    time = float(every[0].stats.delta) * np.arange(len(samples[0]))
    if len(every) == 1:
        if "direction" not in keys:
            raise InputError("from_traces", 'direction: missing; a single trace acts along "x", "y", "z" or a vector')
        acceleration = scale * samples[0]
    else:
        acceleration = np.zeros((len(time), 3))
        taken: dict[int, str] = {}
        for data, trace in zip(samples, every, strict=True):
            axis = _axis(str(trace.stats.channel), axes)
            if axis in taken:
                raise InputError("from_traces", f"{taken[axis]} and {trace.stats.channel} are both along {'xyz'[axis]}")
            taken[axis], acceleration[:, axis] = str(trace.stats.channel), scale * data
    return {"kind": "record", "time": time, "acceleration": acceleration, **keys}


def _samples(trace: Any) -> np.ndarray:
    """Of one trace, without gaps."""
    if np.ma.isMaskedArray(trace.data) and np.ma.getmaskarray(trace.data).any():
        raise InputError("from_traces", f"{getattr(trace.stats, 'channel', 'a trace')} has gaps")
    return np.asarray(trace.data, dtype=float)


def _axis(channel: str, axes: Mapping[str, str] | None) -> int:
    """The axis of a channel."""
    if axes is not None:
        name = str(axes.get(channel, ""))
        if name not in ("x", "y", "z"):
            raise InputError("from_traces", f'axes: channel {channel} is along x, y or z, not "{name}"')
        return "xyz".index(name)
    found = AXES.get(channel[-1:].upper())
    if found is None:
        raise InputError("from_traces", f'the axis of channel {channel} is not known; axes={{"{channel}": "x"}} says it')
    return found
