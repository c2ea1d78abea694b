# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of JSON that every reader takes: what is no finite number is null."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.foundation.atomic import replacing


def write_json(path: Path, found: object, digits: int = 0) -> None:
    """Write a file, with so many digits of floats where they are given: a processor that rounds otherwise then writes the same file."""
    with replacing(path) as part:
        text = json.dumps(plain(found, digits), indent=1, ensure_ascii=False, allow_nan=False)
        part.write_text(text + "\n", encoding="utf-8")


def plain(value: Any, digits: int = 0) -> Any:
    """A value as JSON can hold it."""
    if isinstance(value, Mapping):
        return {str(key): plain(one, digits) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(one, digits) for one in value]
    if isinstance(value, float):
        return None if not math.isfinite(value) else float(f"{value:.{digits}g}") if digits else value
    return value
