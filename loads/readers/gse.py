# SPDX-License-Identifier: GPL-3.0-or-later
"""GSE 2.0 and 2.1, waveforms of the CTBTO's format and of AutoDRM services: channels of counts in pieces, as whole numbers or compressed.

    WID2 2005/08/31 02:33:49.850 RJOB  Z    CM6    12000  200.000000  9.49e-02  1.000 ...      columns of fixed places
    DAT2
    UUTLMHYKkYIUT2...
    CHK2 11399

In CM6 second differences stand in characters of six bits: 32 says that more follow, 16 of the first one the sign, the rest is the number.
CHK2 is the sum of the samples, modulo 1e8. Programs exist that decompress it faster; the one of obspy ends the process on damaged files.
Source: GSE/CRP/243, Provisional GSE 2.1 Message Formats & Protocols, 1997.
"""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from loads.readers.pieces import ChannelPiece, joined, of_channel_asked
from loads.readers.source import RawRecord, Reader, Request, Source, begins

HEAD, DATA, CHECK = "WID2 ", "DAT2", "CHK2 "  # in compressed data, which have no blanks, a line may begin with CHK2
ALPHABET = "+-0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"  # 0 to 63
VALUE = {letter: number for number, letter in enumerate(ALPHABET)}
MORE, SIGN, FIRST, LATER = 32, 16, 15, 31  # bits
MODULUS = 100_000_000
LARGEST = 2**52  # of a sample and of its differences: exact as a float
FASTEST = 1e6  # samples a second


def read(source: Source, request: Request) -> RawRecord:
    """Read one channel."""
    heads = [index for index, line in enumerate(source.lines) if line.startswith(HEAD)]
    if not heads:
        raise source.error(f"no line begins with {HEAD.strip()}, as a waveform of GSE 2 does")
    pieces = [_piece(source, head) for head in heads]
    channel = of_channel_asked(pieces, request.column, source.error)
    return joined(channel, source.error, request.calibration)


def _piece(source: Source, head: int) -> ChannelPiece:
    """The piece of a channel behind a line WID2."""
    line = source.lines[head].ljust(70)
    count, rate = source.whole(line[48:56], head, "the number of samples"), source.positive(line[57:68], head, "the sampling rate")
    if rate > FASTEST:
        raise source.error(f"{rate:g} samples a second are not possible", head)
    try:
        begin = datetime.strptime(line[5:28].strip(), "%Y/%m/%d %H:%M:%S.%f").replace(tzinfo=UTC).timestamp()
    except ValueError:
        raise source.error(f'"{line[5:28]}" where date and time belong', head) from None
    first = next((k + 1 for k in range(head, len(source.lines)) if source.lines[k].startswith(DATA)), 0)
    end = next((k for k in range(first, len(source.lines)) if source.lines[k].startswith(CHECK)), 0)
    if not first or not end:
        raise source.error(f"no {DATA} and {CHECK.strip()} behind it: cut short", head)
    kind = line[44:47]
    if kind == "INT":
        words = [(index, word) for index in range(first, end) for word in source.lines[index].split()]
        values = np.array([source.number(word, index) for index, word in words])
    elif kind == "CM6":
        values = _decompressed(source, first, end)
    else:
        raise source.error(f"data of type {kind} are not read; INT and CM6 are", head)
    source.check_count(values, count, head)
    wanted, own = source.number(source.lines[end][len(CHECK) :], end), _checksum(values)
    if own != abs(wanted):
        raise source.error(f"the samples have the checksum {own}, not {wanted:.10g}: damaged", end)
    return ChannelPiece(f".{line[29:34].strip()}..{line[35:38].strip()}", begin, 1.0 / rate, values, counts=True)


def _decompressed(source: Source, first: int, end: int) -> np.ndarray:
    """Samples (n,) of second differences in characters of six bits."""
    found, number, sign, inside = list[int](), 0, 1, False
    for index in range(first, end):
        for letter in source.lines[index].strip():
            bits = VALUE.get(letter)
            if bits is None:
                raise source.error(f'"{letter}" is not a character of CM6', index)
            if inside:
                number = number * (LATER + 1) + (bits & LATER)
            else:
                number, sign = bits & FIRST, -1 if bits & SIGN else 1
            inside = bool(bits & MORE)
            if number > LARGEST:
                raise source.error("a number too large for a sample: damaged", index)
            if not inside:
                found.append(sign * number)
    if inside:
        raise source.error("the last sample is cut short", end)
    differences = np.array(found, dtype=float)
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.cumsum(np.cumsum(differences))
    if len(values) and not np.abs(values).max() < LARGEST:
        raise source.error("samples too large: damaged", first)
    return values


def _checksum(values: np.ndarray) -> float:
    """The sum of the samples, each and all modulo 1e8, without its sign."""
    total = 0.0
    for value in np.fmod(values, MODULUS).tolist():
        total += value
        if abs(total) >= MODULUS:
            total -= np.trunc(total / MODULUS) * MODULUS
    return abs(float(total))


ABOUT = "GSE 2.0 and 2.1, INT and CM6, by channel"
FORMATS = {"gse2": Reader(begins(HEAD, 10), read, about=ABOUT, by="CTBTO, AutoDRM services", takes=("column", "calibration"))}
