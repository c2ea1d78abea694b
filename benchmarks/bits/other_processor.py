"""Variables of the environment that make libraries choose as they would on another processor."""

from __future__ import annotations

import re

from numpy.lib import introspect


def other_processor(core: str) -> dict[str, str]:
    """numpy's loops for the plainest x86-64 that it is built for, and OpenBLAS' kernels for a kind of processor."""
    kinds = [found["available"] for loops in introspect.opt_func_info().values() for found in loops.values()]  # "X86_V4 X86_V3 baseline(...)"
    names = {name for kind in kinds for name in re.split(r"__|\s+", re.sub(r"baseline\(.*\)", "", kind)) if name}
    return {"NPY_DISABLE_CPU_FEATURES": " ".join(sorted(names)), "OPENBLAS_CORETYPE": core}
