# SPDX-License-Identifier: GPL-3.0-or-later
"""gmsh, started within a process that has its own ways."""

from __future__ import annotations

import re
import signal
from pathlib import Path

import pytest

from masonry_cd.foundation.gmsh_session import gmsh_session

STATUS = Path("/proc/self/status")


def ignored() -> set[int]:
    """The signals that the system does not deliver to this process."""
    mask = int(re.search(r"SigIgn:\s*(\w+)", STATUS.read_text(encoding="utf-8")).group(1), 16)
    return {number for number in range(1, 65) if mask >> (number - 1) & 1}


@pytest.mark.skipif(not (STATUS.exists() and hasattr(signal, "SIGHUP")), reason="Linux tells here which signals are ignored")
def test_signals_that_are_ignored_stay_so(request):
    former = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    request.addfinalizer(lambda: signal.signal(signal.SIGHUP, former))
    before = ignored()
    assert {signal.SIGHUP, signal.SIGPIPE} <= before
    with gmsh_session():
        assert ignored() == before
    assert ignored() == before
