# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of 3DEC decks, of version 5 or 7, in a child process (:mod:`structures.files.foreign`).

    block create brick | prism | polyhedron [group]    poly [region n] brick | prism ... a block
    block cut joint-set                                jset                              blocks cut by planes
    block fix | free | group [range group | position]  fix | free                        supports and groups
    model new                                          new                               no blocks any more

Commands that leave blocks as they are, loads, materials, cycles, pictures, are passed over. A deck is a program: whatever else it says
of blocks, deletes, turns, hides or joins, would change what stands there, and is refused by its line, as is a range that is not
read. Functions in FISH are not executed, and what is unknown is named. Source: 3DEC 5 and 7 command reference.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from structures.files.cuts_3dec import cut_by_set
from structures.files.foreign import Faces, FileContents, FileShell, Refused
from structures.files.program_readers import BOX, NUMBER

READ = ("create", "fix", "free", "group", "cut")  # of block
HARMLESS = (  # of block: none changes corners, groups or supports
    "apply", "constitutive", "contact", "damping", "dynamic", "fluid", "gravity", "history", "insitu", "list", "mechanical",
    "mechanical-damping", "property", "results", "table", "thermal", "zone",
)  # fmt: skip
NAMED = ("gridpoint", "face", "initialize", "name", "rigid")  # of block: may hold or load blocks, and is named
ENDS = ("exit", "quit", "stop", "return", "ret")  # of the deck, also of program
OLD_READ = ("poly", "fix", "free", "new", "jset")  # commands of version 5 on blocks
OLD_CHANGES = ("cut", "delete", "hide", "seek", "find", "join", "tunnel", "tube", "rotate", "move", "copy", "dice", "dismember",
               "mark", "octree", "sphere", "excavate", "remove", "call", "restore", "rest")  # fmt: skip
OTHER = (  # that say nothing of blocks
    "change", "contact", "cycle", "damp", "dfn", "echo", "fluid", "flow", "fracture", "gen", "generate",
    "grav", "gravity", "history", "hist", "initial", "insitu", "interface", "list", "mscale", "pause", "plot", "print", "program", "prop",
    "property", "reset", "save", "set", "solve", "step", "structure", "table", "title", "head", "heading",
    "thermal", "trace", "zone", "model", "fish", "config", "geometry", "data", "ucs", "rigid", "def", "define", "end", "loop",
)  # fmt: skip
RUNS = ("call", "call-file", "restore")  # of program, model and fish: what is in another file
NUMBERED = ("reg", "mat", "con")  # of poly: region, material and constitutive law, by number
FISH_BEGINS, FISH_ENDS = ("def", "define"), ("end",)


def read(path: Path) -> FileContents:
    """The blocks that a deck leaves.

    Raises:
        Refused: a command that changes blocks and is not read, a range or numbers that do not fit, no blocks at all.
    """
    pieces: list[FileShell] = []
    unknown: list[str] = []
    functions: list[int] = []
    in_fish = False
    for number, line in _commands(path.read_text(encoding="utf-8-sig", errors="replace")):
        words = line.replace("(", " ").replace(")", " ").replace(",", " ").split()
        lower = [word.lower() for word in words]
        if not words:
            continue
        where = f"{path.name}: line {number}"
        if lower[0] in FISH_BEGINS or lower[:2] in (["fish", "define"], ["fish", "def"]):
            functions.append(number)
            in_fish = True
        elif in_fish:
            _refuse_in_fish(where, lower)
            in_fish = lower[0] not in FISH_ENDS
        elif lower[0] in ENDS or (lower[0] == "program" and lower[1:2] and lower[1] in ENDS):
            break
        elif _is_block(lower[0]) and lower[1:2] and _meant(lower[1]) in NAMED:
            if any(word.startswith("pos") for word in lower[: _range_at(lower)]):
                raise _changing(where, words)
            unknown.append(f"{_quoted(words)} in line {number}")
        elif _is_block(lower[0]) or lower[0] in OLD_READ or lower[:2] == ["model", "new"]:
            pieces = _done(where, pieces, words, lower)
        elif lower[0] in OLD_CHANGES or (lower[0] in ("program", "model", "fish") and lower[1:2] and lower[1] in RUNS):
            raise _changing(where, words)
        elif lower[0] not in OTHER:
            unknown.append(f"{_quoted(words)} in line {number}")
    if not pieces:
        raise Refused(path.name, "no command block create in it")
    notes = [f"{path.name}: FISH of line {', '.join(map(str, functions[:5]))} not executed"] if functions else []
    more = f" and {len(unknown) - 5} more" if len(unknown) > 5 else ""
    return FileContents(pieces, (), [*notes, *([f"{path.name}: commands not read: {', '.join(unknown[:5])}{more}"] if unknown else [])])


