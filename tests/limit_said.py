# SPDX-License-Identifier: GPL-3.0-or-later
"""The lines of a limit analysis with its warnings, as a terminal shows both."""

from __future__ import annotations

from masonry_cd.limit.case import LimitCase
from masonry_cd.limit.words import lines


def said(case: LimitCase) -> list[str]:
    """All that the command says of an analysis."""
    return [*lines(case), *case.notes]
