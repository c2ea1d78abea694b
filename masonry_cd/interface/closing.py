# SPDX-License-Identifier: GPL-3.0-or-later
"""Closing lines and warnings of a result as a notebook shows them."""

from __future__ import annotations

import html
from collections.abc import Sequence


def closing_as_html(lines: Sequence[str], warnings: Sequence[str]) -> str:
    """The first line as a heading, the others and the warnings as a list."""
    items = "".join(f"<li>{html.escape(line)}</li>" for line in lines[1:])
    warned = "".join(f'<li style="color:#b3261e">warning: {html.escape(line)}</li>' for line in warnings)
    return f"<b>{html.escape(lines[0])}</b><ul>{items}{warned}</ul>"
