# SPDX-License-Identifier: GPL-3.0-or-later
"""Elementary functions of arrays, by the C library.

numpy has its own for each kind of processor, which round differently. What results follow from (loads, shapes of blocks) is computed by
these, which give the same bits on all processors with AVX2 and FMA. They take longer, which does not matter outside of the step.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np


def _of_arrays(function: Callable[[float], float]) -> Callable[[np.ndarray], np.ndarray]:
    by_element = np.frompyfunc(function, 1, 1)
    return lambda x: np.asarray(by_element(x), dtype=float)


sin = _of_arrays(math.sin)
cos = _of_arrays(math.cos)
exp = _of_arrays(math.exp)
log = _of_arrays(math.log)
cbrt = _of_arrays(math.cbrt)
atan = _of_arrays(math.atan)


def geometric(first: float, last: float, count: int) -> np.ndarray:
    """Numbers (count,) from one to another, both above zero, that are even on a logarithmic axis."""
    out = first * exp(np.linspace(0.0, math.log(last / first), count))
    out[-1] = last
    return out
