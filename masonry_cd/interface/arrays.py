# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks and base motions that come as arrays: they become files of the kinds that scenes read.

The blocks of a structure become a block file (:mod:`structures.files.blockfile`), each base motion a table of numbers
(:mod:`loads.readers.tables`), with every digit of their numbers. So there is one way by which geometry and motion enter a run, with one set
of checks, and what a run was made of lies next to its results as files that the command line reads as well.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from masonry_cd.foundation.errors import InputError, parse_table, suggest
from masonry_cd.interface.values import numbers

if TYPE_CHECKING:
    from masonry_cd.mechanics.model.blocks import Block

BLOCKS = "blocks"  # key of [structure] that takes arrays
FIXED = "fixed"  # key next to it: names of the supports
TIME, CHANNELS = "time", "channels"  # keys of a record in Python: its times, and names of the components that follow
MOTION = {"acceleration": "m_s2", "velocity": "m_s", "displacement": "m"}  # what it may be of, and the SI unit as a heading has it
AXES = "xyz"
NAME = re.compile(r"[\w.-]+")  # of a component: no delimiter of a table
SHELL, ROUND = ("vertices", "faces"), ("centre", "radius")  # of a polyhedron, and of a sphere
FIELDS = ("name", *SHELL, *ROUND, "density", "group", "fixed")  # of a block that comes as a dict
BLOCK_FILE = "blocks.json"


def hold_arrays(tables: Mapping[str, Any]) -> bool:
    """Return True if some of the tables of a scene hold geometry or motion as arrays."""
    structure, loads = tables.get("structure"), tables.get("loads")
    own_blocks = _is_list(structure) or (isinstance(structure, Mapping) and BLOCKS in structure)
    own_motion = _is_list(loads) and any(_moves_by_arrays(load) for load in loads)
    return own_blocks or own_motion or bool(_among_several(tables))


def _moves_by_arrays(load: Any) -> bool:
    """Return True if a table of ``loads``, or a component of its shocks, is a record of arrays; other kinds have keys of their own."""
    if not isinstance(load, Mapping):
        return False
    if load.get("kind") == "sequence":
        return any(_moves_by_arrays(component) for component in _components(load))
    keys = (TIME, *MOTION) if "kind" in load else (TIME,)
    return load.get("kind", "record") == "record" and any(key in load for key in keys)


def _components(load: Mapping[str, Any]) -> list[Any]:
    """The components of the shocks of a sequence."""
    shocks = load.get("shocks")
    tables = [shock.get("components") for shock in shocks if isinstance(shock, Mapping)] if _is_list(shocks) else []
    return [component for each in tables if _is_list(each) for component in each]


