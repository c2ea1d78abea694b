# SPDX-License-Identifier: GPL-3.0-or-later
"""The inputs of a run other than the text of its scene, so that no run continues with other ones than it began with.

Files are known by their names in the scene: those under a key ``path``, in a folder there, and those that a VTM file lists. In addition to
their bytes, what was made of them and of the scene counts, in case a newer version of the program makes something else of it.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_bytes

if TYPE_CHECKING:
    from masonry_cd.app.case import Case

LISTED = re.compile(rb"""\bfile\s*=\s*["']([^"']+)["']""")  # in a VTM file
BLOCKS, LOADS = "the blocks that the scene makes", "the loads that the scene makes"


def digests(case: Case) -> dict[str, str]:
    """SHA-256 of the files that a scene reads, by their names in it, and of its blocks and loads.

    Raises:
        InputError: a file that cannot be read any more.
    """
    scene, loading, assembly = case.scene, case.loading, case.assembly
    found = file_digests([scene.structure, *scene.structures, *scene.loads], scene.folder)
    solids = assembly.shapes.solids
    found[BLOCKS] = _sum((assembly.centre, assembly.mass, assembly.inertia, assembly.fixed, solids.vertices, solids.loops))
    found[LOADS] = _sum((loading.support_velocity, loading.acceleration))
    return found


def file_digests(tables: Sequence[Mapping[str, Any]], folder: Path) -> dict[str, str]:
    """SHA-256 of the files that tables of a scene name, by these names, which are relative to a folder.

    Raises:
        InputError: a file that cannot be read.
    """
    found: dict[str, str] = {}
    for name in (file for path in paths_of(tables) for file in _files_of(path, folder)):
        data = _read(folder / name)
        found[name] = hashlib.sha256(data).hexdigest()
        if name.lower().endswith(".vtm"):
            for part in sorted({match.decode("utf-8", "replace") for match in LISTED.findall(data)}):
                found[str(Path(name).parent / part)] = hashlib.sha256(_read((folder / name).parent / part)).hexdigest()
    return found


def _files_of(name: str, folder: Path) -> list[str]:
    """A file itself; of a folder of meshes the names of its files."""
    path = folder / name
    return sorted(str(Path(name) / one.name) for one in path.iterdir() if one.is_file()) if path.is_dir() else [name]


def require_same(now: Mapping[str, str], then: Mapping[str, str], file: Path) -> None:
    """Refuse to continue the results in a file, which were made with inputs that are others now.

    Raises:
        InputError: names the first that differs.
    """
    for name in sorted(now.keys() | then.keys(), key=lambda name: (name in (BLOCKS, LOADS), name)):
        if now.get(name) != then.get(name):
            raise InputError(file, f"{name}: not what it was when the run began; restore it to resume, or start again with --force")


def paths_of(value: Any) -> Iterator[str]:
    """The values of all keys ``path`` in a table or a list of tables, those of tables within tables included."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            if key == "path" and isinstance(item, str):
                yield item
            else:
                yield from paths_of(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from paths_of(item)


def _read(path: Path) -> bytes:
    """The bytes of a file."""
    try:
        return read_bytes(path)
    except OSError as failure:
        raise InputError(path, f"cannot be read ({failure.strerror})") from None


def _sum(arrays: Iterable[np.ndarray]) -> str:
    """SHA-256 of the shapes and bytes of some arrays."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(f"{array.shape} ".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
