# SPDX-License-Identifier: GPL-3.0-or-later
"""A section of the page of a run: a heading, a template, and its content.

A module of this package lists its own in ``SECTIONS``, by the names that links go to. The template is the file of that name in
``reports/templates/run``, or the section brings it along.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from masonry_cd.foundation.extensions import Entries
from reports.page.document import filled
from reports.page.words import PageContext

LAST = 1000


@dataclass(frozen=True)
class Section:
    """A section of the page."""

    title: str
    data: Callable[[PageContext], Mapping[str, Any]]  # values of its template; empty where the page has no such section
    place: int = LAST  # in the order of sections; below zero above the model
    template: str = ""  # its text, where it is not a file

    def html(self, name: str, data: Mapping[str, Any]) -> str:
        """The section filled in."""
        return filled(f"run/{name}.html", self.template, **data)


KNOWN: Entries[Section] = Entries("reports.page", "SECTIONS")