def into_files(tables: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The tables of a scene with files instead of arrays.

    Args:
        tables: of a scene; what holds no arrays is handed through.
        folder: where the files are written.

    Raises:
        InputError: arrays that have not the shape that they should have; names the block or the key.
    """
    out = dict(tables)
    structure, loads = tables.get("structure"), tables.get("loads")
    for i in _among_several(tables):
        raise InputError(f"structures[{i}].{BLOCKS}", "blocks as arrays are those of one structure; here path names a block file")
    if _is_list(structure):
        structure = {BLOCKS: structure}
    if isinstance(structure, Mapping) and BLOCKS in structure:
        out["structure"] = _structure(structure, folder)
    if _is_list(loads):
        out["loads"] = [load for i, table in enumerate(loads) for load in _load(table, f"loads[{i}]", folder)]
    return out


def _is_list(value: object) -> TypeGuard[Sequence[Any]]:
    """Return True if a value is a list of any kind."""
    return isinstance(value, Sequence) and not isinstance(value, str | bytes)


def _among_several(tables: Mapping[str, Any]) -> list[int]:
    """Places of those [[structures]] whose blocks are arrays, which is refused."""
    several = tables.get("structures")
    return [i for i, table in enumerate(several) if isinstance(table, Mapping) and BLOCKS in table] if _is_list(several) else []


def _structure(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """A [structure] table whose blocks are arrays, with a block file in their place."""
    from structures.files import blockfile
    from structures.files.supports import Supports, with_supports

    rest = {key: value for key, value in table.items() if key not in (BLOCKS, FIXED)}
    if rest.get("kind", "file") != "file" or "path" in rest:
        raise InputError("structure.blocks", 'blocks as arrays are a structure of kind "file" without a path')
    listed = table[BLOCKS]
    if hasattr(listed, "geometry") and callable(getattr(listed, "dump", None)):  # a scene of trimesh: its meshes where they stand
        listed = listed.dump()
    if not _is_list(listed) or not len(listed):
        raise InputError("structure.blocks", "a list of blocks is needed, each (vertices, faces), a dict or a Block")
    blocks = [_block(given, i) for i, given in enumerate(listed)]
    rules = parse_table(Supports, {FIXED: table.get(FIXED, ())}, "structure").fixed
    blockfile.write(folder / BLOCK_FILE, with_supports(blocks, rules, "structure.fixed"))
    return {"kind": "file", "path": BLOCK_FILE} | rest


def _block(given: Any, index: int) -> Block:
    """One block: as it is, from (vertices, faces), or from a dict with the keys of a block file."""
    from masonry_cd.mechanics.model.blocks import Block
    from masonry_cd.mechanics.model.sphere import ball_centre

    if isinstance(given, Block):
        table: Mapping[str, Any] = {key: getattr(given, key) for key in FIELDS if key not in ROUND}
        if given.radius:
            flat = {key: table[key] for key in table if key not in SHELL}
            table = {**flat, "centre": ball_centre(given.vertices), "radius": given.radius}
        if given.fixed and given.group == Block.group:  # that of blocks that name none; of supports it is another
            table = {**table, "group": None}
    elif isinstance(given, Mapping):
        table = given
    elif _is_list(given) and len(given) == 2:
        table = {"vertices": given[0], "faces": given[1]}
    elif (shell := shell_of(given)) is not None:
        table = shell
    else:
        raise InputError(f"structure.blocks[{index}]", f"(vertices, faces), a dict or a Block is needed, got a {type(given).__name__}")
    name = str(table.get("name") or f"b{index}")
    where = f'structure.blocks: block "{name}"'
    for key in table:
        if key not in FIELDS:
            raise InputError(where, f"{key}: unknown key{suggest(str(key), FIELDS)}; known keys: {', '.join(FIELDS)}")
    is_round = any(key in table for key in ROUND)
    for key in ROUND if is_round else SHELL:
        if key not in table:
            raise InputError(where, f"{key}: missing")
    for key in SHELL if is_round else ():
        if key in table:
            raise InputError(where, f"{key}: a sphere, which has centre and radius, has none")
    fixed, density = bool(table.get("fixed", False)), table.get("density")
    common: dict[str, Any] = {
        "name": name,
        "density": float("nan") if density is None else float(density),
        "group": str(table.get("group") or ("base" if fixed else "block")),
        "fixed": fixed,
    }
    if is_round:
        radius = float(numbers(table["radius"], f"{where}: radius", ()))
        return Block.sphere(centre=numbers(table["centre"], f"{where}: centre", (3,)), radius=radius, **common)
    return Block(
        vertices=numbers(table["vertices"], f"{where}: vertices", (-1, 3)),
        faces=_faces(table["faces"], where),
        parts=given.parts if isinstance(given, Block) else (),
        carried=given.carried if isinstance(given, Block) else None,
        **common,
    )


def shell_of(given: Any) -> dict[str, Any] | None:
    """Vertices, faces and a name, if any, of an object that has them: of trimesh, pyvista, COMPAS, or any like these; else None.

    trimesh has the name among its metadata, as read from a file, or from the node of a scene.
    """
    metadata = getattr(given, "metadata", None)
    name = getattr(given, "name", None) or (metadata.get("node") or metadata.get("name") if isinstance(metadata, Mapping) else None)
    about = {"name": name} if isinstance(name, str) and name else {}
    if callable(getattr(given, "to_vertices_and_faces", None)):  # of COMPAS
        vertices, faces = given.to_vertices_and_faces()
        return about | {"vertices": vertices, "faces": faces}
    if hasattr(given, "points") and hasattr(given, "faces"):  # of pyvista: faces in a row, each behind the number of its corners
        row, loops, at = np.asarray(given.faces).ravel().tolist(), [], 0
        while at < len(row):
            loops.append(row[at + 1 : at + 1 + row[at]])
            at += 1 + row[at]
        return about | {"vertices": given.points, "faces": loops}
    if hasattr(given, "vertices") and hasattr(given, "faces"):
        return about | {"vertices": given.vertices, "faces": given.faces}
    return None


def _faces(given: Any, where: str) -> tuple[tuple[int, ...], ...]:
    """Loops of vertex indices."""
    try:
        loops = tuple(tuple(_whole(index) for index in loop) for loop in given)
    except (TypeError, ValueError):
        raise InputError(where, "faces: loops of whole numbers are needed, [[0, 1, 2], ...], counted from zero") from None
    return loops


def _whole(index: Any) -> int:
    """A whole number."""
    number = int(index)
    if number != index:
        raise ValueError
    return number


def _load(table: Any, where: str, folder: Path) -> list[Any]:
    """A [[loads]] table; one of a motion given by arrays becomes a table for each of its components."""
    if not _moves_by_arrays(table):
        return [table]
    if table.get("kind") == "sequence":
        return [_sequence(table, where, folder)]
    return [{"kind": "record", **component} for component in _record(table, where, folder)]


def _sequence(table: Mapping[str, Any], where: str, folder: Path) -> dict[str, Any]:
    """A sequence some of whose components are arrays."""
    shocks = []
    for i, shock in enumerate(table["shocks"]):
        given = shock.get("components") if isinstance(shock, Mapping) else None
        if _is_list(given):
            made = [
                _record(one, f"{where}.shocks[{i}].components[{j}]", folder) if _moves_by_arrays(one) else [one]
                for j, one in enumerate(given)
            ]
            shock = {**shock, "components": [component for each in made for component in each]}
        shocks.append(shock)
    return {**table, "shocks": shocks}


def _record(table: Mapping[str, Any], where: str, folder: Path) -> list[dict[str, Any]]:
    """The keys of a record given by arrays, without its kind, for each of its components."""
    given = [key for key in MOTION if key in table]
    missing = TIME if TIME not in table else "acceleration" if not given else ""
    if missing:
        raise InputError(f"{where}.{missing}", "missing; a motion by arrays has time, and acceleration, velocity or displacement")
    if len(given) > 1:
        raise InputError(f"{where}.{given[1]}", f"a motion by arrays is given once, and here is {given[0]}, too")
    (quantity,) = given
    rest = {key: value for key, value in table.items() if key not in ("kind", TIME, CHANNELS, quantity)}
    other = next((key for key in ("path", "column", "units", "time_step", "format") if key in rest), None)
    if other is not None:
        raise InputError(
            f"{where}.{other}", f"belongs to a record in a file; time is in s, {quantity} in {MOTION[quantity].replace('_', '/')}"
        )
    if rest.get("quantity", quantity) != quantity:
        raise InputError(f"{where}.quantity", f'"{rest["quantity"]}", but the key of the values is {quantity}')
    time, values = _motion(table, quantity, where)
    components = values.shape[1]
    for key in ("direction", "target_pga") if components > 1 else ():
        if key in rest:
            raise InputError(
                f"{where}.{key}", f"of a motion of one component; this one has {components}, along {', '.join(AXES[:components])}"
            )
    names = _names(table, components, where)
    common = {"path": _write_motion(folder, [f"{name}_{MOTION[quantity]}" for name in names], time, values), **rest}
    if quantity != "acceleration":
        common["quantity"] = quantity
    if components == 1:
        return [common]
    moving = [k for k in range(components) if values[:, k].any()] or [0]  # a component that is zero throughout is none
    return [common | {"column": names[k], "direction": AXES[k]} for k in moving]


def _names(table: Mapping[str, Any], components: int, where: str) -> list[str]:
    """Names of the components: of their channels where they are given."""
    given = table.get(CHANNELS)
    if given is None:
        return [*AXES[:components]] if components > 1 else ["a"]
    names = [given] if isinstance(given, str) else [*given] if _is_list(given) else []
    fitting = len(names) == components == len(set(names)) and all(isinstance(name, str) and NAME.fullmatch(name) for name in names)
    if not fitting or any(name.lower().startswith(TIME) for name in names):
        raise InputError(
            f"{where}.{CHANNELS}", f"{components} different names of letters, digits, dots and hyphens are needed, got {given}"
        )
    return names


def _motion(table: Mapping[str, Any], quantity: str, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (N,) [s] and accelerations, velocities or displacements (N, 1 to 3) in SI; these may be a function of a time."""
    if callable(table[quantity]):
        function, times = table[quantity], numbers(table[TIME], f"{where}.{TIME}", (-1,))
        table = {**table, quantity: [function(time) for time in times.tolist()]}
    given = np.asarray(table[quantity], dtype=object)
    values = numbers(table[quantity], f"{where}.{quantity}", (-1,) * max(1, min(2, given.ndim))).reshape(len(given), -1)
    if not 1 <= values.shape[1] <= len(AXES):
        raise InputError(f"{where}.{quantity}", f"one to three components are needed, (N,) or (N, 3), got {values.shape}")
    time = numbers(table[TIME], f"{where}.{TIME}", (-1,))
    if len(time) != len(values):
        raise InputError(
            f"{where}.{TIME}", f"{len(time)} times for {len(values)} {'values' if quantity != 'acceleration' else 'accelerations'}"
        )
    return time, values


def _write_motion(folder: Path, headings: Sequence[str], time: np.ndarray, values: np.ndarray) -> str:
    """Write a motion as CSV under the next free name, which is returned."""
    from masonry_cd.foundation.csv_files import write_csv

    number = next(n for n in range(1, 10**6) if not (folder / f"motion{n}.csv").exists())
    rows = np.column_stack([time, values]).tolist()
    write_csv(folder / f"motion{number}.csv", ["time_s", *headings], (map(repr, row) for row in rows))
    return f"motion{number}.csv"
