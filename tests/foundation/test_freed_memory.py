# SPDX-License-Identifier: GPL-3.0-or-later
"""Freed memory is kept: what a step frees, the next one has without asking the system. It is given back where that is asked for."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

FAULTS = """
import resource
import numpy as np
from masonry_cd.foundation.freed_memory import keep_freed_memory

def step():
    arrays = [np.ones(400_000) for _ in range(5)]  # 16 MB in all, each mapped by itself at first

{first}
for _ in range(3):
    step()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(10):
    step()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""

PIECES = """
from pathlib import Path
import numpy as np
from masonry_cd.foundation.freed_memory import give_back_freed_memory, keep_freed_memory

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1])

keep_freed_memory()
before = resident()
large, small = [], []
for _ in range(100):  # of 1 MB each, and pieces that stay between them
    large.append(np.ones(125_000))
    small.append(np.ones(200))
most = resident()
large.clear()
give_back_freed_memory()
print((resident() - before) / (most - before))
"""


def faults(first: str, **environment: str) -> int:
    """Pages that the system gives to ten steps which free 16 MB each, in a process of its own."""
    command, own = [sys.executable, "-c", FAULTS.format(first=first)], {key: os.environ[key] for key in os.environ if "MALLOC" not in key}
    return int(subprocess.run(command, capture_output=True, check=True, text=True, env=own | environment).stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
@pytest.mark.parametrize("environment", [{}, {"MALLOC_TRIM_THRESHOLD_": "65536"}], ids=["alone", "in a worker of dask"])
def test_what_is_freed_is_kept(environment: dict[str, str]) -> None:
    """Ten steps that free 16 MB each are given hardly a page, thousands otherwise. A busy system may count pages that it moves, too."""
    assert faults("keep_freed_memory()", **environment) < 0.1 * faults("", **environment)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
def test_what_lies_between_pieces_in_use_is_given_back() -> None:
    """Of 100 MB freed, the pieces between which it lies keep less than a tenth."""
    own = {key: os.environ[key] for key in os.environ if "MALLOC" not in key}
    assert float(subprocess.run([sys.executable, "-c", PIECES], capture_output=True, check=True, text=True, env=own).stdout) < 0.1
