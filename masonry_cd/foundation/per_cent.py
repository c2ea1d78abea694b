# SPDX-License-Identifier: GPL-3.0-or-later
"""Shares as people read them; no kernel reaches this file, as several reach :mod:`masonry_cd.foundation.quantities`."""

from __future__ import annotations


def per_cent(share: float) -> str:
    """A share of something whole, ``62.5 %``; less than 0.005 % is written as 0."""
    return f"{round(100.0 * share, 2):.4g} %"
