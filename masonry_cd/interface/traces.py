# SPDX-License-Identifier: GPL-3.0-or-later
"""Base motions from traces of obspy, or of anything that has ``data`` and ``stats.delta`` as these do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from loads.readers.pieces import ChannelPiece, code_of, joined, of_traces
from loads.signal.series import Keys, accelerations
from masonry_cd.foundation.errors import InputError

AXES = {"X": 0, "E": 0, "1": 0, "Y": 1, "N": 1, "2": 1, "Z": 2, "V": 2, "3": 2}  # by the last letter of a channel
SI = {"acceleration": "m/s2", "velocity": "m/s", "displacement": "m"}


def from_traces(
    traces: Any,
    axes: Mapping[str, str] | None = None,
    scale: float | None = None,
    *,
    quantity: str | None = None,
    units: str | None = None,
    calibration: float | None = None,
    **keys: Any,
) -> dict[str, Any]:
    """A table of ``loads`` of kind "record" from traces, which are judged as the channels of a file are.

    Args:
        traces: a Trace, or a Stream of up to three channels whose samples are at the same times. A single one needs the key ``direction``.
        axes: the axis, x, y or z, of each channel; by the last letter of the channel where none are given: E is x, N is y, Z is z.
        scale: a factor on the samples, such as one over the sensitivity.
        quantity: acceleration, velocity or displacement, which the last two are differentiated from; needed where the channel's code, or
            what was done to the trace, says that it is not an acceleration.
        units: of the samples times the factors; SI where they are not given.
        calibration: what one count means in these units; needed, or ``scale``, where the samples are whole numbers.
        keys: of the table, ``correction`` and the like.

    Raises:
        InputError: no trace, a channel whose axis is not known, two on one axis, gaps, samples at other times, traces of velocity or of
            counts that nothing is said of.
    """
    every = [traces] if hasattr(traces, "stats") else list(traces) if isinstance(traces, Iterable) else []
    if not every or not all(hasattr(trace, "stats") and hasattr(trace, "data") for trace in every):
        raise InputError("from_traces", "a Trace of obspy or a Stream of some is needed")
    channels: dict[str, list[ChannelPiece]] = {}
    for piece in of_traces(every, _error):
        channels.setdefault(piece.name, []).append(piece)
    if quantity not in (None, *SI):
        raise InputError("from_traces", f'quantity: "{quantity}" is none; {", ".join(SI)}')
    given = Keys(quantity, units or SI[quantity or "acceleration"], scale if calibration is None else calibration)
    factor = (1.0 if scale is None else scale) * (1.0 if calibration is None else calibration)
    series = {name: _accelerations(pieces, factor, given) for name, pieces in channels.items()}
    if len({(len(values), begin, step) for values, begin, step in series.values()}) > 1:
        raise InputError("from_traces", "the traces begin at other times, or have other steps or lengths; trim and resample them first")
    values, _, step = next(iter(series.values()))
    time = step * np.arange(len(values))
    if len(series) > 1:
        return {"kind": "record", "time": time, **_by_axes(series, axes), **keys}
    if "direction" not in keys:
        raise InputError("from_traces", 'direction: missing; a single trace acts along "x", "y", "z" or a vector')
    return {"kind": "record", "time": time, "acceleration": values, "channels": [name.strip(".") for name in series], **keys}


def _error(message: str) -> InputError:
    return InputError("from_traces", f"{message}")


def _accelerations(pieces: list[ChannelPiece], factor: float, keys: Keys) -> tuple[np.ndarray, float, float]:
    """Accelerations of a channel (N,) [m/s2], when they begin and their step [s]."""
    raw = joined(sorted(pieces, key=lambda piece: piece.begin), _error, None if keys.calibration is None else factor)
    values, _ = accelerations(raw, keys, "from_traces", raw.name)
    return values, min(piece.begin for piece in pieces), raw.step


def _by_axes(series: Mapping[str, tuple[np.ndarray, float, float]], axes: Mapping[str, str] | None) -> dict[str, Any]:
    """Channels (N,) by the axes along which they act, (N, 3), and their names."""
    taken: dict[int, str] = {}
    for name in series:
        axis = _axis(code_of(name), axes)
        if axis in taken:
            raise InputError("from_traces", f"{taken[axis]} and {name} are both along {'xyz'[axis]}")
        taken[axis] = name
    none = np.zeros(len(next(iter(series.values()))[0]))
    moved = [series[taken[axis]][0] if axis in taken else none for axis in range(3)]
    return {"acceleration": np.column_stack(moved), "channels": [taken.get(axis, "xyz"[axis]).strip(".") for axis in range(3)]}


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
