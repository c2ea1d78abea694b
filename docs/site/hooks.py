# SPDX-License-Identifier: GPL-3.0-or-later
"""Additions of the site to Markdown: formulas as MathML, and pages and links of files that lie outside docs/.

The pages read alike on a forge and here: formulas in $...$ and in fences called math, links by the place of a file in the repository.
"""

from __future__ import annotations

import html
import os
import posixpath
import re
from pathlib import Path
from typing import Any

from latex2mathml.converter import convert
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
BROUGHT = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md", "benchmarks/README.md": "benchmarks.md"}
PLACES = {page: place for place, page in BROUGHT.items()}
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]*)(#[^)\s]*)?\)")
IN_FULL = {  # what the site adds to a page of the repository: docstrings, by mkdocstrings
    "python_reference.md": """
## In full

::: masonry_cd
    options:
      show_root_heading: false
      show_root_toc_entry: false
      members_order: alphabetical
"""
}
FENCE = re.compile(r"^(```.*?^```$)", re.DOTALL | re.MULTILINE)


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that lie outside docs/."""
    for page, place in PLACES.items():
        files.append(File.generated(config, page, content=(ROOT / place).read_text(encoding="utf-8")))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Formulas in the marks of arithmatex; links to where their files lie in the site; docstrings in full where IN_FULL has them."""
    place = PLACES.get(page.file.src_uri, f"docs/{page.file.src_uri}")
    text = re.sub(r"^```math\n(.*?)^```$", r"$$\n\1$$", markdown, flags=re.DOTALL | re.MULTILINE)
    parts = FENCE.split(text)  # code is left as it is
    for i in range(0, len(parts), 2):
        formulas = re.sub(r"\$`([^`]+)`\$", r"$\1$", parts[i])
        parts[i] = LINK.sub(lambda found: link_on_site(found, page.file.src_uri, place), formulas)
    return "".join(parts) + IN_FULL.get(page.file.src_uri, "")


def on_page_content(html_text: str, **_: Any) -> str:
    """Formulas as MathML, which browsers draw by themselves."""
    inline = re.sub(r'<span class="arithmatex">\\\((.*?)\\\)</span>', lambda found: mathml(found[1], "inline"), html_text, flags=re.DOTALL)
    return re.sub(r'<div class="arithmatex">\\\[(.*?)\\\]</div>', lambda found: mathml(found[1], "block"), inline, flags=re.DOTALL)


def mathml(formula: str, display: str) -> str:
    """A formula of TeX, escaped for HTML, as MathML.

    Raises:
        ValueError: a command that is not known.
    """
    text = html.unescape(formula).strip()
    text = text.replace(r"\begin{aligned}", r"\begin{array}{rlll}").replace(r"\end{aligned}", r"\end{array}")
    made = convert(text, display=display)
    if left := re.search(r"\\[a-zA-Z]+", re.sub(r"<[^>]*>", "", made)):
        raise ValueError(f"{left[0]} is no formula that can be drawn: {text}")
    made = re.sub(r"(<mtext>\(\d+\)</mtext>)", r'<mspace width="2em" />\1', made)  # the number of an equation stands apart from it
    return made.replace('<mo stretchy="false">&#x0007C;</mo>', '<mo stretchy="false" lspace="0" rspace="0">|</mo>')


def link_on_site(found: re.Match[str], page: str, place: str) -> str:
    """A link with its address in the site; of a file that the site does not have, its words alone."""
    picture, words, target, anchor = found[1], found[2], found[3], found[4] or ""
    if "://" in target or not target:
        return found[0]
    aim = posixpath.normpath(posixpath.join(posixpath.dirname(place), target))
    if not (ROOT / aim).exists():
        return found[0]  # reported by the build
    if aim in BROUGHT or aim == "README.md":
        there = BROUGHT.get(aim, "index.md")
    elif aim.startswith("docs/") and (ROOT / aim).is_file() and Path(aim).suffix not in {".py", ".toml", ".json"}:
        there = aim.removeprefix("docs/")
    else:
        return words
    return f"{picture}[{words}]({os.path.relpath(there, posixpath.dirname(page) or '.')}{anchor})"
