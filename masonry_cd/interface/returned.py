# SPDX-License-Identifier: GPL-3.0-or-later
"""Returns the value of a command's result, whichever command it is, and shows its warnings and, in a notebook, its closing lines."""

from __future__ import annotations

import html
import signal
import warnings
from collections.abc import Sequence
from typing import TypeVar

from masonry_cd.app.result import Result

T = TypeVar("T")


class RunWarning(UserWarning):
    """A warning about a result that its reader must know: ``warnings.simplefilter("error", mc.RunWarning)`` makes errors of them."""


def returned(result: Result[T], level: int = 3) -> T:
    """The value of a result. Its warnings are shown as :class:`RunWarning`.

    A signal other than Ctrl-C that ended the command has its usual effect first.

    Args:
        result: of a command.
        level: of the stack, at which the warnings are shown; 3 where the function that the user called calls this one.
    """
    if result.signal not in (0, signal.SIGINT):
        signal.raise_signal(result.signal)
    for line in result.warnings:
        warnings.warn(line, RunWarning, stacklevel=level)
    return result.value


def closing_as_html(lines: Sequence[str], warned: Sequence[str]) -> str:
    """The first line as a heading, the others and the warnings as a list."""
    items = "".join(f"<li>{html.escape(line)}</li>" for line in lines[1:])
    more = "".join(f'<li style="color:#b3261e">warning: {html.escape(line)}</li>' for line in warned)
    return f"<b>{html.escape(lines[0])}</b><ul>{items}{more}</ul>"
