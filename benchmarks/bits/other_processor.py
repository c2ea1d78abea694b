# SPDX-License-Identifier: GPL-3.0-or-later
"""Variables of the environment that make libraries choose as they would on another processor."""

from __future__ import annotations

import re

from numpy.lib import introspect


def other_processor(core: str) -> dict[str, str]:
    """numpy's loops for the plainest x86-64 that it is built for, and OpenBLAS' kernels for a kind of processor."""
    kinds = [kind["available"] for loops in introspect.opt_func_info().values() for kind in loops.values()]
    beyond = " ".join(re.sub(r"baseline\(.*\)", "", kind) for kind in kinds)  # each was like "X86_V4 X86_V3 baseline(X86_V2)"
    return {"NPY_DISABLE_CPU_FEATURES": " ".join(sorted(set(beyond.replace("__", " ").split()))), "OPENBLAS_CORETYPE": core}
