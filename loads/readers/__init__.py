"""Readers of record files, one per format, picked by name or by what the file holds (never by the file's name).

A reader is a pair: ``recognises(source) -> bool`` and ``read(source, request) -> RawRecord``. Those with a strict heading are asked first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from loads.readers import at2, esm, knet, mseed, tables
from loads.readers.source import RawRecord, Request, Source

__all__ = ["READERS", "RawRecord", "Request", "Source", "read"]


class Reader(NamedTuple):
    """One format."""

    recognises: Callable[[Source], bool]
    read: Callable[[Source, Request], RawRecord]


READERS = {
    "at2": Reader(at2.recognises, at2.read),
    "esm": Reader(esm.recognises, esm.read),
    "knet": Reader(knet.recognises, knet.read),
    "mseed": Reader(mseed.recognises, mseed.read),
    "csv": Reader(tables.recognises_csv, tables.read_csv),
    "columns": Reader(tables.recognises_columns, tables.read_columns),
}


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
        found = next((key for key, reader in READERS.items() if reader.recognises(source)), None)
        if found is None:
            raise source.error(f"not recognised as one of {', '.join(READERS)}; name the format by the key format")
        name = found
    return name, READERS[name].read(source, request)
