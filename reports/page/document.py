# SPDX-License-Identifier: GPL-3.0-or-later
"""A page as one HTML file that asks no server for anything: Jinja2 fills a template of ``reports/templates``.

Every value is escaped, slashes as well, so that neither a tag nor an address can stand in a page by what a scene holds; a value that a
template names and nobody gives is an error.
"""

from __future__ import annotations

import base64
import hashlib
import html
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from reports.drawing.figure import WIDTH as SHEET
from reports.page.words import PageContext

KEYS = {"project": "Project", "client": "Client", "author": "Author"}
PRINT = 12  # letters of a checksum that are printed
WIDE = 2.0  # width over height from which on a picture has a row to itself, and a sheet, whose letters are small, always


@dataclass(frozen=True)
class Head:
    """The head of a page that is read from top to bottom."""

    title: str
    lines: Sequence[str]  # what was found; the first says of what
    warnings: Sequence[str]  # that must not be overlooked
    numbers: Sequence[tuple[str, object, str]]  # what each is, the number, and small print behind it
    block: Sequence[tuple[str, str]] = ()  # of a title block
    verdict: Verdict | None = None  # on what the page shows; None where it judges nothing
    see: str = ""  # the section that has more of it


@dataclass(frozen=True)
class Picture:
    """A PNG inside a page, with what it shows."""

    caption: str
    alt: str
    data: str  # base64
    wide: bool

    @classmethod
    def read(cls, path: Path, caption: str) -> Picture:
        """Read one from its file."""
        image = path.read_bytes()
        width, height = struct.unpack(">II", image[16:24])  # the head of a PNG
        alt = f"{path.stem.replace('_', ' ')}: {caption.partition('. ')[0].rstrip('.')}"
        return cls(caption, alt, base64.b64encode(image).decode("ascii"), width > WIDE * height or width >= SHEET)


def pictures(captions: Mapping[Path, str]) -> list[Picture]:
    """Those PNGs."""
    return [Picture.read(path, caption) for path, caption in captions.items()]


def write_document(path: Path, template: str, **values: Any) -> None:
    """Write a page by its template."""
    page = filled(template, **values)
    try:
        with replacing(path) as part:
            part.write_text(page, encoding="utf-8")
    except OSError as failure:
        raise InputError(path, f"cannot be written, {failure.strerror}") from None


def script_of(package: str, *names: str) -> str:
    """Scripts of a package, one after the other."""
    return "\n".join((files(package) / name).read_text(encoding="utf-8") for name in names)


if TYPE_CHECKING:
    from jinja2 import Environment


@dataclass(frozen=True)
class Badge:
    """A cell of a table, or a word in a text, in a colour of its own, or with an address."""

    css: str  # classes of the style sheet
    text: str
    page: str = ""

    @classmethod
    def grade(cls, name: str) -> Badge:
        """A grade of damage, or what stands for it."""
        return cls(f"grade {name.replace(' ', '-')}", name)


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


def title_block(context: PageContext) -> list[tuple[str, str]]:
    """Rows of a table of terms: what ``[report]`` gives, the date, the program, and what tells this run from others."""
    return rows_of(context.report, program(context), context.results.scene)


def rows_of(given: Mapping[str, Any], made_by: str, scene: str) -> list[tuple[str, str]]:
    """Those rows, of the table ``[report]``, the program, and a scene's text where there is one."""
    rows = [(name, str(given[key])) for key, name in KEYS.items() if given.get(key)]
    rows += [("Date", _date(given)), ("Program", made_by)]
    if scene:
        rows.append(("Scene", f"SHA-256 {hashlib.sha256(scene.encode()).hexdigest()[:PRINT]} …"))
    return rows


def rows_of_many(scene: str, version: str, varied: str) -> list[tuple[str, str]]:
    """Those of a page of many runs of a scene's file; without a date, so that the same runs make the same page."""
    return [("Scene", scene), ("Program", f"masonry_cd {version}".strip()), ("Varied", varied)]


def _date(given: Mapping[str, Any]) -> str:
    return str(given.get("date") or date.today().isoformat())


def program(context: PageContext) -> str:
    """The program and its version: that which made the run, where the file says so."""
    version = context.results.versions.get("masonry-cd") or context.summary.version
    return f"masonry_cd {version}" if version else "masonry_cd"


def running(context: PageContext) -> str:
    """CSS of the margins of printed pages: project or title at the top; date, program and page number at the foot."""
    head = " · ".join(str(word) for word in (context.report.get("project"), context.results.title) if word)
    places = {"top-left": head, "top-right": str(context.report.get("author") or ""), "bottom-left": program(context)}
    places["bottom-center"] = _date(context.report)
    css = {}  # all but plain letters by their number, so that nothing ends a text or looks like an address; a blank belongs to the number
    for place, text in places.items():
        css[place] = "".join(c if c.isascii() and (c.isalnum() or c in " .,") else f"\\{ord(c):06x} " for c in text)
    boxes = [f'@{place} {{ content: "{text}"; }}' for place, text in css.items() if text]
    return "@media print { @page { " + " ".join(boxes) + " } }"
