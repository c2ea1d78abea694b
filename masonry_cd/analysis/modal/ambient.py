# SPDX-License-Identifier: GPL-3.0-or-later
r"""Modes from ambient records: stochastic subspace identification from covariances, and clusters of the poles that are stable.

The response y_k to white noise has the covariances R_i = E[y_{k+i} y_k^T] = C A^{i-1} G. Of their block Hankel matrix, the factor of rank n
yields A and C of order n (Peeters & De Roeck, Mech. Syst. Signal Process. 13, 1999), by pyoma-2. An eigenvalue mu of A is a pole:

    lambda = ln(mu) / dt,    f = |lambda| / 2 pi,    xi = -Re(lambda) / |lambda|,    shape C psi.

Block rows  half a period of the lowest frequency, rate / (2 f_lowest), or as orders need (methods are reviewed by Reynders, Arch. Comput.
            Methods Eng. 19, 2012; ours is a rule of thumb, tried on made records and on those in docs/howto/calibrate.md).
Orders      2, 4, ... up to ORDERS_A_MODE for each mode, LEAST_ORDER at least: noise has modes, too, and they change with the order.
Stable      a pole whose frequency, damping and shape at the order before differ by less than STABLE.
Clusters    stable poles by single linkage over |f_i - f_j| / f_i + 1 - MAC (Magalhaes et al., Mech. Syst. Signal Process. 23, 2009).
Modes       the lowest clusters stable at SHARE of the orders: medians of frequency and damping, the shape of the median pole, made real.
"""

from __future__ import annotations

import io
import math
from contextlib import redirect_stderr
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.signal import decimate
from scipy.spatial.distance import squareform

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require

ORDERS_A_MODE, LEAST_ORDER = 10, 40
STABLE = {"err_fn": 0.01, "err_xi": 0.05, "err_phi": 0.02}  # relative, relative, 1 - MAC: usual criteria
SHARE, MOST_DAMPED = 1.0 / 3.0, 0.1  # of the orders; damping of a pole that may be a mode
OF_RATE = 0.4  # highest frequency over the rate: the filter of a lower rate leaves what is below it
OF_HIGHEST = 0.02  # lowest over highest frequency, where it is not given
LARGEST, SAMPLES_A_ROW = 4000, 10  # rows of the Hankel matrix, 128 MB, and samples that each needs
AT_ONCE = 10_000_000  # numbers of shifted records held at a time


@dataclass(frozen=True, eq=False)
class AmbientRecord:
    """Accelerations of C channels of P sensors at N times."""

    path: Path
    values: np.ndarray  # (N, C) [m/s2]
    step: float  # [s]
    sensor: np.ndarray  # (C,) of each channel, index of its sensor
    axis: np.ndarray  # (C,) 0, 1, 2 for x, y, z
    names: tuple[str, ...]  # of the sensors
    points: np.ndarray  # (P, 3) [m]
    places: tuple[str, ...]  # file and line of each point


@dataclass(frozen=True, eq=False)
class AmbientMode:
    """One identified mode."""

    frequency: float  # [Hz]
    damping: float  # ratio
    scatter: float  # of the frequency over the orders: standard deviation over the median
    orders: int  # at which it is stable
    shape: np.ndarray  # (C,) of the channels, real; the largest is 1


@dataclass(frozen=True, eq=False)
class Identification:
    """Modes of a record, and the poles among which they were found."""

    modes: tuple[AmbientMode, ...]
    left: int  # clusters as stable, of higher frequency, beyond those requested
    frequency: np.ndarray  # (K,) of the poles [Hz]
    order: np.ndarray  # (K,) of the model they are of
    stable: np.ndarray  # (K,) bool
    orders: int  # models compared
    rows: int  # block rows of the Hankel matrix
    band: tuple[float, float]  # looked at [Hz]
    rate: float  # after decimation [Hz]