def _commands(text: str) -> Iterator[tuple[int, str]]:
    """Commands without comments, and the line in which each begins; ... or & at the end of a line continues it."""
    begun, first = "", 0
    for number, line in enumerate(text.splitlines(), start=1):
        own = line.split(";")[0].rstrip()
        first = first or number
        stripped = own.removesuffix("...") if own.endswith("...") else own.removesuffix("&")
        begun += " " + stripped
        if stripped == own:
            yield first, begun
            begun, first = "", 0
    if begun:
        yield first, begun


def _is_block(word: str) -> bool:
    """Return True if a word is block, or short for it."""
    return len(word) > 1 and "block".startswith(word)


def _range_at(lower: Sequence[str]) -> int:
    """The place of the word range; the number of words where there is none."""
    return lower.index("range") if "range" in lower else len(lower)


def _quoted(words: Sequence[str]) -> str:
    text = " ".join(words[:3])
    return f'"{text[:40]}"'


def _changing(where: str, words: Sequence[str]) -> Refused:
    """The refusal of a command that is not read and may change blocks."""
    return Refused(where, f"{_quoted(words)} may change blocks and is not read; have the deck create them as they are in the end")


def _refuse_in_fish(where: str, lower: Sequence[str]) -> None:
    """Refuse commands on blocks that a function in FISH would give."""
    if _is_block(lower[0]) or lower[0] in OLD_READ or re.search(r"\bblock\.(create|delete|cut)", " ".join(lower)):
        raise _changing(f"{where}: in a function in FISH", lower)


def _done(where: str, pieces: list[FileShell], words: Sequence[str], lower: Sequence[str]) -> list[FileShell]:
    """The blocks after a command on them."""
    if "new" in (lower[0], *lower[1:2]):
        return []
    if lower[0] == "poly":
        at = 1
        while lower[at : at + 1] and lower[at][:3] in NUMBERED and re.fullmatch(r"\d+", " ".join(lower[at + 1 : at + 2])):
            at += 2
        return [*pieces, _created(where, lower[at] if len(lower) > at else "", words[at + 1 :], len(pieces))]
    is_set = lower[:1] == ["jset"] or (lower[1:3] == ["cut", "joint-set"] and _is_block(lower[0]))
    if is_set:
        first, end = (1 if lower[0] == "jset" else 3), _range_at(lower)
        everywhere = lower[0] != "jset"
        return cut_by_set(where, pieces, words[first:end], everywhere, lambda piece: _is_in_range(where, piece, lower, words))
    verb, at = (lower[0], 1) if lower[0] in OLD_READ else (_meant(lower[1] if len(lower) > 1 else ""), 2)
    if verb == "create":
        return [*pieces, _created(where, lower[at] if len(lower) > at else "", words[at + 1 :], len(pieces))]
    if verb in HARMLESS:
        return pieces
    if verb not in READ or verb == "cut":
        raise _changing(where, words)
    name = words[at].strip("'\"") if verb == "group" and len(words) > at else ""
    changes: dict[str, dict[str, Any]] = {"fix": {"fixed": True}, "free": {"fixed": False}, "group": {"group": name}}
    return [piece._replace(**changes[verb]) if _is_in_range(where, piece, lower[at:], words[at:]) else piece for piece in pieces]


