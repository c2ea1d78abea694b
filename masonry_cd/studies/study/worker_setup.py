# SPDX-License-Identifier: GPL-3.0-or-later
"""Loaded by each worker of this machine as it starts: Ctrl-C in a terminal reaches all processes, and is for the first alone to answer."""

from __future__ import annotations

from typing import Any

from masonry_cd.foundation.workers import leave_interrupts


def dask_setup(worker: Any) -> None:
    """Leave Ctrl-C to the process that the user started; it ends its workers."""
    leave_interrupts()
