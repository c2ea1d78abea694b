# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers of record files, picked by the name of the format or by what the file holds (never by the file's name).

A format is a :class:`loads.readers.source.Reader`, listed by name in the ``FORMATS`` of a module here. Those with a strict heading are
asked first.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator

from loads.readers.source import RawRecord, Reader, Request, Source
from masonry_cd.foundation import plugins
from masonry_cd.foundation.extensions import Entries

__all__ = ["READERS", "FormatName", "RawRecord", "Request", "Source", "formats", "read"]

READERS: Entries[Reader] = Entries("loads.readers", "FORMATS")


class _Names:
    """The formats in the schema of the key, which is rarely needed: modules of readers are imported then."""

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        return {"enum": ["auto", *sorted(READERS)], "type": "string"}


def _known(value: str) -> str:
    """A format that there is a reader for, or "auto"."""
    if value != "auto" and value not in READERS and value not in plugins.names("readers"):
        raise ValueError(f"should be one of {', '.join(['auto', *sorted(READERS), *plugins.names('readers')])}; given: {value}")
    return value


FormatName = Annotated[str, AfterValidator(_known), _Names()]
"""Formats that a table may ask for."""


def read(source: Source, name: str, request: Request) -> tuple[str, RawRecord]:
    """Read a record file.

    Args:
        source: the file.
        name: a format of ``READERS``, or "auto".
        request: what the user says about the file.

    Returns:
        The name of the format and the record.

    Raises:
        InputError: a file that no reader recognises, or a bad one, named with its line.
    """
    if name == "auto":
        own = [key for key, reader in READERS.items() if not reader.loose]
        found = next((key for key in own if READERS[key].recognises(source)), None)
        if found is None:  # formats of packages have a heading of their own, unlike those of ours that recognise much
            found = next((key for key in plugins.names("readers") if reader_of(key).recognises(source)), None)
        if found is None:
            found = next((key for key in READERS if key not in own and READERS[key].recognises(source)), None)
        if found is None and not source.lines:
            raise source.error("not a text file, nor a binary one of a format that is read")
        if found is None:
            raise source.error(f"not recognised as one of {', '.join(sorted(READERS))}; name the format by the key format")
        name = found
    reader = reader_of(name)
    stray = next((key for key, value in request._asdict().items() if value is not None and key not in reader.takes), None)
    if stray is not None:
        raise source.error(f'the key {stray} does not apply to files of format "{name}"')
    return name, reader.read(source, request)


def formats() -> list[tuple[str, str, str]]:
    """All formats by name: what is read of each, and who publishes it."""
    return [(name, reader.about, reader.by) for name, reader in sorted(READERS.items())]


def reader_of(name: str) -> Reader:
    """The reader of a format: ours, or one that a package adds.

    Raises:
        InputError: no such format, or a package that cannot be used.
    """
    found: Reader = plugins.find("readers", name, "format", READERS)
    return found
