# SPDX-License-Identifier: GPL-3.0-or-later
"""Which processor kernels are compiled for: by default any x86-64 with AVX2 and FMA, so that all of these compute the same bits.

numba compiles for the processor that it runs on. There LLVM takes the widest registers, and adds up sums in as many parts as one holds;
another processor has others. So results would differ in their last digits, and under strong shaking these grow to different collapses. Here
numba compiles for x86-64-v3 (System V ABI: x86-64 with AVX2, FMA and some more, in practice all since 2015) where

- this processor is one,
- the environment sets neither NUMBA_CPU_NAME nor NUMBA_CPU_FEATURES, which choose another, nor MASONRY_CD_NATIVE, which chooses this one,
- numba has compiled nothing before: it settles on a processor with the first function that it is given. A warning says so.

numba has one processor for all that it compiles in a process, so functions of other packages are compiled for x86-64-v3 too.
"""

from __future__ import annotations

import os
import warnings

import llvmlite.binding
import numba

SWITCH = "MASONRY_CD_NATIVE"  # environment variable: whether to compile for this very processor
NAME = "x86-64-v3"
FEATURES = ("avx2", "fma", "bmi", "bmi2", "f16c", "lzcnt", "movbe")  # in addition to those that come with them


def choose() -> None:
    """Have numba compile for x86-64-v3 where the head of this file says so."""
    config = numba.config
    if os.environ.get(SWITCH) or config.CPU_NAME is not None or config.CPU_FEATURES is not None or not _is_one():
        return
    config.CPU_NAME, config.CPU_FEATURES = NAME, ",".join(f"+{feature}" for feature in FEATURES)
    if target() != (NAME, config.CPU_FEATURES):
        config.CPU_NAME = config.CPU_FEATURES = None
        warnings.warn(
            f"numba compiled for {target()[0]} before masonry_cd was imported, so kernels are compiled for it too: "
            f"other processors may round otherwise. Import masonry_cd first, or set {SWITCH}",
            stacklevel=2,
        )


def target() -> tuple[str, str]:
    """Name and features of the processor that numba compiles for, in LLVM's words; settles it."""
    try:
        from masonry_cd.foundation.numba_internals import settled_target  # which a newer numba may not have the names for

        return settled_target()
    except (ImportError, AttributeError):
        host = llvmlite.binding.get_host_cpu_name(), llvmlite.binding.get_host_cpu_features().flatten()
        return numba.config.CPU_NAME or host[0], numba.config.CPU_FEATURES or host[1]


def _is_one() -> bool:
    """Return True if this processor is an x86-64-v3, and numba may use all of it."""
    try:
        found = llvmlite.binding.get_host_cpu_features()
    except RuntimeError:  # LLVM does not know
        return False
    return llvmlite.binding.get_process_triple().startswith("x86_64") and numba.config.ENABLE_AVX and all(map(found.get, FEATURES))
