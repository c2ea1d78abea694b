"""A section of the page of a run: a heading, a template of its name in ``reports/templates/run``, and what fills it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from reports.page.templates import filled
from reports.page.words import PageContext


@dataclass(frozen=True)
class Section:
    """A section of the page."""

    name: str  # of its template, and of its heading as a place that links go to
    title: str
    data: Callable[[PageContext], Mapping[str, Any]]  # values of its template; empty where the page has no such section

    def filled(self, data: Mapping[str, Any]) -> str:
        """Its HTML."""
        return filled(f"run/{self.name}.html", **data)
