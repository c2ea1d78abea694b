"""Readers of record files, picked by the name of the format or by what the file holds (never by the file's name).

A format is a :class:`loads.readers.source.Reader`, listed by name in the ``FORMATS`` of a module here. Those with a strict heading are
asked first.
"""

from __future__ import annotations

from typing import Literal

from loads.readers.source import RawRecord, Reader, Request, Source
from masonry_cd.foundation.extensions import Entries

__all__ = ["READERS", "FormatName", "RawRecord", "Request", "Source", "formats", "read"]

FormatName = Literal[
    "auto", "afad", "at2", "bhrc", "columns", "cosmos", "counted", "csmip", "csv", "cwb", "esm", "geonet", "knet", "mseed", "renadic",
    "sac", "smc", "unam", "usc",
]  # fmt: skip
"""What a table may ask for: "auto", or one of ``READERS``, which a test compares."""

READERS: Entries[Reader] = Entries("loads.readers", "FORMATS")


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
        strict_first = sorted(READERS.items(), key=lambda item: item[1].loose)
        found = next((key for key, reader in strict_first if reader.recognises(source)), None)
        if found is None and not source.lines:
            raise source.error("not a text file, nor a binary one of a format that is read")
        if found is None:
            raise source.error(f"not recognised as one of {', '.join(sorted(READERS))}; name the format by the key format")
        name = found
    return name, READERS[name].read(source, request)


def formats() -> list[tuple[str, str, str]]:
    """All formats by name: what is read of each, and who publishes it."""
    return [(name, reader.about, reader.by) for name, reader in sorted(READERS.items())]
