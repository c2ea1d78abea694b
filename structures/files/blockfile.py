"""Block files: the blocks of a structure as JSON.

    {"units": "m", "blocks": [{"name": "v1", "vertices": [[x, y, z], ...], "faces": [[i, j, k, ...], ...],
                               "density": 2200, "fixed": false, "group": "arch"}, ...]}

Faces are zero-based loops of vertices, counter-clockwise seen from outside. A block that is not convex lists the convex parts that
fill it, ``"parts": [{"vertices": ..., "faces": ...}, ...]``, besides its own shell. Name, density, group and units have defaults:
b0, b1 ...; the material's density; ``base`` for fixed blocks and ``block`` for the others; metres. Other keys at the top
level are left alone, so that a program may keep its own notes in the same file.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from masonry_cd.errors import InputError, parse_table, suggest
from masonry_cd.model.blocks import Block
from masonry_cd.model.geometry import Faces, Polyhedron
from structures.files import meshfile
from structures.geometry.checks import Unsound, check, check_shells
from structures.geometry.convex import split
from structures.geometry.gaps import close_gaps
from structures.geometry.merge_coplanar import tidy
from structures.schema import Length, is_file

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
Finite = Annotated[float, Field(allow_inf_nan=False)]


class FileTable(BaseModel):
    """The [structure] table of a block file."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    path: str = Field(description="of the block file, relative to the scene file")
    units: Literal["m", "cm", "mm"] | None = Field(None, description="of an OBJ, STL, VTU or VTM file, which does not say")
    up: Literal["y", "z"] | None = Field(None, description="which axis of such a file points upwards")
    fixed: tuple[str, ...] = Field((), strict=False, description="names of the supports in such a file; * stands for anything")
    repair: bool = Field(False, description="mend duplicate corners and the orientation of faces of such a file")
    gaps: Length | None = Field(None, description="close gaps up to this width between blocks of any file [m]")


Vertices = Annotated[list[Annotated[list[Finite], Field(min_length=3, max_length=3)]], Field(min_length=4)]
Loops = Annotated[list[Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=3)]], Field(min_length=4)]


class Part(BaseModel):
    """A convex part of a block."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    vertices: Vertices
    faces: Loops


class Entry(BaseModel):
    """One block of a block file."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    name: str | None = Field(None, min_length=1)
    vertices: Vertices
    faces: Loops
    density: float | None = Field(None, gt=0, allow_inf_nan=False)
    fixed: bool = False
    group: str | None = Field(None, min_length=1)
    parts: list[Part] = []


def build_with_notes(table: Mapping[str, Any], density: float, folder: Path) -> tuple[list[Block], list[str]]:
    """Read the block file that a [structure] table names; the notes tell what closing gaps has moved."""
    keys = parse_table(FileTable, table, "structure")
    path = Path(keys.path)
    if not is_file(folder / path):
        raise InputError(f'structure.path: no file "{path}" in {folder}' if not path.is_absolute() else f'structure.path: no file "{path}"')
    path = folder / path
    is_mesh = path.suffix.lower() in meshfile.FORMATS
    for key in () if is_mesh else ("units", "up", "fixed", "repair"):
        if key in keys.model_fields_set:
            raise InputError(f"structure.{key}: belongs to {', '.join(meshfile.FORMATS)} files; {path.name} states it itself")
    blocks = _from_mesh(keys, path, density) if is_mesh else _from_json(path, density)
    if keys.gaps is not None:
        check_shells(blocks, path.name)
        try:
            blocks, moved, pairs = close_gaps(blocks, keys.gaps)
        except Unsound as failure:
            raise Unsound(f"{path.name}: {failure}", failure.faulty, failure.blocks) from None
        return sound(blocks, path.name), [f"{path.name}: {pairs} pairs of faces brought together, corners moved by at most {moved:.3g} m"]
    if is_mesh:
        return sound(blocks, path.name), []
    check(blocks, path.name)
    return tidy(blocks), []


def _from_mesh(keys: FileTable, path: Path, density: float) -> list[Block]:
    """Read a mesh file whose unit and axes the table states; not checked yet."""
    for key, known in (("units", METRES), ("up", ("y", "z"))):
        if getattr(keys, key) is None:
            raise InputError(f"structure.{key}: missing; {path.name} does not say it, so take one of {', '.join(known)}")
    blocks = meshfile.read(path, density, METRES[keys.units or "m"], keys.up or "z", keys.repair)
    return meshfile.with_supports(blocks, keys.fixed, "structure.fixed")


