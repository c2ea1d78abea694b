# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from elsewhere, CAD models and meshes, are read in a process of their own.

OpenCASCADE, VTK and the mesh libraries were written for files that mean well: one changed character may end the process, fill the
memory or go round for ever. So a reader is a function that runs in a child process, with limits of time, memory and size of its output,
without a shell, without the environment and in an empty folder that is removed. It answers in JSON, which is checked before it is used.
However the child ends, the caller gets one line that names the file.

A reader is named ``module:function``, takes the path and keywords that JSON knows, and returns an :class:`Answer`. It raises
:class:`Refused` with place and text for the user; the message of any other exception becomes "FILE: cannot be read: ...". The child
imports the reader's module and what that imports, so these keep to numpy and the one library that reads the format.

This keeps crashes and runaway files from the user. It does not take away the user's rights: a file that is a program, as a .geo is,
could still write where the user may, and is only read where the scene says that it is trusted.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from operator import index
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation import system

Faces = tuple[tuple[int, ...], ...]  # not imported from the model: a child that reads a file imports no kernels


class FileShell(NamedTuple):
    """A shell of the file."""

    number: int  # of the block that it is a part of, or of its course
    name: str  # of the block, or its group
    vertices: np.ndarray  # (V, 3)
    faces: Faces
    group: str = ""  # of the block, where the file states one
    fixed: bool = False  # stated so by the file
    density: float = 0.0  # stated by the file [kg/m3]; 0 where it states none


class FileContents(NamedTuple):
    """Contents of a file."""

    pieces: Sequence[Any]  # Piece each; of a plan what it is made of
    figures: Sequence[float] = ()  # whose meaning the reader states
    notes: Sequence[str] = ()  # a line each for the user: what of the file was not read


GIB = 2**30
MEMORY = 4 * GIB  # addresses [B]: gmsh takes 0.4 GiB and VTK with its readers 0.7 GiB before they open a file; the rest is for the file
MODEL, PER_BYTE = 3 * GIB // 2, 200  # of a CAD model of a given number of bytes, gmsh included: a church of 95 MB takes 0.7 GB
OUTPUT = GIB  # largest file that a child may write [B], its answer of some 100 B per corner among them
SECONDS = 120.0  # processor time [s]: an STL of 20,000 boxes takes 6, a VTU 3
WAIT = 2.0  # wall time, in processor times: another program may have the core, but a child that only waits has to end
LOADER = ("LD_LIBRARY_PATH", "SYSTEMROOT")  # of the environment, what a child needs to start: Windows the latter
SHOWN = 300  # most characters of a child's message
NOTES = 50  # most lines of its notes
ANSWER = "answer.json"  # in the child's folder
CHILD = """import json, sys
request = json.load(open("request.json", encoding="utf-8"))
sys.path[:] = request["path"]
from structures.files import foreign
foreign.serve(request)
"""


class Refused(Exception):
    """A reader finds a file wrong, see :class:`masonry_cd.foundation.errors.InputError`."""

    def __init__(self, place: object, text: str) -> None:
        super().__init__(place, text)
        self.place, self.text = str(place), text


class Limits(NamedTuple):
    """Limits on a child process."""

    seconds: float = SECONDS  # processor time [s]
    memory: int = MEMORY  # addresses [B]
    output: int = OUTPUT  # of each file that it writes [B]


def piece_of(number: Any, name: Any, vertices: Any, faces: Any, group: Any = "", fixed: Any = False, density: Any = 0.0) -> FileShell:
    """A piece of an answer.

    Raises:
        ValueError, TypeError: it is none.
    """
    points, loops = points_of(vertices), tuple(tuple(map(index, loop)) for loop in faces)
    if not all(0 <= corner < len(points) for loop in loops for corner in loop):
        raise ValueError("a face names a vertex that does not exist")
    return FileShell(int(number), word_of(name), points, loops, word_of(group), bool(fixed), float(density))


def word_of(word: Any) -> str:
    """A word of an answer, in which bytes that a library could not read are question marks.

    Raises:
        TypeError: it is none.
    """
    if not isinstance(word, str):
        raise TypeError(f"a word is {word!r}, not a string")
    return _utf8(word).decode()


def points_of(rows: Any) -> np.ndarray:
    """Points (P, 3) of an answer.

    Raises:
        ValueError, TypeError: they are none.
    """
    points = np.array(rows, dtype=float)
    if len(points) and points.shape[1:] != (3,):
        raise ValueError("points have three coordinates")
    return points.reshape(-1, 3)


def of_model(path: Path) -> Limits:
    """Return the limits of a child for a CAD model: memory by the size of its file, since a damaged surface asks for any."""
    limits = Limits()
    return limits._replace(memory=min(limits.memory, MODEL + PER_BYTE * path.stat().st_size))