def _meant(word: str) -> str:
    """The command that a word is, or is short for; the word itself where it is none or could be several."""
    known = [*READ, *HARMLESS, *NAMED]
    found = [one for one in known if len(word) > 2 and one.startswith(word)]
    return word if word in known or len(found) != 1 else found[0]


def _created(where: str, kind: str, words: Sequence[str], count: int) -> FileShell:
    """The block of one command."""
    group = ""
    if kind not in ("brick", "prism", "polyhedron", "face"):
        raise Refused(where, f"a block {kind or 'of no kind'} that is not read; brick, prism and polyhedron are")
    if "group" in [word.lower() for word in words]:
        at = [word.lower() for word in words].index("group")
        group, words = " ".join(words[at + 1 : at + 2]).strip("'\""), [*words[:at], *words[at + 2 :]]
    sets: list[list[float]] = [[]]
    for word in words:
        if re.fullmatch(NUMBER, word):
            sets[-1].append(float(word.lower().replace("d", "e")))
        elif re.fullmatch(r"face(?:-?\d)?|a|b", word.lower()):
            sets.append([])
        else:
            raise Refused(where, f'"{word[:40]}" where numbers of a block belong')
    if kind == "brick" and len(sets[0]) == 6:
        low, high = np.array(sets[0][::2]), np.array(sets[0][1::2])
        points = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        return FileShell(count, f"b{count}", points, BOX, group)
    loops = [np.array(one).reshape(-1, 3) for one in sets if one and len(one) % 3 == 0 and len(one) >= 9]
    if len(loops) != sum(map(bool, sets)):
        raise Refused(where, "a face has three corners or more, three coordinates each")
    if kind == "prism" and len(loops) == 2 and len(loops[0]) == len(loops[1]):
        near, far = loops
        n = len(near)
        loops = [near, far, *(np.array([near[k], near[(k + 1) % n], far[(k + 1) % n], far[k]]) for k in range(n))]
    elif kind in ("brick", "prism") or len(loops) < 4:
        raise Refused(where, "a brick has six numbers, a prism two faces of as many corners, a polyhedron four faces or more")
    return FileShell(count, f"b{count}", *_outward(loops), group)


def _outward(loops: Sequence[np.ndarray]) -> tuple[np.ndarray, Faces]:
    """Corners and faces of a convex solid, each turned outwards."""
    centre = np.concatenate(loops).mean(axis=0)
    points, one = np.unique(np.concatenate(loops), axis=0, return_inverse=True)
    faces, at = [], 0
    for loop in loops:
        own = tuple(int(i) for i in one.ravel()[at : at + len(loop)])
        at += len(loop)
        area = np.cross(loop - loop[0], np.roll(loop, -1, axis=0) - loop[0]).sum(axis=0)
        faces.append(own if float(area @ (loop.mean(axis=0) - centre)) > 0.0 else own[::-1])
    return points, tuple(faces)


def _is_in_range(where: str, piece: FileShell, lower: Sequence[str], words: Sequence[str]) -> bool:
    """Return True if a block is in the range of a command: all blocks, a group, or between two coordinates of its centre.

    Raises:
        Refused: another kind of range.
    """
    at = _range_at(lower)
    if at == len(lower):
        return True
    rest, names = list(lower[at + 1 :]), list(words[at + 1 :])
    centre = 0.5 * (piece.vertices.min(axis=0) + piece.vertices.max(axis=0))
    inside = bool(rest)
    while rest:
        axis = re.fullmatch(r"(?:position-)?([xyz])", rest[0])
        if rest[0] == "group" and len(rest) > 1:
            inside &= piece.group == names[1].strip("'\"")
            rest, names = rest[2:], names[2:]
        elif axis and len(rest) > 2 and all(re.fullmatch(NUMBER, w) for w in rest[1:3]):
            inside &= float(rest[1]) <= centre["xyz".index(axis[1])] <= float(rest[2])
            rest, names = rest[3:], names[3:]
        else:
            raise Refused(where, f'a range by "{names[0][:40]}" is not read; by group and position-x, -y and -z are')
    return inside
