# SPDX-License-Identifier: GPL-3.0-or-later
"""What is in the model beside its blocks: masses, floors, ties and loads in the lines that each says of itself; motions of supports."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from reports.drawing.figure import in_metres
from reports.page.section import Section
from reports.page.words import PageContext, number, terms

MOST = 40  # lines, and rows of a table


def loads(context: PageContext) -> Mapping[str, Any]:
    """The lines that a run prints before it begins, and each motion of the supports where they do not all move alike."""
    lines = [re.sub(r"loads\[(\d+)\]", lambda k: f"load {int(k[1]) + 1}:", line) for line in context.summary.get("modelled", ())]
    lines = lines or [f"load {k + 1}: {_as_written(load)}" for k, load in enumerate(context.tables.get("loads", []))]
    motions = []
    for motion in context.motions if len(context.motions) > 1 else ():
        last = ", ".join(number(1e3 * value, digits=3) for value in motion.displacement[-1]).replace("-", "−")
        motions.append([motion.called, *([in_metres(motion.largest), last] if motion.moves else ["at rest", "–"])])
    return {"lines": lines, "motions": motions, "most": MOST} if lines or motions else {}


def _as_written(load: Mapping[str, Any]) -> str:
    """A load of a run that left no summary, by its keys."""
    return f"{load.get('kind', '')}, {', '.join(' '.join(term) for term in terms(load) if term[0] != 'kind')}"


SECTIONS = {"loads": Section("Masses, ties and loads in the model", loads, -40)}
