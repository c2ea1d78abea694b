# SPDX-License-Identifier: GPL-3.0-or-later
"""Words that this house does not use, and sentences too long to read once."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
from doc_pages import PAGES, page_name
from places import ROOT

RIDDLES = re.compile(
    r"\b(told|dear|dearer|goes on with|carries news|room for|left undone|as ever|hereby|whilst|in the place of)\b", re.IGNORECASE
)
LONGEST = 75  # words to a sentence of running text
MODULES = sorted(path for name in ("masonry_cd", "structures", "loads", "reports") for path in (ROOT / name).rglob("*.py"))


def sentences(text: str) -> list[str]:
    """Those of the paragraphs of a page: no fences, tables, headings, lists of links."""
    text = re.sub(r"^(```|~~~).*?^\1", "", text, flags=re.DOTALL | re.MULTILINE)
    paragraphs = [part for part in re.split(r"\n\s*\n|\n(?=\s*[-*\d]+\.? )", text) if not re.match(r"\s*(\||#|    |!\[)", part)]
    return [sentence for part in paragraphs for sentence in re.split(r"(?<=[.:;?!])\s+", part)]


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_pages_say_it_plainly(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    plain = re.sub(r"```.*?```|`[^`]*`", "", text, flags=re.DOTALL)
    assert sorted({found.group() for found in RIDDLES.finditer(plain)}) == []
    assert [sentence for sentence in sentences(text) if len(sentence.split()) > LONGEST] == []


def test_sentences_are_found() -> None:
    assert sentences("# Head\n\nOne. Two\nlines.\n\n```sh\nno. no.\n```\n\n| a. b |\n") == ["One.", "Two\nlines."]


def test_docstrings_say_what_and_not_the_same() -> None:
    vague = []
    for path in MODULES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (ast.get_docstring(node) or "").startswith("The same"):
                vague.append(f"{path.relative_to(ROOT)}: {getattr(node, 'name', 'module')}")
    assert vague == []
