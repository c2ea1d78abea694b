"""A page as one HTML file that asks no server for anything: what stands around the body of every page of the program."""

from __future__ import annotations

import base64
import re
import struct
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path

from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from reports.page.words import escaped, verdict_first

WIDE = 2.0  # width over height from which on a picture has a row to itself


def write_document(path: Path, title: str, body: str, style: str = "", script: str = "window.ready = Promise.resolve(true);") -> None:
    """Write a page.

    Args:
        path: of the file.
        title: plain text.
        body: HTML.
        style: CSS after that of every page.
        script: of the page; it promises ``window.ready``.

    Raises:
        InputError: it cannot be written.
    """
    here = files("reports.page")
    values = {"title": escaped(title), "body": body, "style": (here / "style.css").read_text(encoding="utf-8") + style, "script": script}
    page = filled((here / "document.html").read_text(encoding="utf-8"), values)
    try:
        with replacing(path) as part:
            part.write_text(page, encoding="utf-8")
    except OSError as failure:
        raise InputError(f"{path}: cannot be written, {failure.strerror}") from None


def filled(template: str, values: Mapping[str, str]) -> str:
    """A template with a value in the place of each name."""
    return re.sub(r"\{\{(\w+)\}\}", lambda found: values[found.group(1)], template)


def plain_style() -> str:
    """CSS of a page that is read from top to bottom: pictures in two columns."""
    return (files("reports.page") / "plain.css").read_text(encoding="utf-8")


def header(
    title: str,
    lines: Sequence[str],
    warnings: Sequence[str],
    numbers: Sequence[tuple[str, object]],
    block: str = "",
    verdict: Verdict | None = None,
) -> str:
    """The head of a page that is read from top to bottom.

    Args:
        title: plain text.
        lines: what was found; the first says of what.
        warnings: that must not be overlooked.
        numbers: terms and their numbers, which are HTML.
        block: rows of a title block, HTML.
        verdict: on what the page shows; None where it judges nothing.
    """
    rows = f'<dl class="block">{block}</dl>' if block else ""
    first = "" if verdict is None else verdict_first(verdict)
    lead = f'<h1>{escaped(title)}</h1>{first}{rows}<p class="lead">{escaped(lines[0])}</p>'
    return f'<header>{lead}{_said(lines[1:])}{_notices(warnings)}<dl class="tiles">{_tiles(numbers)}</dl></header>'


def _said(lines: Sequence[str]) -> str:
    """Lines as a list."""
    return f'<ul class="said">{"".join(f"<li>{escaped(line)}</li>" for line in lines)}</ul>' if lines else ""


def _notices(lines: Sequence[str]) -> str:
    """Lines that must not be overlooked."""
    return "".join(f'<p class="notice" role="note">{escaped(line)}</p>' for line in lines)


def _tiles(rows: Sequence[tuple[str, object]]) -> str:
    """Terms and their numbers, which are HTML, for a list of class tiles."""
    return "".join(f"<div><dt>{name}</dt><dd>{value}</dd></div>" for name, value in rows)


def pictures(captions: Mapping[Path, str]) -> str:
    """PNGs inside the page, each with what it shows."""
    if not captions:
        return ""
    inside = f'<h2 id="pictures-title">Pictures</h2><div class="pictures">{"".join(map(_figure, captions, captions.values()))}</div>'
    return f'<section aria-labelledby="pictures-title">{inside}</section>'


def _figure(path: Path, caption: str) -> str:
    image = path.read_bytes()
    width, height = struct.unpack(">II", image[16:24])  # the head of a PNG
    data = base64.b64encode(image).decode("ascii")
    wide = ' class="wide"' if width > WIDE * height else ""
    alt = escaped(path.stem.replace("_", " "))
    return f'<figure{wide}><img src="data:image/png;base64,{data}" alt="{alt}"><figcaption>{escaped(caption)}</figcaption></figure>'
