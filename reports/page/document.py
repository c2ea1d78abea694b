# SPDX-License-Identifier: GPL-3.0-or-later
"""A page as one HTML file that asks no server for anything: what every page of the program shares."""

from __future__ import annotations

import base64
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from masonry_cd.analysis.verdict import Verdict
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from reports.drawing.figure import WIDTH as SHEET
from reports.page.templates import filled

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
    """Write a page by its template.

    Raises:
        InputError: it cannot be written.
    """
    page = filled(template, **values)
    try:
        with replacing(path) as part:
            part.write_text(page, encoding="utf-8")
    except OSError as failure:
        raise InputError(f"{path}: cannot be written, {failure.strerror}") from None


def script_of(package: str, *names: str) -> str:
    """Scripts of a package, one after the other."""
    return "\n".join((files(package) / name).read_text(encoding="utf-8") for name in names)
