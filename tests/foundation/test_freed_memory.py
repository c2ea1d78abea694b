"""Freed memory is kept: what a step frees, the next one has without asking the system."""

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


def faults(first: str, **environment: str) -> int:
    """Pages that the system gives to ten steps which free 16 MB each, in a process of its own."""
    command, own = [sys.executable, "-c", FAULTS.format(first=first)], {key: os.environ[key] for key in os.environ if "MALLOC" not in key}
    return int(subprocess.run(command, capture_output=True, check=True, text=True, env=own | environment).stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
@pytest.mark.parametrize("environment", [{}, {"MALLOC_TRIM_THRESHOLD_": "65536"}], ids=["alone", "in a worker of dask"])
def test_what_is_freed_is_kept(environment: dict[str, str]) -> None:
    """Ten steps that free 16 MB each are given hardly a page, thousands otherwise. A busy system may count pages that it moves, too."""
    assert faults("keep_freed_memory()", **environment) < 0.1 * faults("", **environment)
