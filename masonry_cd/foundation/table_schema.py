"""The JSON schema of a table of the scene file, drawn from its pydantic model, in the form that editors of TOML read (draft 7).

The text of a key is the description of its field, or the docstring under it. Tables inside a table are written in their place, without
references; TOML has no null, so a key that may be left out has no such value.
"""

from __future__ import annotations

import ast
import inspect
import json
import math
import textwrap
from collections.abc import Callable
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

Schema = dict[str, Any]

DRAFT = "http://json-schema.org/draft-07/schema#"


def table_schema(model: type[BaseModel]) -> Schema:
    """The schema of a table: its keys with their texts, bounds and defaults."""
    made = model.model_json_schema(schema_generator=_WithTexts)
    plain: Schema = _plain(made, made.get("$defs", {}))
    return plain


def key_texts(model: type[BaseModel]) -> dict[str, str]:
    """What is said of each key of a model; those without a word are left out."""
    texts: dict[str, str] = {}
    for part in reversed(model.__mro__):
        if part is not BaseModel and issubclass(part, BaseModel):
            texts |= _docstrings(part)
    texts |= {name: field.description for name, field in model.model_fields.items() if field.description}
    return {name: " ".join(text.replace("``", "").split()) for name, text in texts.items() if name in model.model_fields}


def rows(*models: type[BaseModel]) -> Callable[[Schema], None]:
    """For ``json_schema_extra`` of a list of tables that are checked later: each of them is of one of these models."""

    def add(schema: Schema) -> None:
        made = [table_schema(model) for model in models]
        schema["items"] = made[0] if len(made) == 1 else {"anyOf": made}

    return add


def one_or_by_name(model: type[BaseModel]) -> Callable[[Schema], None]:
    """For ``json_schema_extra`` of a table that holds the keys of one model, or tables of it by name."""

    def add(schema: Schema) -> None:
        made = table_schema(model)
        schema.pop("additionalProperties", None)
        schema["anyOf"] = [made, {"type": "object", "additionalProperties": made}]

    return add


def _docstrings(model: type[BaseModel]) -> dict[str, str]:
    """The texts under the keys in the body of a class; none where its source is not at hand."""
    try:
        (body,) = ast.parse(textwrap.dedent(inspect.getsource(model))).body
    except (OSError, TypeError):
        return {}
    assert isinstance(body, ast.ClassDef)
    texts = {}
    for key, below in zip(body.body, body.body[1:], strict=False):
        said = isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant) and isinstance(below.value.value, str)
        if said and isinstance(key, ast.AnnAssign) and isinstance(key.target, ast.Name):
            texts[key.target.id] = ast.literal_eval(below.value)  # type: ignore[attr-defined]
    return texts


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
        return made


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
    """Whether JSON can write a value."""
    if isinstance(value, (list, tuple)):
        return all(map(_is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


def _is_single(value: object, choices: list[Schema]) -> bool:
    """Whether a list of one stands for its only value."""
    return isinstance(value, (list, tuple)) and len(value) == 1 and any(choice.get("type") in ("number", "integer") for choice in choices)


def as_text(schema: Schema) -> str:
    """A schema as a file."""
    return json.dumps(schema, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
