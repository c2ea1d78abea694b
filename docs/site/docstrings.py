# SPDX-License-Identifier: GPL-3.0-or-later
"""Docstrings as the site reads them: roles such as :func:`run` are code, and sessions of the prompt >>> are blocks of code."""

from __future__ import annotations

import re
from typing import Any

import griffe

ROLE = re.compile(r":[a-z]+:`~?([^`]+)`")
SESSION = re.compile(r"^(?:>>> .*\n?)(?:.+\n?)*", re.MULTILINE)  # up to an empty line


class Docstrings(griffe.Extension):
    """An extension of Griffe, which mkdocstrings reads the package with."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Rewrite the docstring of an object."""
        if obj.docstring:
            obj.docstring.value = rewritten(obj.docstring.value)


def rewritten(text: str) -> str:
    """A docstring in the words of Markdown."""
    fenced = SESSION.sub(lambda session: f"```pycon\n{session[0].rstrip()}\n```\n", text)
    return ROLE.sub(r"`\1`", fenced)
