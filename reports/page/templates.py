# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages from templates: Jinja2 fills those of ``reports/templates``, and whatever is filled in is text.

Every value is escaped, slashes as well, so that neither a tag nor an address can stand in a page by what a scene holds; a value that a
template names and nobody gives is an error.
"""

from __future__ import annotations

import html
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Environment


@dataclass(frozen=True)
class Badge:
    """A cell of a table, or a word in a text, in a colour of its own."""

    css: str  # classes of the style sheet
    text: str


def filled(template: str, text: str = "", **values: Any) -> str:
    """A template of ``reports/templates``, or a ``text`` that stands for it, with its values."""
    made = _environment().from_string(text) if text else _environment().get_template(template)
    return made.render(values)


@cache
def _environment() -> Environment:
    """Imported only where a page is written."""
    from jinja2 import Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup

    from reports.drawing import palette
    from reports.page.words import capital, number, sensible

    def as_text(value: Any) -> Any:
        return value if hasattr(value, "__html__") else Markup(html.escape(str(value)).replace("/", "&#47;"))

    found = Environment(
        loader=PackageLoader("reports"), autoescape=True, undefined=StrictUndefined, finalize=as_text, trim_blocks=True, lstrip_blocks=True
    )
    found.globals |= {"colours": palette}
    found.filters |= {"number": number, "capital": capital, "sensible": sensible}
    return found