def read(
    reader: str,
    path: Path,
    keywords: Mapping[str, Any] | None = None,
    limits: Limits | None = None,
    advice: str = "",
    of: Callable[..., Any] = piece_of,
) -> FileContents:
    """Read a file by a reader in a child process.

    Args:
        reader: ``module:function``, see above.
        path: of the file.
        keywords: for the reader, of kinds that JSON knows.
        limits: what the child may use.
        advice: what the user can do where it takes too long, at the end of that message.
        of: makes and checks each piece of the answer from what it holds.

    Raises:
        InputError: one line: the file cannot be read, or the child crashed, took too long or too much.
    """
    from masonry_cd.foundation.errors import InputError

    limits = limits or Limits()
    request = {
        "path": [os.path.abspath(place) for place in sys.path],
        "reader": reader,
        "file": os.path.abspath(path),
        "keywords": dict(keywords or {}),
        "limits": limits,
    }
    with tempfile.TemporaryDirectory(prefix="masonry-cd-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        (folder / "request.json").write_text(json.dumps(request), encoding="utf-8")
        code = _run(folder, limits)
        if (folder / "refused").is_file():
            raise InputError(*(_line(_utf8(word)) for word in json.loads((folder / "refused").read_bytes())))
        if code != 0 or not (folder / ANSWER).is_file():
            raise InputError(path.name, f"cannot be read: {_ending(code, limits, advice, folder)}")
        try:
            pieces, figures, notes = json.loads((folder / ANSWER).read_bytes())
            return FileContents([of(*piece) for piece in pieces], [*map(float, figures)], [_line(_utf8(note)) for note in notes[:NOTES]])
        except (ValueError, TypeError, AttributeError, ArithmeticError, RecursionError, OSError, MemoryError) as failure:
            raise InputError(path.name, f"cannot be read: its reader answers nonsense: {_line(str(failure).encode())}") from None


def _run(folder: Path, limits: Limits) -> int | None:
    """Run the child in its folder: its exit code, negative for a signal; None where it took too long."""
    loader = {name: os.environ[name] for name in LOADER if name in os.environ}
    homes = dict.fromkeys(("HOME", "USERPROFILE", "TMPDIR", "TEMP", "TMP"), str(folder))
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}  # each thread would take addresses for its stack and its arena
    with (folder / "said").open("wb") as said:
        child = subprocess.Popen(
            [sys.executable, "-I", "-c", CHILD],
            cwd=folder,
            env={"LANG": "C.UTF-8", **homes, **threads, **loader},
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=said,
            start_new_session=True,
        )
    try:
        return system.wait(child, WAIT * limits.seconds + 10.0, limits.seconds, limits.memory)
    finally:  # also after Ctrl-C, and whatever the child has started itself
        system.end(child)


def _ending(code: int | None, limits: Limits, advice: str, folder: Path) -> str:
    """How a child ended that gave no answer, as text."""
    memory = f"{limits.memory / GIB:.3g} GiB of memory"
    if code is None:
        return f"not done after {limits.seconds:g} s of computing; it is damaged or too large{advice}"
    if crash := system.name_of_crash(code):
        return f"its reader crashed ({crash}); it is damaged, or needs more than {memory}"
    said = (folder / "said").read_bytes()[-2000:].strip().splitlines()
    return f"its reader ended with code {code} and no answer{': ' + _line(said[-1]) if code and said else ''}"


def _utf8(word: str) -> bytes:
    """A word in UTF-8; bytes that a library could not read, which it hands on as surrogates, become question marks."""
    return word.encode(errors="replace")


def _line(text: bytes) -> str:
    """A child's message as one short line that a terminal can show."""
    shown = "".join(c if c.isprintable() else " " for c in text[: 4 * SHOWN].decode("utf-8", "replace"))
    shown = " ".join(shown.split())
    return shown if len(shown) <= SHOWN else shown[:SHOWN] + " ..."


# --- in the child ---------------------------------------------------------------------------------------------------------------------


def serve(request: Mapping[str, Any]) -> None:
    """Read the file of a request within its limits, write the answer or the refusal, and end the process.

    Ends without the libraries' own clearing up, which is a place to crash, too.
    """
    system.end_with_parent()
    system.limit_this_process(*Limits(*request["limits"]))
    answer(request)
    os._exit(0)


def answer(request: Mapping[str, Any]) -> None:
    """Read the file of a request and write the answer or the refusal into this folder."""
    limits, file = Limits(*request["limits"]), request["file"]
    try:
        module, function = request["reader"].split(":")
        made = FileContents(*getattr(import_module(module), function)(Path(file), **request["keywords"]))
        Path(ANSWER).write_text(json.dumps(made, default=lambda array: array.tolist()), encoding="utf-8")
    except Refused as refusal:
        _refuse(refusal.place, refusal.text)
    except MemoryError:
        _refuse(Path(file).name, f"cannot be read: it needs more than {limits.memory / GIB:.3g} GiB of memory")
    except ModuleNotFoundError as failure:
        from masonry_cd.foundation.extras import missing

        _refuse(Path(file).name, f"cannot be read: {missing(failure) or failure}")
    except (Exception, SystemExit) as failure:
        what = str(failure).strip() or type(failure).__name__
        _refuse(Path(file).name, f"cannot be read: {what.splitlines()[0]}")


def _refuse(place: str, text: str) -> None:
    Path("refused").write_text(json.dumps([place, text]), encoding="utf-8")
