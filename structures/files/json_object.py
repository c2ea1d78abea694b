# SPDX-License-Identifier: GPL-3.0-or-later
"""The object that a file of JSON holds, of blocks, of fill, of a plan; what is wrong with its text is said by line."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text


def load(path: Path, key: str) -> dict[str, Any]:
    """The object that a JSON file holds, which has a key.

    Raises:
        InputError: one line that names the file and, where the text is at fault, the line.
    """
    try:
        content = json.loads(read_text(path, path.name, "utf-8-sig"), object_pairs_hook=lambda pairs: _once(pairs, path))
    except OSError as failure:
        raise InputError(path.name, f"cannot be read, {failure.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(path.name, "no JSON text") from None
    except json.JSONDecodeError as failure:
        raise InputError(path.name, f"line {failure.lineno}, column {failure.colno}: {failure.msg}") from None
    except InputError:
        raise
    except ValueError:  # of a number that Python does not convert
        raise InputError(path.name, f"a number of more than {sys.get_int_max_str_digits()} digits") from None
    except RecursionError:
        raise InputError(path.name, "lists or objects nested too deep") from None
    if not isinstance(content, dict):
        raise InputError(path.name, f'must be an object with the key "{key}"')
    return content


def _once(pairs: list[tuple[str, Any]], path: Path) -> dict[str, Any]:
    """The object of pairs (key, value): json would take the last of two values silently."""
    made = dict(pairs)
    if len(made) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise InputError(path.name, f'an object with the key "{twice[:40]}" twice')
    return made
