"""Structures from a file: blocks in JSON (:mod:`structures.files.blockfile`) or closed shells (:mod:`structures.files.meshfile`)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.files import is_file
from masonry_cd.foundation.quantities import length
from masonry_cd.mechanics.model.blocks import Block, refuse_spheres
from structures.files import blockfile, meshfile
from structures.files.blockfile import METRES, sound
from structures.files.supports import Rules, with_supports
from structures.geometry.checks import Unsound, check, check_shells
from structures.geometry.flatten import flattened
from structures.geometry.gaps import close_gaps
from structures.geometry.merge_coplanar import merge_coplanar
from structures.kinds.solid import SUFFIXES
from structures.schema import Height, Length


class FileTable(BaseModel):
    """The [structure] table of a block file."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    path: str = Field(description="of the block file, relative to the scene file")
    units: Literal["m", "cm", "mm"] | None = Field(None, description="of an OBJ, STL, VTU or VTM file, which does not say")
    up: Literal["y", "z"] | None = Field(None, description="which axis of such a file points upwards")
    fixed: Rules = Field(
        (),
        description='supports: names (* stands for anything), "ground" for what touches it, tables of below, box, group, name, or a list',
    )
    repair: bool = Field(False, description="mend duplicate corners and the orientation of faces of such a file")
    flatness: Height | None = Field(None, description="faces this near to a plane are made flat; a thousandth of the block when not given")
    gaps: Length | None = Field(None, description="close gaps up to this width between blocks of any file")


def build(table: Mapping[str, Any], density: float, folder: Path) -> tuple[list[Block], list[str]]:
    """Read the block file that a [structure] table names; the notes say how far closing gaps has moved corners."""
    keys = parse_table(FileTable, table, "structure")
    path = Path(keys.path)
    if not is_file(folder / path):
        raise InputError(f'structure.path: no file "{path}" in {folder}' if not path.is_absolute() else f'structure.path: no file "{path}"')
    path = folder / path
    is_mesh = path.suffix.lower() in meshfile.FORMATS
    if not is_mesh and path.suffix.lower() != ".json" and not _looks_like_json(path):
        raise InputError(
            f'structure.path: {path.name} is no file of blocks; kind = "file" reads .json, {", ".join(meshfile.FORMATS)}, '
            f'and kind = "solid" {", ".join(SUFFIXES)}'
        )
    for key in () if is_mesh else ("units", "up", "repair"):
        if key in keys.model_fields_set:
            raise InputError(f"structure.{key}: belongs to {', '.join(meshfile.FORMATS)} files; {path.name} states it itself")
    blocks = _from_mesh(keys, path, density) if is_mesh else blockfile.read_unchecked(path, density)
    blocks = with_supports(blocks, keys.fixed, "structure.fixed", "base" if is_mesh else None)
    blocks, moved, uneven = flattened(blocks, keys.flatness)
    notes = [f"{path.name}: faces of {uneven} blocks made flat, corners moved by at most {length(moved)}"] if uneven else []
    if keys.gaps is not None:
        refuse_spheres(blocks, "structure.gaps: closing gaps between faces")
        check_shells(blocks, path.name)
        try:
            blocks, moved, pairs = close_gaps(blocks, keys.gaps)
        except Unsound as failure:
            raise Unsound(f"{path.name}: {failure}", failure.faulty, failure.blocks) from None
        return sound(blocks, path.name), [
            *notes,
            f"{path.name}: {pairs} pairs of faces brought together, corners moved by at most {moved:.3g} m",
        ]
    if is_mesh:
        return sound(blocks, path.name), notes
    check(blocks, path.name)
    return merge_coplanar(blocks), notes


def _looks_like_json(path: Path) -> bool:
    """Whether a file of unknown ending begins as an object of JSON does."""
    try:
        with path.open("rb") as file:
            return file.read(256).removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"{")
    except OSError as failure:
        raise InputError(f"structure.path: {path.name}: cannot be read, {failure.strerror}") from None


def _from_mesh(keys: FileTable, path: Path, density: float) -> list[Block]:
    """Read a mesh file whose unit and axes the table states; not checked yet."""
    for key, known in (("units", METRES), ("up", ("y", "z"))):
        if getattr(keys, key) is None:
            raise InputError(f"structure.{key}: missing; {path.name} does not say it, so take one of {', '.join(known)}")
    return meshfile.read(path, density, METRES[keys.units or "m"], keys.up or "z", keys.repair)
