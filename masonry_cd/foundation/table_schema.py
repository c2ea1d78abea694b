# SPDX-License-Identifier: GPL-3.0-or-later
"""The JSON schema of a table of the scene file, drawn from its pydantic model, in the form that editors of TOML read (draft 7).

The text of a key is the docstring under its field, and the unit that the field declares, in brackets. Tables
inside a table are written in their place, without references; TOML has no null, so a key that may be left out has no such value.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

from masonry_cd.foundation.units import PATTERN, in_brackets, unit_of

Schema = dict[str, Any]

INSIDE = ("anyOf", "items", "prefixItems", "additionalProperties")  # of a schema, where further ones stand
DRAFT = "http://json-schema.org/draft-07/schema#"


def table_schema(model: type[BaseModel]) -> Schema:
    """The schema of a table: its keys with their texts, bounds and defaults."""
    made = model.model_json_schema(schema_generator=_WithTexts)
    plain: Schema = _plain(made, made.get("$defs", {}))
    return plain


def key_texts(model: type[BaseModel]) -> dict[str, str]:
    """Return the text on each key of a model, its unit in brackets behind it; those without a word or a unit are left out."""
    plain = {name: " ".join((field.description or "").replace("``", "").split()) for name, field in model.model_fields.items()}
    said = {model.model_fields[name].alias or name: in_brackets(text, unit_of(model.model_fields[name])) for name, text in plain.items()}
    return {name: text for name, text in said.items() if text}


class Later:
    """For ``json_schema_extra`` of a key whose tables are checked later: of which models they are, and what the schema says of them."""

    def __init__(self, models: tuple[type[BaseModel], ...], add: Callable[[Schema, list[Schema]], None]) -> None:
        self.models = models  # which is where units of such tables are looked for
        self._add = add

    def __call__(self, schema: Schema) -> None:
        """Complete the schema of the key."""
        self._add(schema, [table_schema(model) for model in self.models])


def rows(*models: type[BaseModel]) -> Later:
    """Return the schema of a list of tables, each of them of one of these models."""

    def add(schema: Schema, made: list[Schema]) -> None:
        schema["items"] = made[0] if len(made) == 1 else {"anyOf": made}

    return Later(models, add)


def table_of_its_own(model: type[BaseModel]) -> Later:
    """Return the schema of a table."""

    def add(schema: Schema, made: list[Schema]) -> None:
        schema |= made[0] | {key: schema[key] for key in ("description",) if key in schema}

    return Later((model,), add)


def one_or_by_name(model: type[BaseModel]) -> Later:
    """Return the schema of a table that holds the keys of one model, or tables of it by name."""

    def add(schema: Schema, made: list[Schema]) -> None:
        schema.pop("additionalProperties", None)
        schema["anyOf"] = [made[0], {"type": "object", "additionalProperties": made[0]}]

    return Later((model,), add)


class _WithTexts(GenerateJsonSchema):
    """The schema of models with the texts of their keys."""

    ignored_warning_kinds = {"skipped-choice", "non-serializable-default"}  # noqa: RUF012

    def encode_default(self, dft: Any) -> Any:
        """A default as JSON takes it; lists of numbers stay as they are, since inf would become null."""
        numbers = isinstance(dft, tuple) and all(isinstance(number, float) for number in dft)
        return list(dft) if numbers else super().encode_default(dft)

    def model_schema(self, schema: Any) -> Any:
        made = super().model_schema(schema)
        for name, text in key_texts(schema["cls"]).items():
            made["properties"][name]["description"] = text
        for name, field in schema["cls"].model_fields.items():
            if unit_of(field):
                made["properties"][field.alias or name] = _or_text(made["properties"][field.alias or name])
        return made


def _or_text(schema: Any) -> Any:
    """The schema of a key that has a unit: each of its numbers may be a text with another."""
    if isinstance(schema, list):
        return [_or_text(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    made = {key: _or_text(value) if key in INSIDE else value for key, value in schema.items()}
    return made | {"type": ["number", "string"], "pattern": PATTERN} if schema.get("type") == "number" else made


def _plain(schema: Any, definitions: Schema) -> Any:
    """A schema without references, titles of pydantic's and null, with tuples as draft 7 writes them."""
    if isinstance(schema, list):
        return [_plain(item, definitions) for item in schema]
    if not isinstance(schema, dict):
        return schema
    schema = dict(schema)
    if "$ref" in schema:
        schema = definitions[schema.pop("$ref").rpartition("/")[2]] | schema
    choices = [choice for choice in schema.pop("anyOf", []) if choice != {"type": "null"}]
    if len(choices) == 1:
        schema = choices[0] | schema
        return _plain(schema, definitions)
    if choices:
        schema["anyOf"] = choices
    if "prefixItems" in schema:
        schema["items"] = schema.pop("prefixItems")
    fallback = schema.pop("default", None)
    if fallback is not None and _is_finite(fallback):
        schema["default"] = fallback[0] if _is_single(fallback, choices) else fallback
    elif fallback is not None and "description" in schema:
        said = ", ".join(f"{number:g}" for number in (fallback if isinstance(fallback, (list, tuple)) else [fallback]))
        schema["description"] = f"{schema['description'].rstrip('.')}; by default [{said}]."
    properties = schema.pop("properties", None)
    for name in ("title", "$defs"):
        schema.pop(name, None)
    made = {key: value if key == "default" else _plain(value, definitions) for key, value in schema.items()}
    if properties is not None:
        made["properties"] = {name: _plain(key, definitions) for name, key in properties.items()}
    return made


def _is_finite(value: object) -> bool:
    """Return True if JSON can write a value."""
    if isinstance(value, (list, tuple)):
        return all(map(_is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


def _is_single(value: object, choices: list[Schema]) -> bool:
    """Return True if a list of one stands for its only value."""
    return isinstance(value, (list, tuple)) and len(value) == 1 and any({"number", "integer"} & {*_types(choice)} for choice in choices)


def _types(schema: Schema) -> list[str]:
    """The types of value that a schema takes."""
    types = schema.get("type", [])
    return types if isinstance(types, list) else [types]


def as_text(schema: Schema) -> str:
    """A schema as a file."""
    return json.dumps(schema, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