def identify(record: AmbientRecord, modes: int, lowest: float | None = None, highest: float | None = None) -> Identification:
    """Identify the lowest modes of a structure from its accelerations under ambient noise; see the head of this file.

    Args:
        record: of all sensors at once.
        modes: largest number of them.
        lowest: frequency looked at [Hz]; ``OF_HIGHEST`` of the highest when not given.
        highest: frequency looked at [Hz]; ``OF_RATE`` of the rate when not given.

    Raises:
        InputError: pyoma-2 is not installed, a band that the record cannot show, a record too short for it, or no stable mode.
    """
    at_most = OF_RATE / record.step
    highest = at_most if highest is None else highest
    lowest = OF_HIGHEST * highest if lowest is None else lowest
    if not lowest < highest <= at_most * (1.0 + 1e-9):
        raise InputError("modal.lowest", f"{lowest:g} to {highest:g} Hz is not a band up to {OF_RATE:g} of the rate, {at_most:.4g} Hz")
    factor = max(1, int(at_most / highest * (1.0 + 1e-9)))
    values, rate = record.values - record.values.mean(axis=0), 1.0 / (factor * record.step)
    values = decimate(values, factor, ftype="fir", axis=0) if factor > 1 else values
    channels, most = values.shape[1], max(LEAST_ORDER, ORDERS_A_MODE * modes)
    rows = max(math.ceil(rate / (2.0 * lowest)), -(-most // channels) + 1)
    size = rows * channels
    if size > LARGEST:
        raise InputError("modal", f"the ambient record needs a matrix of {size} rows, more than {LARGEST}; raise lowest, or lower modes")
    if len(values) < SAMPLES_A_ROW * size:
        raise InputError(record.path, f"{len(values) / rate:.4g} s are too short, {SAMPLES_A_ROW * size / rate:.4g} s or more are needed")
    poles = _poles(values, rows, most, 1.0 / rate)
    frequency, damping, shapes, order, stable = (array[(poles[0] >= lowest) & (poles[0] <= highest)] for array in poles)
    found = _modes(frequency[stable], damping[stable], shapes[stable], order[stable], SHARE * most / 2)
    if not found:
        raise InputError(record.path, f"no mode from {lowest:g} to {highest:g} Hz is stable at a third of the orders up to {most}")
    return Identification(tuple(found[:modes]), len(found[modes:]), frequency, order, stable, most // 2, rows, (lowest, highest), rate)


def _poles(values: np.ndarray, rows: int, most: int, step: float) -> tuple[np.ndarray, ...]:
    """Frequency, damping, shape (K, C), order and stability of all poles of the models of orders 2 to ``most``."""
    require("an ambient record", "pyoma2")
    with np.errstate(divide="ignore", invalid="ignore"), redirect_stderr(io.StringIO()):  # it has poles that are none, and shows progress
        from pyoma2.functions.gen import SC_apply
        from pyoma2.functions.ssi import SSI_fast, SSI_poles, build_hank

        pieces = np.array_split(values.T, math.ceil(rows * values.size / AT_ONCE), axis=1)
        hankel = sum(piece.shape[1] * build_hank(piece, piece, rows, "cov")[0] for piece in pieces) / len(values)
        system: Any = SSI_fast(hankel, rows, most, 2)
        frequency, damping, shapes = SSI_poles(system[0], system[1], system[2], most, step, 2, xi_max=MOST_DAMPED)[:3]
        stable = SC_apply(frequency, damping, shapes, 2, most, 2, **STABLE)
    known = np.isfinite(frequency)
    return frequency[known], damping[known], shapes[known], 2 * np.nonzero(known)[1], stable[known] == 1


def _modes(frequency: np.ndarray, damping: np.ndarray, shapes: np.ndarray, order: np.ndarray, least: float) -> list[AmbientMode]:
    """The clusters that have poles of ``least`` orders, by ascending frequency."""
    if len(frequency) < 2:
        return []
    unit = shapes / np.linalg.norm(shapes, axis=1, keepdims=True)
    apart = np.abs(frequency[:, None] - frequency) / np.maximum(frequency[:, None], frequency) + 1.0 - np.abs(unit.conj() @ unit.T) ** 2
    labels = fcluster(linkage(squareform(apart, checks=False), "single"), STABLE["err_fn"] + STABLE["err_phi"], "distance")
    out = []
    for poles in (np.flatnonzero(labels == label) for label in np.unique(labels)):
        poles = poles[np.argsort(np.abs(frequency[poles] - np.median(frequency[poles])), kind="stable")]
        poles = poles[np.unique(order[poles], return_index=True)[1]]  # of each order, the one nearest to the median
        if len(poles) >= least:
            shape = shapes[poles[np.argsort(frequency[poles], kind="stable")[len(poles) // 2]]]
            shape = (shape * np.exp(-0.5j * np.angle(np.sum(shape**2)))).real
            shape /= shape[np.argmax(np.abs(shape))]
            middle = float(np.median(frequency[poles]))
            out.append(AmbientMode(middle, float(np.median(damping[poles])), float(np.std(frequency[poles])) / middle, len(poles), shape))
    return sorted(out, key=lambda mode: mode.frequency)
