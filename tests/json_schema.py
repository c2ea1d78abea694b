# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of JSON schema (draft 7) that the schema of scenes uses: what is wrong with a value."""

from __future__ import annotations

import operator
import re
from typing import Any

Schema = dict[str, Any]
TYPES = {"object": dict, "array": list, "string": str, "number": (int, float), "integer": int, "boolean": bool}
BOUNDS = {"minimum": operator.ge, "maximum": operator.le, "exclusiveMinimum": operator.gt, "exclusiveMaximum": operator.lt}
TEXTS = {"$schema", "title", "description", "default"}
KNOWN = TEXTS | {
    *BOUNDS, "type", "const", "enum", "anyOf", "oneOf", "if", "else", "properties",
    "required", "additionalProperties", "minProperties", "items", "minItems", "maxItems", "minLength", "maxLength", "pattern",
}  # fmt: skip


def faults(value: Any, schema: Schema | bool, where: str = "") -> list[str]:
    """List the faults of a value; none where it fits. Words of JSON schema that are not known here raise KeyError."""
    if isinstance(schema, bool):
        return [] if schema else [f"{where}: not allowed"]
    if schema.keys() - KNOWN:
        raise KeyError(schema.keys() - KNOWN)
    return [*_of_itself(value, schema, where), *_of_choices(value, schema, where), *_of_inside(value, schema, where)]


def _of_itself(value: Any, schema: Schema, where: str) -> list[str]:
    """Faults by type, constant and bound."""
    kind = schema.get("type")
    kinds = kind if isinstance(kind, list) else [kind]
    fits = any(isinstance(value, TYPES[one]) and not (isinstance(value, bool) and one != "boolean") for one in kinds if one)
    wrong = kind is not None and not fits
    found = [f"{where}: no {kind}"] if wrong else []
    if "const" in schema and value != schema["const"]:
        found.append(f"{where}: not {schema['const']}")
    if "enum" in schema and value not in schema["enum"]:
        found.append(f"{where}: none of {schema['enum']}")
    if isinstance(value, str) and not re.search(schema.get("pattern", ""), value):
        found.append(f"{where}: not of the pattern {schema['pattern']}")
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        found += [f"{where}: {word} {schema[word]}" for word, keeps in BOUNDS.items() if word in schema and not keeps(value, schema[word])]
    sizes = {dict: ("minProperties", ""), list: ("minItems", "maxItems"), str: ("minLength", "maxLength")}
    least, most = sizes.get(type(value), ("", ""))
    if (least and len(value) < schema.get(least, 0)) or (most and len(value) > schema.get(most, len(value))):
        found.append(f"{where}: of length {len(value)}")
    return found


def _of_choices(value: Any, schema: Schema, where: str) -> list[str]:
    """Faults by alternatives and conditions."""
    found = []
    for word in ("anyOf", "oneOf"):
        fits = sum(not faults(value, choice) for choice in schema.get(word, []))
        if word in schema and (fits == 0 or (word == "oneOf" and fits > 1)):
            found.append(f"{where}: {fits} of {word} fit")
    if "if" in schema and faults(value, schema["if"]):
        found += faults(value, schema["else"], where)
    return found


def _of_inside(value: Any, schema: Schema, where: str) -> list[str]:
    """Faults of the keys of a table and of the items of a list."""
    found = []
    if isinstance(value, dict):
        known = schema.get("properties", {})
        found += [f"{where}.{key}: missing" for key in schema.get("required", []) if key not in value]
        for key, inner in value.items():
            found += faults(inner, known.get(key, schema.get("additionalProperties", True)), f"{where}.{key}")
    if isinstance(value, list) and "items" in schema:
        of_each = schema["items"] if isinstance(schema["items"], list) else [schema["items"]] * len(value)
        for i, (inner, own) in enumerate(zip(value, of_each, strict=False)):
            found += faults(inner, own, f"{where}[{i}]")
    return found
