# SPDX-License-Identifier: GPL-3.0-or-later
"""The head of the page: for whom and by whom it is, when, and with which program; and the line that runs over each printed page."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from datetime import date
from typing import Any

from reports.page.words import PageContext

KEYS = {"project": "Project", "client": "Client", "author": "Author"}
PRINT = 12  # letters of a checksum that are printed


def title_block(context: PageContext) -> list[tuple[str, str]]:
    """Rows of a table of terms: what ``[report]`` gives, the date, the program, and what tells this run from others."""
    return rows_of(context.report, program(context), context.results.scene)


def rows_of(given: Mapping[str, Any], made_by: str, scene: str) -> list[tuple[str, str]]:
    """Those rows.

    Args:
        given: the table ``[report]``.
        made_by: the program.
        scene: its text; empty where there is none.
    """
    rows = [(name, str(given[key])) for key, name in KEYS.items() if given.get(key)]
    rows += [("Date", _date(given)), ("Program", made_by)]
    if scene:
        rows.append(("Scene", f"SHA-256 {checksum(scene)} …"))
    return rows


def rows_of_many(scene: str, version: str, varied: str) -> list[tuple[str, str]]:
    """Those of a page of many runs; without a date, so that the same runs make the same page.

    Args:
        scene: its file.
        version: of the program that made the runs.
        varied: what differs between them.
    """
    return [("Scene", scene), ("Program", f"masonry_cd {version}".strip()), ("Varied", varied)]


def report_date(context: PageContext) -> str:
    """The date of the report: as given, or today."""
    return _date(context.report)


def _date(given: Mapping[str, Any]) -> str:
    return str(given.get("date") or date.today().isoformat())


def program(context: PageContext) -> str:
    """The program and its version: that which made the run, where the file says so."""
    version = context.results.versions.get("masonry-cd") or context.summary.get("version")
    return f"masonry_cd {version}" if version else "masonry_cd"


def checksum(text: str) -> str:
    """The beginning of the SHA-256 of a scene's text."""
    return hashlib.sha256(text.encode()).hexdigest()[:PRINT]


def running(context: PageContext) -> str:
    """CSS of the margins of printed pages: project or title at the top; date, program and page number at the foot."""
    head = " · ".join(str(word) for word in (context.report.get("project"), context.results.title) if word)
    places = {"top-left": head, "top-right": str(context.report.get("author") or ""), "bottom-left": program(context)}
    places["bottom-center"] = report_date(context)
    boxes = [f"@{place} {{ content: {_css_text(text)}; }}" for place, text in places.items() if text]
    return "@media print { @page { " + " ".join(boxes) + " } }"


def _css_text(text: str) -> str:
    """A text of CSS; all but plain letters by their number, so that nothing in it ends the text or looks like an address."""
    return '"' + "".join(c if c.isascii() and (c.isalnum() or c in " .,") else f"\\{ord(c):06x}" for c in text) + '"'
