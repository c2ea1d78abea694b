# SPDX-License-Identifier: GPL-3.0-or-later
"""Starter scenes: every key of a kind of structure and of the other tables, with its text, drawn from the schema of scenes.

The keys that a first scene needs are set. The others stand behind a #, with the value that holds without them; where nothing stands behind
the equals sign, there is no such value, or it follows from other keys.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from loads import KINDS as LOADS
from masonry_cd.app.scene_schema import TITLE, limit_schema, load_schema, schema_text, structure_schema
from masonry_cd.app.scene_text import toml_text
from masonry_cd.foundation.errors import InputError, one_line
from masonry_cd.foundation.extras import has
from masonry_cd.foundation.table_schema import Schema, table_schema
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.materials import Material
from reports.settings import Report

SCHEMA = "masonry-cd.schema.json"  # next to the scene, so that both may be moved and shared
COLUMN, WIDTH = 36, 138  # where texts begin and end
MATERIAL = {"density": 2200.0, "friction": 0.6}
LOAD = "sinusoidal"
RUN = {"dt": 2e-3, "duration": 4.0, "tolerance": 1e-6}
DRAWN = ("crack_map", "html")  # keys of report that a first scene sets, where pictures are installed


def write_starter(kind: str, path: Path, force: bool) -> list[Path]:
    """Write a starter scene, and into its folder the schema and the files that a kind reads.

    Args:
        kind: of structure.
        path: of the scene.
        force: overwrite what is there.

    Returns:
        what was written.

    Raises:
        InputError: an unknown kind, or a file that is there already.
    """
    from structures import kind_of

    own = kind_of(kind)
    texts = {path: starter(kind, path), path.with_name(SCHEMA): schema_text()}
    texts |= {path.with_name(name): text for name, text in own.files().items()}
    for file in texts:
        if file.is_dir():
            raise InputError(file, "is a folder; give -o a file")
        if file.exists() and not force and not _is_schema(file):
            raise InputError(file, "exists already; choose another file with -o, or overwrite it with --force")
    path.parent.mkdir(parents=True, exist_ok=True)
    for file, text in texts.items():
        file.write_text(text, encoding="utf-8")
    return list(texts)


def starter(kind: str, path: Path) -> str:
    """The text of a starter scene that is to lie at a path."""
    from structures import kind_of

    own, structure = kind_of(kind), structure_schema(kind)
    material = {"masonry": own.masonry, "friction": MATERIAL["friction"]} if own.masonry else MATERIAL
    about = structure["properties"]["kind"]["description"]
    lines = [
        f"#:schema ./{SCHEMA}",
        *textwrap.wrap(f"{about}.", WIDTH, initial_indent="# ", subsequent_indent="# "),
        one_line(f"# masonry-cd run {path.name} -o out/{path.stem}, then masonry-cd view out/{path.stem}"),
        "# Units are SI. Keys behind a # hold as they stand there; without a value they are not given, or follow from others.",
        *_line("title", f"A first scene: {kind}", "Of pictures and closing lines."),
        *_table("structure", structure, {"kind": kind, **own.first}),
        *_table("material", table_schema(Material), material),
        *_table("loads", load_schema(LOAD), {"kind": LOAD, **LOADS[LOAD].starter}, row=True),
        *_table("run", table_schema(Run), RUN),
        *_table("report", table_schema(Report), dict.fromkeys(DRAWN, has("pictures"))),
        *_table("limit", limit_schema(), {}),
    ]
    return "\n".join(lines) + "\n"


def _table(name: str, schema: Schema, given: Mapping[str, Any], row: bool = False) -> list[str]:
    """A table with all its keys, those given before the others; tables inside it at its end, behind a #."""
    keys: dict[str, Schema] = schema["properties"]
    lines = ["", f"[[{name}]]" if row else f"[{name}]"]
    for key in [*given, *(key for key in keys if key not in given and _inner(keys[key]) is None)]:
        lines += _line(key, given.get(key, keys[key].get("default")), _text(keys[key]), hidden=key not in given)
    for key in (key for key in keys if key not in given and _inner(keys[key]) is not None):
        inner = _inner(keys[key])
        assert inner is not None
        head = f"{name}.{key}"
        lines += _noted(f"# [[{head}]]" if "items" in keys[key] else f"# [{head}]", _text(keys[key]))
        for word, own in inner["properties"].items():
            lines += _line(word, own.get("default"), _text(own), hidden=True)
    return lines


def _inner(key: Schema) -> Schema | None:
    """The schema of the table that a key is, or is a list of; None where it is a value, or has one by default."""
    if "default" in key and key["default"] != []:
        return None
    choices = [key, key.get("items"), *key.get("anyOf", [])]
    return next((choice for choice in choices if isinstance(choice, dict) and "properties" in choice), None)


def _text(key: Schema) -> str:
    """Return the text on a key, with the words that it takes."""
    words = key.get("enum") or next((choice["enum"] for choice in key.get("anyOf", []) if "enum" in choice), ())
    said = key["description"].rstrip(".")
    return f"{said}: {' | '.join(map(toml_text, words))}" if words else said


def _line(key: str, value: Any, text: str, hidden: bool = False) -> list[str]:
    """A key with its value and its text."""
    written = "" if value is None else f" {toml_text(value)}"
    return _noted(f"{'# ' if hidden else ''}{key} ={written}", text)


def _noted(words: str, text: str) -> list[str]:
    """Words and a comment to their right, which may take several lines."""
    column = max(COLUMN, len(words) + 2)
    rows = textwrap.wrap(text, WIDTH - COLUMN - 2)
    return [f"{words:<{column}}# {rows[0]}", *(f"{'':<{COLUMN}}# {row}" for row in rows[1:])]


def _is_schema(file: Path) -> bool:
    """Return True if a file is the schema of a scene, as another start or another version wrote it."""
    try:
        return file.name == SCHEMA and json.loads(file.read_text(encoding="utf-8")).get("title") == TITLE
    except (OSError, ValueError, AttributeError):
        return False
