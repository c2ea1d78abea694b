# SPDX-License-Identifier: GPL-3.0-or-later
"""Which files of a folder the program wrote itself: only these it overwrites or removes.

A folder of results has a list, ``.masonry-cd``, a line for each file at the moment when it was put into place:

    size [B]  digest  name

The digest is SHA-256 of the size and of the first and the last ``PIECE`` bytes, so that it costs nothing compared with the writing; a file
that is written for as long as a run goes has ``-`` for both, and is recognised by its name. Lines are appended before the file gets its
name, so that no kill leaves a file that is not listed. A file that somebody has edited since is theirs. Folders of earlier versions have no
list: the caller says what proves whose they are.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from pathlib import Path

from masonry_cd.foundation.errors import InputError

LIST = ".masonry-cd"
PIECE = 1 << 20  # [B]
GROWING = "- -"
MOST_NAMED = 40
HALF = ".part."  # in the name of a file that is not yet whole, see masonry_cd/foundation/atomic.py

Proof = Callable[[Path], bool]


def no_proof(_: Path) -> bool:
    """Return False: of a folder without a list nothing is known."""
    return False


def begin(folder: Path, names: Iterable[str], proof: Proof = no_proof) -> None:
    """Make a folder of results if need be, and its list; from now on what is written there is listed.

    Args:
        folder: for results.
        names: that the caller may write or remove, patterns with ``*`` included.
        proof: whether a folder that has no list holds results of an earlier version, whose files of these names are then ours.

    Raises:
        InputError: as :func:`check`; nothing is made then.
    """
    names = tuple(names)
    check(folder, names, proof)
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / LIST).exists():
        lines = [_line(path) for path in _there(folder, names)]
        (folder / LIST).write_text("".join(lines), encoding="utf-8")


def check(folder: Path, names: Iterable[str], proof: Proof = no_proof) -> None:
    """Refuse a folder where files of these names are not ours.

    Raises:
        InputError: names all of them.
    """
    there = _there(folder, names)
    if not there or (not (folder / LIST).exists() and proof(folder)):
        return
    listed = _read(folder)
    refuse(folder, [path.name for path in there if not _is_unchanged(path, listed)])


def refuse(folder: Path, others: list[str]) -> None:
    """Refuse a folder where these files are not ours.

    Raises:
        InputError: there are any; it names them.
    """
    if others:
        named = ", ".join(others[:MOST_NAMED]) + (f" and {len(others) - MOST_NAMED} more" if len(others) > MOST_NAMED else "")
        raise InputError(
            folder,
            f"the program would overwrite or remove files that it did not write, or that were edited since: {named}; "
            "move them away, or name another folder (--force overwrites its own files alone)",
        )


def others_below(folder: Path, ours: Callable[[Path], bool]) -> list[Path]:
    """Files in a folder and the folders below it that are neither listed where they lie, nor ``ours`` by the path from the folder."""
    listed = {place: _read(place) for place in (folder, *(path for path in folder.rglob("*") if path.is_dir()))} if folder.is_dir() else {}
    files = sorted(path for place in listed for path in place.iterdir() if path.name != LIST and not path.is_dir())
    return [path for path in files if not ours(path.relative_to(folder)) and not _is_unchanged(path, listed[path.parent])]


def note(path: Path, source: Path | None = None, growing: bool = False) -> None:
    """List a file, where its folder has a list; ``source`` is where it lies until it gets its name."""
    if HALF in path.name or not (path.parent / LIST).exists():
        return
    said, known = GROWING if growing else _print(source or path), _read(path.parent).get(path.name, set())
    if not known & {GROWING, said}:
        with (path.parent / LIST).open("a", encoding="utf-8") as file:
            file.write(f"{said} {path.name}\n")


def adopt(folder: Path) -> None:
    """Begin the list of a folder that the program has just filled: all that is there is its own."""
    (folder / LIST).write_text("".join(_line(path) for path in _there(folder, ("*",))), encoding="utf-8")


def guard(path: Path) -> None:
    """Refuse to write over a file that is not ours, in a folder that has a list.

    Raises:
        InputError: names it.
    """
    if HALF not in path.name and path.exists() and (path.parent / LIST).exists():
        check(path.parent, (path.name,))


def remove(folder: Path, names: Iterable[str]) -> None:
    """Take away those of these files that are ours."""
    listed = _read(folder)
    for path in _there(folder, names):
        if _is_unchanged(path, listed):
            path.unlink(missing_ok=True)


def _there(folder: Path, names: Iterable[str]) -> list[Path]:
    """The files of a folder that have one of these names; patterns take neither the list nor what a kill has left half written."""
    names = tuple(names)
    if not folder.is_dir():
        return []
    exact, patterns = {name for name in names if "*" not in name}, [name for name in names if "*" in name]

    def named(name: str) -> bool:
        return name in exact or (name != LIST and HALF not in name and any(fnmatchcase(name, one) for one in patterns))

    return sorted(path for path in folder.iterdir() if named(path.name) and not path.is_dir())


def _read(folder: Path) -> dict[str, set[str]]:
    """Return the entries of the list for each file; empty where there is none."""
    try:
        lines = (folder / LIST).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return {}
    found: dict[str, set[str]] = {}
    for part in (line.split(" ", 2) for line in lines):
        if len(part) == 3:
            found.setdefault(part[2], set()).add(f"{part[0]} {part[1]}")
    return found


def _is_unchanged(path: Path, listed: dict[str, set[str]]) -> bool:
    """Return True if a file is as it was written once."""
    said = listed.get(path.name, set())
    return GROWING in said or (bool(said) and _print(path) in said)


def _line(path: Path) -> str:
    return f"{_print(path)} {path.name}\n"


def _print(path: Path) -> str:
    """Size and digest of a file; empty where it cannot be read."""
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
            digest = hashlib.sha256(str(size).encode())
            for start in (0, max(0, size - PIECE)):
                file.seek(start)
                digest.update(file.read(PIECE))
    except OSError:
        return ""
    return f"{size} {digest.hexdigest()[:32]}"