def sound(blocks: Sequence[Block], source: str) -> list[Block]:
    """Blocks of any shape, checked, those that are not convex split into convex parts.

    Raises:
        Unsound: one line that names the block.
    """
    check_shells(blocks, source)
    try:
        parted = [split(block) for block in blocks]
    except RuntimeError as failure:
        raise Unsound(f"{source}: {failure}", [str(failure).split('"')[1]], blocks) from None
    check(parted, source)
    return tidy(parted)


def read(path: Path, density: float) -> list[Block]:
    """Read and check a block file.

    Args:
        path: a JSON file as described above.
        density: for the blocks that state none [kg/m3].

    Raises:
        InputError: one line that names the file and the block, key or line.
    """
    blocks = _from_json(path, density)
    check(blocks, path.name)
    return tidy(blocks)


def _from_json(path: Path, density: float) -> list[Block]:
    """The blocks of a block file, not checked yet."""
    content = _load(path)
    scale = _scale(content, path)
    entries = content.get("blocks")
    if not isinstance(entries, list) or not entries:
        raise InputError(f'{path.name}: "blocks" must be a list of one block or more')
    return [_block(entry, i, density, scale, path) for i, entry in enumerate(entries)]


def write(path: Path, blocks: Sequence[Block]) -> None:
    """Write a block file in metres, one block per line; reading it gives the same blocks to the bit."""
    lines = []
    for block in blocks:
        entry: dict[str, Any] = {
            "name": block.name,
            "vertices": block.vertices.tolist(),
            "faces": [list(face) for face in block.faces],
            "density": block.density,
            "fixed": block.fixed,
            "group": block.group,
        }
        if block.parts:
            entry["parts"] = [{"vertices": p.vertices.tolist(), "faces": [list(face) for face in p.faces]} for p in block.parts]
        lines.append(json.dumps(entry))
    path.write_text('{"units": "m", "blocks": [\n' + ",\n".join(lines) + "\n]}\n", encoding="utf-8")


def _load(path: Path) -> dict[str, Any]:
    """Parse the JSON text."""
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as failure:
        raise InputError(f"{path.name}: cannot be read, {failure.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path.name}: no JSON text") from None
    except json.JSONDecodeError as failure:
        raise InputError(f"{path.name}: line {failure.lineno}, column {failure.colno}: {failure.msg}") from None
    except ValueError:  # of a number that Python does not convert
        raise InputError(f"{path.name}: a number of more than {sys.get_int_max_str_digits()} digits") from None
    except RecursionError:
        raise InputError(f"{path.name}: lists or objects nested too deep") from None
    if not isinstance(content, dict):
        raise InputError(f'{path.name}: must be an object with the key "blocks"')
    return content


def _scale(content: Mapping[str, Any], path: Path) -> float:
    """Metres per unit of the file."""
    units = str(content.get("units", "m"))
    if units not in METRES:
        raise InputError(f'{path.name}: unknown units "{units}"{suggest(units, METRES)}; known: {", ".join(METRES)}')
    return METRES[units]


def _block(entry: Any, index: int, density: float, scale: float, path: Path) -> Block:
    """Turn one entry into a block."""
    given = entry.get("name") if isinstance(entry, dict) else None
    where = f'{path.name}: block "{given}"' if isinstance(given, str) else f"{path.name}: blocks[{index}]"
    if not isinstance(entry, dict):
        raise InputError(f"{where}: must be an object with vertices and faces")
    parsed = parse_table(Entry, entry, where)
    vertices, faces = _shell(parsed, scale)
    return Block(
        name=parsed.name or f"b{index}",
        vertices=vertices,
        faces=faces,
        density=density if parsed.density is None else parsed.density,
        group=parsed.group or ("base" if parsed.fixed else "block"),
        fixed=parsed.fixed,
        parts=tuple(Polyhedron(*_shell(part, scale)) for part in parsed.parts),
    )


def _shell(entry: Entry | Part, scale: float) -> tuple[np.ndarray, Faces]:
    """Vertices in metres, and faces."""
    vertices = np.array(entry.vertices)
    return vertices if scale == 1.0 else vertices * scale, tuple(tuple(face) for face in entry.faces)
