# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder of meshes, a file a stone, as scans come: read in one child process (:mod:`structures.files.foreign`).

Files are taken in the order of their names, numbers in them by their size. A stone has the name of its file; a file of several shells
numbers them. Formats that state a unit of their own would have to agree with all others, and are refused. Hidden files are passed over;
what is not a mesh is counted.
"""

from __future__ import annotations

import re
from collections import Counter
from importlib import import_module
from pathlib import Path

from structures.files.foreign import FileContents, FileShell, Refused

READ = ("obj", "stl", "ply", "off", "vtp", "vtu", "msh")  # which state neither unit nor axis


def read(path: Path) -> FileContents:
    """The stones of the files of a folder.

    Raises:
        Refused: no mesh in it, one that cannot be read, or one of a format that states its unit.
    """
    from structures.files.formats import FORMATS, format_of

    pieces: list[FileShell] = []
    notes: list[str] = []
    unread: Counter[str] = Counter()
    for file in sorted((file for file in path.iterdir() if file.is_file() and not file.name.startswith(".")), key=_in_order):
        name = format_of(file)
        if name in (None, "json"):
            unread[file.suffix.lower() or "no ending"] += 1
            continue
        if name not in READ:
            raise Refused(file.name, f"of a folder {', '.join(f'.{one}' for one in READ)} are read, which state no unit")
        module, _, function = FORMATS[name].reader.partition(":")
        made = getattr(import_module(module), function)(file)
        numbers = list(dict.fromkeys(piece.number for piece in made.pieces))
        first, names = len(pieces), [f"{file.stem}.{k}" for k in range(len(numbers))] if len(numbers) > 1 else [file.stem]
        for piece in made.pieces:
            k = numbers.index(piece.number)
            pieces.append(piece._replace(number=first + k, name=names[k]))
        notes += made.notes
    if not pieces:
        raise Refused(path.name, f"no mesh in this folder; {', '.join(f'.{one}' for one in READ)} are read")
    kinds = ", ".join(f"{count} {what}" for what, count in sorted(unread.items()))
    return FileContents(pieces, (), [*notes, *([f"{path.name}: files that are no meshes not read: {kinds}"] if kinds else [])])


def _in_order(file: Path) -> list[tuple[int, str]]:
    """Names by their words, and numbers in them by size: s2 before s10."""
    return [(int(word), "") if word.isdigit() else (-1, word) for word in re.split(r"(\d+)", file.name.lower())]
