# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint sets of 3DEC decks: parallel planes that cut the blocks of a range, exactly.

    block cut joint-set dip 30 dip-direction 90 spacing 0.5 [number 3] origin 0 0 0.25 [range ...]       version 7: without number all over
    jset dip 30 dd 90 spac 0.5 num 3 org 0 0 0.25                                                        version 5: without number one plane

The dip direction is clockwise from y, z is up. A set begins at its origin; which way it goes on from there is known of level joints, up,
so that sets of several joints that dip, and those that scatter or are not persistent, are refused. Source: 3DEC 5 and 7 command reference.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from structures.files.foreign import FileShell, Refused

KEYS = {"dip": 1, "dip-direction": 1, "spacing": 1, "number": 1, "origin": 3, "persistence": 1, "jointset-id": 1}  # and how many numbers
SHORT = {"dd": "dip-direction", "org": "origin", "id": "jointset-id", "spac": "spacing", "num": "number", "per": "persistence"}
LEVEL = 1e-9  # degrees of dip of a level joint
MOST = 10_000  # joints of a set within a block


def cut_by_set(
    where: str, pieces: Sequence[FileShell], words: Sequence[str], everywhere: bool, in_range: Callable[[FileShell], bool]
) -> list[FileShell]:
    """Blocks cut by a joint set, numbered again.

    Args:
        where: file and line.
        pieces: the convex blocks so far.
        words: behind ``joint-set``, up to the range.
        everywhere: whether a set without a number has joints all over, as in version 7.
        in_range: whether a block is cut.

    Raises:
        Refused: a set that is not read; faces too warped to be cut.
    """
    keys = _keys(where, words)
    dip, direction = math.radians(keys["dip"][0]), math.radians(keys["dip-direction"][0])
    normal = np.array([math.sin(dip) * math.sin(direction), math.sin(dip) * math.cos(direction), math.cos(dip)])
    at, spacing = float(normal @ keys["origin"]), keys["spacing"][0]
    count = keys["number"][0] if "number" in keys else math.inf if everywhere else 1.0
    if count > 1.0 and not spacing > 0.0:
        raise Refused(where, "a joint set of several joints without a spacing")
    if 1.0 < count < math.inf and abs(keys["dip"][0]) > LEVEL:
        raise Refused(where, "several joints that dip: to which side of the origin they lie is not known here; give a joint-set for each")
    found: list[FileShell] = []
    for piece in pieces:
        found += _halves(where, piece, normal, _offsets(where, piece, normal, at, spacing, count)) if in_range(piece) else [piece]
    return [piece._replace(number=k, name=f"b{k}") for k, piece in enumerate(found)]


def _keys(where: str, words: Sequence[str]) -> dict[str, list[float]]:
    """Keywords and their numbers; second ones, by which a set scatters, have to be 0."""
    found: dict[str, list[float]] = {"dip-direction": [0.0], "spacing": [0.0], "persistence": [1.0], "jointset-id": [0.0]}
    key = ""
    for word in words:
        lower = word.lower()
        if re.match(r"[-+.\d]", lower) and key:
            found[key].append(float(lower.replace("d", "e")))
            continue
        key = SHORT.get(lower) or next((name for name in KEYS if len(lower) > 2 and name.startswith(lower)), "")
        if not key:
            raise Refused(where, f'"{word[:40]}" of a joint set is not read')
        found[key] = []
    for key, count in KEYS.items():
        own = found.get(key, [0.0] * count if key == "number" else [])
        if len(own) < count or any(own[count:]):
            raise Refused(where, f"{key} of a joint set should have {count} number{'s' if count > 1 else ''}, and no deviation")
    if found["persistence"][0] != 1.0:
        raise Refused(where, "joints that are not persistent are not read")
    return found


def _offsets(where: str, piece: FileShell, normal: np.ndarray, at: float, spacing: float, count: float) -> Iterator[float]:
    """The places along their normal where the joints of a set pass through a block."""
    heights = piece.vertices @ normal
    if not spacing > 0.0:
        yield at
        return
    first, last = math.ceil((heights.min() - at) / spacing), math.floor((heights.max() - at) / spacing)
    if count < math.inf:
        first, last = max(first, 0), min(last, int(count) - 1)
    if last - first > MOST:
        raise Refused(where, f"more than {MOST} joints through one block")
    yield from (at + spacing * k for k in range(first, last + 1))


def _halves(where: str, piece: FileShell, normal: np.ndarray, offsets: Iterator[float]) -> list[FileShell]:
    """A block cut by parallel planes, from the lowest on."""
    from masonry_cd.foundation.errors import InputError
    from masonry_cd.mechanics.model.blocks import Block
    from structures.geometry.convex import halves

    rest, found = Block(piece.name, piece.vertices, piece.faces, 1.0, piece.group), []
    try:
        for offset in offsets:
            below, above = halves(rest, normal, offset)
            if below is None or above is None:
                continue
            found.append(below)
            rest = above
    except InputError as failure:
        raise Refused(where, str(failure)) from None
    return [piece._replace(vertices=block.vertices, faces=block.faces) for block in [*found, rest]]
